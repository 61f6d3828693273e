"""Frontiers against SciPy's labelling and a search through every cell."""

import numpy as np
import pytest
from scipy.ndimage import label

from robots.exploration.frontiers import _APPROACH, Frontier, find_frontiers, find_shut_off
from robots.planning.plan_grid import FREE, OCCUPIED, UNKNOWN, PlanGrid
from robots.planning.travel import UNREACHED, travel_costs

CELL_M = 0.1


def grid_of(cells: np.ndarray, steps: np.ndarray | None = None) -> PlanGrid:
    if steps is None:
        steps = np.where(cells == FREE, 5, 0).astype(np.uint8)
    return PlanGrid(cells, steps, (-1.0, 2.0), CELL_M)


def random_grid(seed: int) -> PlanGrid:
    """Known ground that ends in shreds, with obstacles, part of it too tight for the body."""
    rng = np.random.default_rng(seed)
    cells = np.full((45, 55), UNKNOWN, np.uint8)
    for _ in range(6):
        r, c = rng.integers(0, 35, 2)
        cells[r : r + rng.integers(5, 20), c : c + rng.integers(5, 20)] = FREE
    for _ in range(10):
        r, c = rng.integers(0, 45, 2)
        cells[r : r + rng.integers(1, 8), c : c + 2] = OCCUPIED
    steps = np.where(cells == FREE, rng.integers(5, 16, cells.shape), 0).astype(np.uint8)
    steps[rng.random(cells.shape) < 0.15] = 0
    return grid_of(cells, steps)


def border(cells: np.ndarray) -> np.ndarray:
    """Free cells beside an unknown one, apart from the rim of the grid."""
    touches = np.zeros(cells.shape, bool)
    for row in range(1, cells.shape[0] - 1):
        for column in range(1, cells.shape[1] - 1):
            beside = cells[[row - 1, row + 1, row, row], [column, column, column - 1, column + 1]]
            touches[row, column] = cells[row, column] == FREE and (beside == UNKNOWN).any()
    return touches


def in_sight(cells: np.ndarray, a: np.ndarray, b: np.ndarray) -> bool:
    """Whether no obstacle lies on the straight line of cells from one to the other."""
    line = np.round(np.linspace(a, b, max(2, int(np.abs(b - a).max()) + 1))).astype(int)
    return not (cells[tuple(line[1:-1].T)] == OCCUPIED).any()


def nearest_access(
    cell: tuple[int, int], costs: np.ndarray, cells: np.ndarray
) -> tuple[int, tuple[int, int]] | None:
    """Cheapest reachable cell of the nearest square ring round a cell that has one in sight of it."""
    rows, columns = np.indices(costs.shape)
    ring = np.maximum(np.abs(rows - cell[0]), np.abs(columns - cell[1]))
    for reach in range(_APPROACH + 1):
        found = np.argwhere((ring == reach) & (costs != UNREACHED))
        found = [at for at in found if in_sight(cells, np.array(cell), at)]
        if found:
            return min((int(costs[tuple(at)]), tuple(int(v) for v in at)) for at in found)
    return None


def brute_force(grid: PlanGrid, costs: np.ndarray, min_length_m: float) -> list[tuple[float, float]]:
    """Cost and length of every frontier, in metres, nearest first."""
    labels, count = label(border(grid.cells), np.ones((3, 3)))
    found = []
    for k in range(1, count + 1):
        cells = [tuple(int(v) for v in at) for at in np.argwhere(labels == k)]
        access = [a for a in (nearest_access(cell, costs, grid.cells) for cell in cells) if a is not None]
        if access and len(cells) * CELL_M >= min_length_m:
            found.append((min(access)[0] / 5.0 * CELL_M, len(cells) * CELL_M))
    return sorted(found)


def pairs(frontiers: tuple[Frontier, ...]) -> list[tuple[float, float]]:
    return sorted((f.cost_m, f.length_m) for f in frontiers)


@pytest.mark.parametrize("seed", range(10))
def test_frontiers_are_those_of_a_brute_force(seed):
    grid = random_grid(seed)
    start = tuple(int(v) for v in np.argwhere(grid.steps > 0)[0])
    costs = travel_costs(grid, *start)
    for min_length_m in (0.0, 0.55):
        expected = brute_force(grid, costs, min_length_m)
        assert expected
        found = find_frontiers(grid, costs, min_length_m)
        np.testing.assert_allclose(pairs(found), expected)
        assert [f.cost_m for f in found] == sorted(f.cost_m for f in found)
        for frontier in found:
            assert costs[frontier.goal] / 5.0 * CELL_M == pytest.approx(frontier.cost_m)
            assert grid.cell_of(*frontier.goal_m) == frontier.goal
            near = np.argwhere(border(grid.cells)) - frontier.goal
            assert np.abs(near).max(axis=1).min() <= _APPROACH


