"""Way driven over slippery floor: none of the alarms alone decides, and the truth lies within the doubt."""

import numpy as np
import pytest

from robots.estimation.slip.patches import Slippage

STEP_M, STEP_S = 0.03, 0.05


def told(alarms) -> tuple[float, float]:
    slippage, way, variance = Slippage(), 0.0, 0.0
    for k, alarm in enumerate(alarms):
        grip = slippage.observe(k * STEP_S, STEP_M, bool(alarm))
        way += grip.share * STEP_M
        variance += grip.variance_m2
    return way, variance


def test_lone_alarms_take_no_way_off():
    alarms = np.arange(400) % 40 == 7
    assert told(alarms) == (pytest.approx(400 * STEP_M), 0.0)


def test_a_patch_of_which_half_alarms_counts_as_a_whole_by_a_third_and_with_all_doubt():
    way, variance = told(np.arange(200) % 2 == 0)
    before_m, rolled_m = 2 * STEP_M, 198 * STEP_M  # the first alarm alone tells nothing
    assert way == pytest.approx(before_m + rolled_m / 3.0)
    assert variance == pytest.approx(rolled_m**2 / 18.0)


def test_patches_are_doubted_each_by_itself():
    patch, grip = np.ones(100, bool), np.zeros(100, bool)  # 5 s each
    _, one = told(np.concatenate([patch, grip]))
    _, two = told(np.concatenate([patch, grip, patch, grip]))
    assert two == pytest.approx(2.0 * one, rel=0.1)
