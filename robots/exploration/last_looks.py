"""What is looked at before a robot says that nothing is left: gaps too short for edges of the unknown.

A gap may be the noise of a map, a beam that missed a wall, or the only sight into a niche that nobody enters.
It is worth a look from where more of the unknown can be seen through it than a map's noise hides. And ground
that only beams crossed that came back from nowhere: behind glass a map shows what nobody has seen.
"""

from __future__ import annotations

from math import ceil, cos, floor, pi, sin

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy import ndimage

from robots.exploration.frontiers import Frontier, find_frontiers
from robots.exploration.ground import Ground
from robots.mapping.fused import FusedGrid
from robots.planning.plan_grid import OCCUPIED, UNKNOWN
from robots.planning.travel import UNREACHED
from robots.se2 import Array

BEHIND_GLASS = "see for myself what I may have seen behind glass alone"
_REACH_M, _ROUND_M = 3.0, 1.5
_WORTH_M2 = 0.5  # of the unknown in sight
_FROM_TRAIL_M = 0.5
_DOUBTED_M2 = 0.75, 15.0  # a room behind glass; halls are larger
_NEAR_M = 0.6


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


def unproved(
    ground: Ground, fused: FusedGrid | None, trail: Array, free_logodds: int
) -> tuple[Frontier, ...]:
    """Return places in pieces of ground that only beams saw that met nothing, nearest first.

    So do beams that meet glass, and what a map shows behind it was never seen. ``trail`` (k, 2 or more): x, y
    in the map frame of where the robot was. ``free_logodds`` as in ``FusedGrid.unsure``.
    """
    unsure = None if fused is None else fused.unsure(free_logodds)
    if fused is None or unsure is None or not unsure.any():
        return ()
    cells = np.floor((trail[:, 1::-1] - fused.origin[::-1]) / fused.resolution_m).astype(int)
    driven = np.ones(unsure.shape, np.bool_)
    cells = cells[((cells >= 0) & (cells < unsure.shape)).all(axis=1)]
    driven[cells[:, 0], cells[:, 1]] = False
    unsure &= ndimage.distance_transform_edt(driven) * fused.resolution_m > _FROM_TRAIL_M
    labels, count = ndimage.label(unsure)
    found = []
    for k, size in enumerate(np.bincount(labels.ravel(), minlength=count + 1)[1:], 1):
        if not _DOUBTED_M2[0] <= size * fused.resolution_m**2 <= _DOUBTED_M2[1]:
            continue
        piece = np.argwhere(labels == k)
        row, column = piece[((piece - piece.mean(axis=0)) ** 2).sum(axis=1).argmin()] + 0.5
        x, y = fused.origin[0] + column * fused.resolution_m, fused.origin[1] + row * fused.resolution_m
        cell = ground.nearest(x, y, _NEAR_M)
        if cell is not None:
            length_m = float(size) ** 0.5 * fused.resolution_m
            found.append(Frontier(cell, ground.grid.centre_of(*cell), length_m, ground.cost_m(cell)))
    return tuple(sorted(found, key=lambda piece: (piece.cost_m, piece.goal)))


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
