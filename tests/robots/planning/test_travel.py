"""Ways round walls, out of tight corners, and where there is none."""

import numpy as np
import pytest

from robots.planning.plan_grid import PlanGrid
from robots.planning.travel import UNREACHED, find_path, travel_costs


def grid_of(*rows: str) -> PlanGrid:
    """Ground from text, the first row at the top as on paper: '.' open, '~' tight, '#' impassable."""
    steps = np.array([[{".": 5, "~": 15, "#": 0}[c] for c in row] for row in rows][::-1], np.uint8)
    return PlanGrid(np.ones(steps.shape, np.uint8), steps, (0.0, 0.0), 0.1)


def test_straight_and_diagonal_moves_in_the_open():
    grid = grid_of(*["." * 9] * 9)
    costs = travel_costs(grid, 0, 0)
    assert costs[0, 8] == 8 * 5
    assert costs[8, 8] == 8 * 7
    assert costs[3, 8] == 3 * 7 + 5 * 5


def test_the_way_leads_round_a_wall():
    grid = grid_of(
        ".........",
        ".........",
        "#######..",
        ".........",
    )
    path = find_path(grid, (0, 0), (2, 0))
    assert len(path) > 12
    assert all(grid.steps[row, column] for row, column in path)
    assert path[:, 1].max() == 7


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
        "##........",
        "##........",
    )
    costs = travel_costs(grid, 0, 0)
    assert costs[0, 0] == 0
    assert costs[0, 1] == 15
    assert costs[0, 2] == 15 + 5
    assert find_path(grid, (0, 0), (0, 2)) is not None


def test_but_no_farther_than_three_cells():
    grid = grid_of("####.", "####.")
    assert travel_costs(grid, 0, 0)[0, 4] == 3 * 15 + 5
    assert travel_costs(grid_of("#####."), 0, 0)[0, 5] == UNREACHED


@pytest.mark.parametrize("outside", [(-1, 0), (0, -1), (3, 0), (0, 3)])
def test_from_or_to_outside_the_grid_there_is_no_way(outside):
    grid = grid_of("...", "...", "...")
    assert (travel_costs(grid, *outside) == UNREACHED).all()
    assert find_path(grid, outside, (1, 1)) is None
    assert find_path(grid, (1, 1), outside) is None


def test_staying_is_a_path_of_one_cell():
    np.testing.assert_array_equal(find_path(grid_of("..", ".."), (1, 1), (1, 1)), [[1, 1]])


def test_large_ground_fills_and_refills_the_buckets():
    """Many cells of one cost at once: more than a bucket holds at first."""
    grid = PlanGrid(np.ones((700, 700), np.uint8), np.full((700, 700), 5, np.uint8), (0.0, 0.0), 0.1)
    costs = travel_costs(grid, 350, 350)
    rows, columns = np.abs(np.indices((700, 700)) - 350)
    far, near = np.maximum(rows, columns), np.minimum(rows, columns)
    np.testing.assert_array_equal(costs, 5 * (far - near) + 7 * near)
