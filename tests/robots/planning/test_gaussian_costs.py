"""Eq. (6) of Ziparo 2007 on grids made by hand."""

import numpy as np
import pytest

from robots.exploration.settings import ZiparoConfig
from robots.planning.gaussian_costs import with_gaussian_costs
from robots.planning.plan_grid import FREE, OCCUPIED, PlanGrid
from robots.planning.travel import find_path


def hall():
    """A hall of 6 m by 6 m with a pillar in the middle that the body just passes at 0.3 m."""
    cells = np.full((60, 60), FREE, np.uint8)
    cells[28:32, 28:32] = OCCUPIED
    steps = np.full((60, 60), 5, np.uint8)
    steps[25:35, 25:35] = 0
    return PlanGrid(cells, steps, (0.0, 0.0), 0.1)


def test_costs_are_the_length_in_the_open_and_rise_towards_obstacles():
    grid = with_gaussian_costs(hall(), ZiparoConfig(10.0, 0.2))
    assert grid.steps[0, 0] == 5
    row = grid.steps[30, 35:45].astype(int)
    assert (np.diff(row) <= 0).all()
    assert 5 < row[0] <= 15
    occ = 10.0 * sum(
        np.exp(-((35 - c) ** 2 + (30 - r) ** 2) * 0.01 / 0.08) * 0.01 / (2 * np.pi * 0.04)
        for r in range(28, 32) for c in range(28, 32)
    )  # fmt: skip
    assert row[0] == pytest.approx(5.0 * (1.0 + occ), abs=0.6)


def test_what_cannot_be_entered_still_cannot_and_nothing_is_free_of_charge():
    grid = with_gaussian_costs(hall(), ZiparoConfig(1e3, 0.2))
    assert (grid.steps[25:35, 25:35] == 0).all()
    assert grid.steps.max() == 15
    assert ((grid.steps >= 5) == (hall().steps > 0)).all()


def test_ways_keep_away_from_obstacles_and_without_alpha_they_do_not():
    def nearest(alpha):
        path = find_path(with_gaussian_costs(hall(), ZiparoConfig(alpha, 0.3)), (30, 5), (30, 55))
        return np.abs(path - 29.5).max(axis=1).min()

    assert nearest(20.0) > nearest(0.0)
