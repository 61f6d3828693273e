"""Way driven over slippery floor: no share alone decides, and later ones tell of earlier way."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.estimation.slip.patches import UNKNOWN, Slippage

STEP_M, STEP_S = 0.03, 0.05
GRIP, PATCH = 0.09, 0.75  # what the trees say of most moments of either


def told(shares, rolled_m=None) -> tuple[float, float]:
    slippage, way, variance = Slippage(), 0.0, 0.0
    rolled_m = np.full(len(shares), STEP_M) if rolled_m is None else rolled_m
    for k, share in enumerate(shares):
        grip = slippage.observe(k * STEP_S, rolled_m[k], share)
        way += grip.share * rolled_m[k]
        variance += grip.variance_m2
    return way, variance


def test_lone_shares_take_no_way_off():
    shares = np.where(np.arange(400) % 40 == 7, 0.93, GRIP)
    assert told(shares) == (pytest.approx(400 * STEP_M), 0.0)


def test_who_knows_nothing_counts_what_was_rolled():
    assert told(np.full(400, UNKNOWN)) == (pytest.approx(400 * STEP_M), 0.0)


def test_a_patch_that_never_alarms_counts_by_a_third_from_its_beginning_to_its_end():
    shares = np.concatenate([np.full(100, GRIP), np.full(80, PATCH), np.full(100, GRIP)])
    way, variance = told(shares)
    assert way == pytest.approx((200 + 80 / 3.0) * STEP_M, abs=6 * STEP_M)
    assert variance == pytest.approx((80 * STEP_M) ** 2 / 18.0, rel=0.2)


def test_patches_are_doubted_each_by_itself():
    patch, grip = np.full(100, 0.9), np.full(100, GRIP)  # 5 s each
    _, one = told(np.concatenate([patch, grip]))
    _, two = told(np.concatenate([patch, grip, patch, grip]))
    assert two == pytest.approx(2.0 * one, rel=0.1)


def test_way_that_is_put_right_while_the_robot_stands_is_not_lost():
    shares = np.concatenate([np.full(60, GRIP), np.full(60, 0.9), np.full(40, GRIP)])
    rolled_m = np.full(160, STEP_M)
    driven, _ = told(shares, rolled_m)
    rolled_m[74:80] = 0.0  # it stands as the patch is found out
    stood, _ = told(shares, rolled_m)
    assert stood == pytest.approx(driven - 6 * STEP_M / 3.0, abs=2 * STEP_M)


@given(st.lists(st.sampled_from([GRIP, UNKNOWN, PATCH, 0.93]), min_size=1, max_size=150))
def test_the_way_lies_between_a_third_and_all_of_what_was_rolled(shares):
    way, variance = told([*shares, *[GRIP] * 40])
    rolled = (len(shares) + 40) * STEP_M
    assert rolled / 3.0 - 1e-9 <= way <= rolled + 1e-9
    assert 0.0 <= variance <= rolled**2 / 18.0 + 1e-9


def test_a_gap_in_time_begins_anew():
    slippage = Slippage()
    for k in range(60):
        slippage.observe(k * STEP_S, STEP_M, 0.9)
    assert slippage.on_patch
    grip = slippage.observe(60.0, STEP_M, UNKNOWN)
    assert (grip.share, grip.variance_m2, slippage.on_patch) == (1.0, 0.0, False)
