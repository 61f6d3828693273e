"""Ways round walls, out of tight corners, and where there is none."""

import numpy as np
import pytest

from robots.planning.plan_grid import FREE, OCCUPIED, UNKNOWN, PlanGrid
from robots.planning.travel import UNREACHED, find_path, travel_costs


def grid_of(*rows: str) -> PlanGrid:
    """Ground from text, the first row at the top as on paper.

    '.' is open, '~' narrow, 'x' too narrow for the body, '#' occupied, '?' unknown.
    """
    text = np.array([list(row) for row in rows][::-1])
    cells = np.select([text == "#", text == "?"], [OCCUPIED, UNKNOWN], FREE).astype(np.uint8)
    steps = np.select([text == ".", text == "~"], [5, 15], 0).astype(np.uint8)
    return PlanGrid(cells, steps, (0.0, 0.0), 0.1)


def test_straight_and_diagonal_moves_in_the_open():
    grid = grid_of(*["." * 9] * 9)
    costs = travel_costs(grid, 0, 0)
    assert costs[0, 8] == 8 * 5
    assert costs[8, 8] == 8 * 7
    assert costs[3, 8] == 3 * 7 + 5 * 5


def test_the_way_leads_round_a_wall():
    grid = grid_of(
        ".........",
        "#######..",
        "#######..",
        "#######..",
        "#######..",
        ".........",
    )
    path = find_path(grid, (0, 0), (5, 0))
    assert all(grid.steps[row, column] for row, column in path)
    assert len(path) == 18


def test_open_ground_is_worth_a_detour_round_tight_ground():
    grid = grid_of(
        "...........",
        ".~~~~~~~~~.",
        ".~~~~~~~~~.",
    )
    path = find_path(grid, (0, 0), (0, 10))
    assert (2, 5) in {tuple(cell) for cell in path}


def test_behind_closed_walls_nothing_is_reached():
    grid = grid_of(
        "....#....",
        "....#....",
        "....#....",
    )
    costs = travel_costs(grid, 1, 0)
    assert (costs[:, :4] < UNREACHED).all()
    assert (costs[:, 4:] == UNREACHED).all()
    assert find_path(grid, (1, 0), (1, 8)) is None


def test_a_robot_that_stands_too_close_to_something_may_leave_dearly():
    grid = grid_of(
        "..........",
        "..........",
        "xx........",
        "#x........",
    )
    costs = travel_costs(grid, 0, 0)
    assert costs[0, 0] == 0
    assert costs[0, 1] == 15
    assert costs[0, 2] == 15 + 5
    assert find_path(grid, (0, 0), (0, 2)) is not None


def test_but_no_farther_than_three_cells():
    grid = grid_of("xxxx.", "xxxx.")
    assert travel_costs(grid, 0, 0)[0, 4] == 3 * 15 + 5
    assert travel_costs(grid_of("xxxxx."), 0, 0)[0, 5] == UNREACHED


@pytest.mark.parametrize("barrier", ["#", "?"])
def test_and_not_through_a_wall_or_the_unknown(barrier):
    grid = grid_of(f"x{barrier}x..", f"x{barrier}x..")
    costs = travel_costs(grid, 0, 0)
    assert costs[1, 0] == 15
    assert (costs[:, 1:] == UNREACHED).all()
    assert find_path(grid, (0, 0), (0, 4)) is None


@pytest.mark.parametrize("outside", [(-1, 0), (0, -1), (3, 0), (0, 3)])
def test_from_or_to_outside_the_grid_there_is_no_way(outside):
    grid = grid_of("...", "...", "...")
    assert (travel_costs(grid, *outside) == UNREACHED).all()
    assert find_path(grid, outside, (1, 1)) is None
    assert find_path(grid, (1, 1), outside) is None


def test_staying_is_a_path_of_one_cell():
    np.testing.assert_array_equal(find_path(grid_of("..", ".."), (1, 1), (1, 1)), [[1, 1]])


def test_large_ground_fills_and_refills_the_buckets():
    """More cells of one cost than a bucket holds at first; each costs what its best neighbour leads to."""
    size, middle = 2000, 1000
    steps = np.full((size, size), 5, np.uint8)
    steps[np.random.default_rng(4).random(steps.shape) < 0.1] = 0
    steps[middle - 4 : middle + 5, middle - 4 : middle + 5] = 5
    cells = np.where(steps > 0, FREE, OCCUPIED).astype(np.uint8)
    costs = travel_costs(PlanGrid(cells, steps, (0.0, 0.0), 0.1), middle, middle)
    assert np.bincount(costs[costs < UNREACHED]).max() > 1024
    ahead = np.pad(costs.astype(np.int64), 1, constant_values=UNREACHED)
    best = np.full(costs.shape, UNREACHED, np.int64)
    for dr, dc in ((dr, dc) for dr in (0, 1, 2) for dc in (0, 1, 2) if (dr, dc) != (1, 1)):
        best = np.minimum(best, ahead[dr : dr + size, dc : dc + size] + (7 if dr != 1 and dc != 1 else 5))
    best[steps == 0] = UNREACHED
    best[middle, middle] = 0
    np.testing.assert_array_equal(costs, best)
