"""Safe, free and cleared ground of maps made by hand."""

import numpy as np
import pytest

from robots.exploration.strategies.three_grids import find_candidates, three_grids
from robots.planning.plan_grid import FREE, OCCUPIED, UNKNOWN, PlanGrid
from robots.planning.travel import travel_costs

CELL_M = 0.1


def corridor(length_m=12.0, wall_at_m=None):
    """A corridor of 1 m along x, free from 1 m to 1 m before its end, walls along it."""
    cells = np.full((14, round(length_m / CELL_M)), UNKNOWN, np.uint8)
    cells[1:-1] = OCCUPIED
    cells[2:-2, 10:-10] = FREE
    if wall_at_m is not None:
        cells[2:-2, round(wall_at_m / CELL_M)] = OCCUPIED
    return PlanGrid(cells, (cells == FREE).astype(np.uint8) * 5, (0.0, 0.0), CELL_M)


def at(x, heading=0.0):
    return np.array([[x, 0.7, heading, 0.0]])


def test_safe_ground_reaches_three_metres_from_where_the_robot_was():
    grids = three_grids(corridor(), at(5.05), 3.0)
    middle = grids.safe[7]
    assert np.flatnonzero(middle).tolist() == list(range(20, 81))
    assert not (grids.safe & ~grids.free).any()
    assert grids.free.sum() == 10 * 100


def test_no_ground_is_safe_behind_a_wall():
    grids = three_grids(corridor(wall_at_m=6.0), at(5.05), 3.0)
    assert not grids.safe[:, 60:].any()
    assert grids.safe[7, 59]


def test_cleared_is_what_lay_ahead():
    grids = three_grids(corridor(), at(5.05), 3.0)
    assert grids.cleared[7, 60]
    assert not grids.cleared[7, 40]
    assert not (grids.cleared & ~grids.safe).any()
    assert three_grids(corridor(), at(5.05, np.pi), 3.0).cleared[7, 40]


def test_candidates_are_the_middles_of_the_free_ground_beyond_and_know_how_much_there_is():
    grid = corridor()
    costs = travel_costs(grid, 7, 50)
    grids = three_grids(grid, at(5.05), 3.0)
    found = find_candidates(grid, costs, grids)
    assert [candidate.area_m2 for candidate in found] == pytest.approx([1.0, 3.0], abs=0.15)
    assert [candidate.goal_m[0] for candidate in found] == pytest.approx([1.5, 9.5], abs=0.15)
    assert [candidate.cost_m for candidate in found] == pytest.approx([3.6, 4.5], abs=0.2)
    total = sum(candidate.area_m2 for candidate in found)
    assert total == pytest.approx((grids.free & ~grids.safe).sum() * CELL_M**2)


def test_what_cannot_be_reached_is_no_candidate():
    grid = corridor()
    grid.steps[:, 85] = 0
    found = find_candidates(grid, travel_costs(grid, 7, 50), three_grids(grid, at(5.05), 3.0))
    assert sorted(candidate.goal_m[0] for candidate in found) == pytest.approx([1.5, 8.4], abs=0.25)
    grid.steps[:, 79:] = 0
    found = find_candidates(grid, travel_costs(grid, 7, 50), three_grids(grid, at(5.05), 3.0))
    assert [candidate.goal_m[0] for candidate in found] == pytest.approx([1.5], abs=0.15)


def test_in_an_open_hall_there_are_many_places_to_go_to_and_the_ground_is_shared_out():
    cells = np.full((160, 160), FREE, np.uint8)
    cells[[0, -1]] = cells[:, [0, -1]] = UNKNOWN
    grid = PlanGrid(cells, (cells == FREE).astype(np.uint8) * 5, (0.0, 0.0), CELL_M)
    grids = three_grids(grid, np.array([[8.0, 8.0, 0.0, 0.0]]), 3.0)
    found = find_candidates(grid, travel_costs(grid, 80, 80), grids)
    assert len(found) >= 4
    assert sum(c.area_m2 for c in found) == pytest.approx(
        (grids.free & ~grids.safe).sum() * CELL_M**2, rel=0.1
    )
    assert {(c.goal_m[0] > 8.0, c.goal_m[1] > 8.0) for c in found} == {
        (a, b) for a in (True, False) for b in (True, False)
    }


def test_with_all_ground_safe_there_is_nowhere_to_go():
    grid = corridor()
    everywhere = np.concatenate([at(x) for x in np.arange(1.0, 11.0, 1.0)])
    grids = three_grids(grid, everywhere, 3.0)
    assert find_candidates(grid, travel_costs(grid, 7, 50), grids) == ()
