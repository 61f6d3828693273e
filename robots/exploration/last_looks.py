"""What is looked at before a robot says that nothing is left: gaps too short for edges of the unknown.

A gap may be the noise of a map, a beam that missed a wall, or the only sight into a niche that nobody enters.
It is worth a look from where more of the unknown can be seen through it than a map's noise hides.
"""

from __future__ import annotations

from math import ceil, cos, floor, pi, sin

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robots.exploration.frontiers import Frontier, find_frontiers
from robots.exploration.ground import Ground
from robots.planning.plan_grid import OCCUPIED, UNKNOWN
from robots.planning.travel import UNREACHED

_REACH_M, _ROUND_M = 3.0, 1.5
_WORTH_M2 = 0.5  # of the unknown in sight


def gaps(ground: Ground, below_m: float) -> tuple[Frontier, ...]:
    """Return the borders to the unknown shorter than ``below_m`` that are worth a look, nearest first."""
    grid, found = ground.grid, []
    for gap in find_frontiers(grid, ground.costs, 0.0):
        if gap.length_m < below_m:
            row, column, seen = best_sight(
                grid.cells, ground.costs, *gap.goal, round(_ROUND_M / grid.cell_m), _REACH_M / grid.cell_m
            )
            if seen * grid.cell_m**2 >= _WORTH_M2:
                goal = row, column
                found.append(Frontier(goal, grid.centre_of(*goal), gap.length_m, ground.cost_m(goal)))
    return tuple(sorted(found, key=lambda gap: (gap.cost_m, gap.goal)))


@njit(cache=True)
def best_sight(
    cells: NDArray[np.uint8], costs: NDArray[np.int32], row: int, column: int, round_: int, reach: float
) -> tuple[int, int, int]:
    """Return the cell round one, of those that can be reached, that sees most, and how many cells it sees."""
    rows, columns = cells.shape
    best, best_row, best_column = -1, row, column
    marks, mark = np.zeros((rows, columns), np.int32), 0
    for r in range(max(0, row - round_), min(rows, row + round_ + 1)):
        for c in range(max(0, column - round_), min(columns, column + round_ + 1)):
            if costs[r, c] != UNREACHED:
                mark += 1
                seen = _unseen(cells, r, c, reach, marks, mark)
                if seen > best:
                    best, best_row, best_column = seen, r, c
    return best_row, best_column, best


@njit(cache=True)
def _unseen(
    cells: NDArray[np.uint8], row: int, column: int, reach: float, marks: NDArray[np.int32], mark: int
) -> int:
    """Return how many unknown cells are in sight of one, ``reach`` cells far; unknown ones hide nothing."""
    rows, columns = cells.shape
    rays = ceil(2.0 * pi * reach)
    count = 0
    for ray in range(rays):
        angle = 2.0 * pi * ray / rays
        for step in range(1, int(2.0 * reach) + 1):
            r = floor(row + 0.5 + 0.5 * step * sin(angle))
            c = floor(column + 0.5 + 0.5 * step * cos(angle))
            if r < 0 or c < 0 or r >= rows or c >= columns or cells[r, c] == OCCUPIED:
                break
            if cells[r, c] == UNKNOWN and marks[r, c] != mark:
                marks[r, c] = mark
                count += 1
    return count