def half_known() -> np.ndarray:
    """A walled room of 2 m by 3 m of which the right end is still unknown."""
    cells = np.full((20, 30), OCCUPIED, np.uint8)
    cells[1:-1, 1:20] = FREE
    cells[1:-1, 20:-1] = UNKNOWN
    return cells


def test_a_half_seen_room_has_one_frontier_where_the_seen_ends():
    grid = grid_of(half_known())
    (frontier,) = find_frontiers(grid, travel_costs(grid, 10, 5), 0.5)
    assert frontier.goal == (10, 19)
    assert frontier.length_m == pytest.approx(1.8)
    assert frontier.cost_m == pytest.approx(1.4)
    assert frontier.goal_m == pytest.approx((-1.0 + 1.95, 2.0 + 1.05))


def test_an_edge_is_not_looked_at_through_a_wall():
    cells = np.full((21, 21), UNKNOWN, np.uint8)
    cells[1:10, 1:20] = FREE  # a room, its wall with a door, and beyond it what was seen through the door
    cells[10, 1:20] = OCCUPIED
    cells[10, 12:15] = FREE
    cells[11:15, 6:15] = FREE
    cells[0] = cells[:, 0] = cells[:, 20] = OCCUPIED
    steps = np.where(cells == FREE, 5, 0).astype(np.uint8)
    steps[8:13, :12] = 0  # too near to the wall for the body
    grid = grid_of(cells, steps)
    (frontier,) = find_frontiers(grid, travel_costs(grid, 4, 6), 0.5)
    assert frontier.goal[0] > 10
    cells[10, 12:15] = OCCUPIED  # with the door shut, there is no place to look from
    shut = grid_of(cells, np.where(cells == FREE, steps, 0).astype(np.uint8))
    costs = travel_costs(shut, 4, 6)
    assert find_frontiers(shut, costs, 0.5) == ()
    assert len(find_shut_off(shut, costs, 0.5)) == 1


def test_a_room_that_is_all_seen_has_none():
    cells = half_known()
    cells[cells == UNKNOWN] = FREE
    grid = grid_of(cells)
    assert find_frontiers(grid, travel_costs(grid, 10, 5), 0.0) == ()


def test_an_edge_that_cannot_be_reached_or_is_too_short_is_none():
    cells = half_known()
    cells[:, 8:14] = OCCUPIED
    grid = grid_of(cells)
    costs = travel_costs(grid, 10, 4)
    assert find_frontiers(grid, costs, 0.5) == ()
    assert len(find_frontiers(grid, travel_costs(grid, 10, 17), 1.8)) == 1
    assert find_frontiers(grid, travel_costs(grid, 10, 17), 1.9) == ()


def test_where_the_body_does_not_fit_the_goal_lies_as_near_as_it_can_get():
    cells = half_known()
    steps = np.where(cells == FREE, 5, 0).astype(np.uint8)
    steps[:, 15:] = 0  # the last five columns are too tight
    grid = grid_of(cells, steps)
    (frontier,) = find_frontiers(grid, travel_costs(grid, 10, 5), 0.5)
    assert frontier.goal == (10, 14)
    steps[:, 14:] = 0  # and here it is too far away
    grid = grid_of(cells, steps)
    assert find_frontiers(grid, travel_costs(grid, 10, 5), 0.5) == ()


def test_an_edge_that_is_shut_off_is_told_by_its_middle_and_length():
    cells = half_known()
    cells[:, 8:14] = OCCUPIED
    grid = grid_of(cells)
    costs = travel_costs(grid, 10, 4)
    (((row, column), length_m),) = find_shut_off(grid, costs, 0.5)
    assert (row, column) in ((9, 19), (10, 19))
    assert length_m == pytest.approx(1.8)
    assert find_shut_off(grid, costs, 1.9) == ()


@pytest.mark.parametrize("seed", range(4))
def test_every_long_enough_edge_is_either_reached_or_shut_off(seed):
    grid = random_grid(seed)
    costs = travel_costs(grid, *(int(v) for v in np.argwhere(grid.steps > 0)[0]))
    labels, count = label(border(grid.cells), np.ones((3, 3)))
    long_enough = sum((labels == k).sum() * CELL_M >= 0.35 for k in range(1, count + 1))
    reached, shut_off = find_frontiers(grid, costs, 0.35), find_shut_off(grid, costs, 0.35)
    assert len(reached) + len(shut_off) == long_enough
    assert all(costs[cell] == UNREACHED for cell, _ in shut_off)
