"""How far it is through ground that others have covered to ground that nobody has told of.

Nothing is known of the walls there, so the way is a lower bound: through claimed ground in any direction, and
from closed cells to unseen ones never, since there a wall stands between.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robots.exploration.told.survey import LATTICE_M, Survey
from robots.planning.plan_grid import FREE, OCCUPIED, PlanGrid
from robots.se2 import Array
from robots.tags.memory import CLOSED, OPEN

_KNOWN, _TOLD, _RIM, _NEWS, _WALL = 0, 1, 2, 3, 4


def ways_beyond(
    grid: PlanGrid,
    survey: Survey,
    cells: NDArray[np.int64],
    most_m: float,
    handicaps_m: Array | None = None,
) -> Array:
    """Return the way from cells (n, 2) of a grid to the best ground nobody has told of, (n,), in metres.

    ``handicaps_m`` (r, c) is added to the way to a cell of the survey's lattice; without them the nearest is
    best. ``most_m`` where it comes to more, or where others have told of all that can be reached.
    """
    if not survey.claimed.any() or len(cells) == 0:
        return np.zeros(len(cells))
    told = np.where(survey.left_out(), CLOSED, survey.claimed)
    handicaps = np.zeros(told.shape) if handicaps_m is None else handicaps_m / grid.cell_m
    per_cell = grid.cell_m / LATTICE_M
    ways = _flood(
        _kinds(grid.cells, told.astype(np.uint8), per_cell), handicaps, per_cell, most_m / grid.cell_m
    )
    found: Array = ways[cells[:, 0], cells[:, 1]] * grid.cell_m
    return found


@njit(cache=True)
def _kinds(cells: NDArray[np.uint8], claimed: NDArray[np.uint8], per_cell: float) -> NDArray[np.uint8]:
    """Return what each cell of the grid is to this robot and those it has read."""
    kinds = np.empty(cells.shape, np.uint8)
    for r in range(cells.shape[0]):
        for c in range(cells.shape[1]):
            if cells[r, c] == FREE:
                kinds[r, c] = _KNOWN
            elif cells[r, c] == OCCUPIED:
                kinds[r, c] = _WALL
            else:
                told = claimed[int((r + 0.5) * per_cell), int((c + 0.5) * per_cell)]
                kinds[r, c] = _TOLD if told == CLOSED else _RIM if told == OPEN else _NEWS
    return kinds


@njit(cache=True)
def _flood(kinds: NDArray[np.uint8], handicaps: Array, per_cell: float, most: float) -> Array:
    """Return the way from each cell to the best news, in cells, by sweeps until one changes nothing.

    From known ground into news or told ground, through told ground to its rim, never from it into news.
    """
    rows, columns = kinds.shape
    ways = np.full((rows, columns), most)
    begins = np.zeros(rows + 1, np.int64)  # of each row, among the cells whose way has to be found
    sought = np.empty(rows * columns, np.int64)  # their columns
    count = 0
    for r in range(rows):
        for c in range(columns):
            if kinds[r, c] == _NEWS or kinds[r, c] == _RIM:
                ways[r, c] = min(most, handicaps[int((r + 0.5) * per_cell), int((c + 0.5) * per_cell)])
            if kinds[r, c] != _NEWS and kinds[r, c] != _WALL:
                sought[count] = c
                count += 1
        begins[r + 1] = count
    sweep, changed = 0, True
    while changed:
        changed = False
        for i in range(rows):
            r = i if sweep & 1 == 0 else rows - 1 - i
            first, end = begins[r], begins[r + 1]
            for j in range(end - first):
                c = sought[first + j] if sweep & 2 == 0 else sought[end - 1 - j]
                best = _best_next(kinds, ways, r, c)
                if best < ways[r, c] - 1e-9:
                    ways[r, c] = best
                    changed = True
        sweep += 1
    return ways


@njit(cache=True)
def _best_next(kinds: NDArray[np.uint8], ways: Array, r: int, c: int) -> float:
    """Return the best way from a cell by way of those next to it, or what it has."""
    rows, columns = kinds.shape
    best: float = ways[r, c]
    for v in range(max(0, r - 1), min(rows, r + 2)):
        for u in range(max(0, c - 1), min(columns, c + 2)):
            if kinds[v, u] == _WALL or (kinds[r, c] != _KNOWN and kinds[v, u] == _NEWS):
                continue
            best = min(best, ways[v, u] + (1.41 if v != r and u != c else 1.0))
    return best
