"""Which robots of a recording take part, and in which order."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.datasets.recording import RecordingError
from robots.datasets.selection import choose_robots

THERE = ("r1", "r2", "r3", "r4", "r5")


@pytest.mark.parametrize(
    ("robots", "order", "expected"),
    [
        (None, None, THERE),
        ("2", None, ("r1", "r2")),
        ("r4, r1", None, ("r1", "r4")),
        ("r5", "r5", ("r5",)),
        (None, "r3,r1", ("r3", "r1", "r2", "r4", "r5")),
        ("3", "r3,r1", ("r3", "r1", "r2")),
    ],
)
def test_robots_are_chosen_and_put_in_order(robots, order, expected):
    assert choose_robots(THERE, robots, order) == expected


def test_a_name_that_is_a_number_is_a_name():
    assert choose_robots(("7", "8"), "8", None) == ("8",)


@given(st.permutations(THERE), st.integers(1, 5))
def test_an_order_loses_nobody(order, count):
    chosen = choose_robots(THERE, str(count), None)
    ordered = choose_robots(THERE, str(count), ",".join(name for name in order if name in chosen))
    assert sorted(ordered) == sorted(chosen)


@pytest.mark.parametrize(
    ("robots", "order", "message"),
    [
        ("6", None, "--robots 6: the recording has 5: r1, r2, r3, r4, r5"),
        ("0", None, "--robots 0: the recording has 5"),
        ("9" * 4000, None, "--robots 9+: the recording has 5"),
        ("-1", None, "there is no robot '-1'; there are r1"),
        ("r1,", None, "there is no robot ''"),
        ("r1,r1", None, "--robots names r1 twice"),
        (None, "r2,r2", "--order names r2 twice"),
        ("r1,r2", "r3", "--order: there is no robot 'r3'; there are r1, r2"),
    ],
)
def test_what_cannot_be_chosen_is_named(robots, order, message):
    with pytest.raises(RecordingError, match=message):
        choose_robots(THERE, robots, order)
