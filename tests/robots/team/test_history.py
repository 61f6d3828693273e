"""Where a robot was, between its steps, whatever order they came in."""

from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.se2 import Pose2
from robots.team import history
from robots.team.history import History


def walked(order: list[int]) -> History:
    steps = History()
    for seq in order:
        steps.put(seq, 1.0 * seq, seq // 10, Pose2(0.3 * (seq % 10), 0.0, 0.1))
    return steps


def test_between_two_steps_it_is_between_them():
    there = walked(list(range(30))).at(3.4)
    assert there is not None
    assert (there.anchor, there.anchor_from_base.x) == (0, pytest.approx(1.02))
    assert there.anchor_from_base.theta == pytest.approx(0.1)
    assert 0.02 < there.sd_m < 0.2


def test_across_an_anchor_the_nearer_step_counts():
    near = walked(list(range(30))).at(9.8)
    assert near is not None
    assert (near.anchor, near.anchor_from_base.x) == (1, 0.0)


@pytest.mark.parametrize("stamp", [-5.0, 40.0, float("nan"), float("inf")])
def test_far_outside_nothing_is_known(stamp):
    assert walked(list(range(30))).at(stamp) is None
    assert History().at(1.0) is None


def test_a_step_that_is_not_finite_is_left_out():
    steps = walked(list(range(30)))
    steps.put(99, float("nan"), 0, Pose2())
    steps.put(98, 3.0, 0, Pose2(float("inf"), 0.0, 0.0))
    assert steps.at(3.0) == walked(list(range(30))).at(3.0)


@given(st.integers(0, 10**9), st.integers(2, 40))
def test_the_order_does_not_matter_even_where_memory_ends(seed, most):
    order = list(range(200))
    Random(seed).shuffle(order)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(history, "_MOST", most)
        mixed, straight = walked(order), walked(sorted(order))
        assert len(mixed._steps) <= most
        for stamp in (0.0, 17.3, 55.5, 120.1, 199.0):
            assert mixed.at(stamp) == straight.at(stamp)
