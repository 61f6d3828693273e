"""Walls between a radio and who hears it."""

from __future__ import annotations

from math import floor, hypot, inf

import numpy as np
from numba import njit
from numpy.typing import NDArray

WALL_DB = 2.4  # of every wall on the way, Seidel and Rappaport 1992 (concrete)
UNSEEN = 128  # of a cell: nobody knows what is there
_WALL = 1


@njit(cache=True)
def count_walls(
    cells: NDArray[np.uint8],
    column0: float,
    row0: float,
    column1: float,
    row1: float,
    most: int,
    apart: float = 0.0,
) -> int:
    """Return how often the line between two points, in cells, enters a wall; stop counting at ``most``.

    Walls are the cells (h, w) whose lowest bit is set. One is left after ``apart`` cells that are free:
    neither wall nor ``UNSEEN``. A measured map shows two faces of a wall, and each of them often twice.
    """
    rows, columns = cells.shape
    length = hypot(column1 - column0, row1 - row0)
    if length == 0.0:
        return 0
    dx, dy = (column1 - column0) / length, (row1 - row0) / length
    column, row = floor(column0), floor(row0)
    step_c, step_r = (1 if dx > 0 else -1), (1 if dy > 0 else -1)
    next_c = ((column + (1 if dx > 0 else 0)) - column0) / dx if dx != 0.0 else inf
    next_r = ((row + (1 if dy > 0 else 0)) - row0) / dy if dy != 0.0 else inf
    delta_c = abs(1.0 / dx) if dx != 0.0 else inf
    delta_r = abs(1.0 / dy) if dy != 0.0 else inf
    t, free, count, inside = 0.0, 0.0, 0, False
    while t < length and count < most:
        if row < 0 or column < 0 or row >= rows or column >= columns:
            break
        cell, before = cells[row, column], t
        t = min(next_c, next_r)
        if cell & _WALL:
            if not inside:
                count += 1
            inside, free = True, 0.0
        elif not cell & UNSEEN:
            free += t - before
            inside = inside and free < apart
        if next_c < next_r:
            next_c += delta_c
            column += step_c
        else:
            next_r += delta_r
            row += step_r
    return count
