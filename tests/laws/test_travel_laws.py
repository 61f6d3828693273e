"""Costs and paths against SciPy's Dijkstra on random ground."""

from itertools import pairwise

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from robots.planning.plan_grid import FREE, OCCUPIED, UNKNOWN, PlanGrid
from robots.planning.travel import UNREACHED, find_path, travel_costs

LEAVE_CELLS, LEAVE_COST = 3, 15  # near the start the body may drive where it does not fit


@st.composite
def grounds(draw):
    """Ground with obstacles, holes of unknown and cells too tight for the body, and two cells of it."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    shape = tuple(rng.integers(1, 26, 2))
    cells = np.full(shape, FREE, np.uint8)
    cells[rng.random(shape) < draw(st.sampled_from([0.0, 0.2, 0.4]))] = OCCUPIED
    cells[rng.random(shape) < draw(st.sampled_from([0.0, 0.1]))] = UNKNOWN
    steps = np.where(cells == FREE, rng.integers(5, 16, shape), 0).astype(np.uint8)
    steps[rng.random(shape) < draw(st.sampled_from([0.0, 0.2, 0.4]))] = 0
    ends = [(int(rng.integers(shape[0])), int(rng.integers(shape[1]))) for _ in range(2)]
    return PlanGrid(cells, steps, (0.0, 0.0), 0.1), *ends


def entering(grid: PlanGrid, start: tuple[int, int]) -> np.ndarray:
    """Cost of entering each cell straight, 0 where that is not possible."""
    rows, columns = np.indices(grid.steps.shape)
    near = np.maximum(np.abs(rows - start[0]), np.abs(columns - start[1])) <= LEAVE_CELLS
    # a robot that stands on what the map takes for an obstacle may leave over anything
    tight = (grid.steps == 0) & ((grid.cells == FREE) | (grid.cells[start] != FREE))
    return np.where(tight & near, LEAVE_COST, grid.steps.astype(int))


def move_cost(enter: int, diagonal: bool) -> int:
    return enter * 7 // 5 if diagonal else enter


def reference(grid: PlanGrid, start: tuple[int, int]) -> np.ndarray:
    enter = entering(grid, start)
    h, w = enter.shape
    number = np.arange(h * w).reshape(h, w)
    sources, targets, costs = [], [], []
    for dr, dc in ((dr, dc) for dr in (-1, 0, 1) for dc in (-1, 0, 1) if (dr, dc) != (0, 0)):
        ends = (slice(max(0, dr), h + min(0, dr)), slice(max(0, dc), w + min(0, dc)))
        begins = (slice(max(0, -dr), h + min(0, -dr)), slice(max(0, -dc), w + min(0, -dc)))
        open_end = enter[ends] > 0
        sources.append(number[begins][open_end])
        targets.append(number[ends][open_end])
        costs.append(move_cost(enter[ends][open_end], dr != 0 and dc != 0))
    graph = coo_matrix(
        (np.concatenate(costs), (np.concatenate(sources), np.concatenate(targets))), (h * w, h * w)
    )
    found = dijkstra(graph.tocsr(), indices=number[start]).reshape(h, w)
    return np.where(np.isfinite(found), found, UNREACHED).astype(np.int64)


@given(grounds())
@settings(max_examples=150)
def test_travel_costs_are_dijkstras(ground):
    grid, start, _ = ground
    np.testing.assert_array_equal(travel_costs(grid, *start), reference(grid, start))


@given(grounds())
@settings(max_examples=150)
def test_the_path_costs_what_the_flood_says_and_is_a_way(ground):
    grid, start, goal = ground
    cost = travel_costs(grid, *start)[goal]
    path = find_path(grid, start, goal)
    if cost == UNREACHED:
        assert path is None
        return
    assert tuple(path[0]) == start
    assert tuple(path[-1]) == goal
    enter = entering(grid, start)
    total = 0
    for before, after in pairwise(path):
        assert np.abs(after - before).max() == 1
        assert enter[tuple(after)] > 0
        total += move_cost(int(enter[tuple(after)]), bool((after != before).all()))
    assert total == cost


@given(grounds())
def test_a_cell_costs_no_more_than_any_way_through_another(ground):
    """The triangle inequality, on ground where the start has no privileges."""
    grid, start, goal = ground
    fits = np.maximum(grid.steps, 5)
    grid = PlanGrid(grid.cells, fits.astype(np.uint8), grid.origin, grid.cell_m)
    from_start, from_goal = travel_costs(grid, *start), travel_costs(grid, *goal)
    assert (from_start <= from_start[goal] + from_goal.astype(np.int64)).all()
