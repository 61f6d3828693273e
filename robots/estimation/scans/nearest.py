"""A grid that knows the surface point nearest to each of its cells.

A cell holds the squared distance from its centre and the number of the point in one integer, so that keeping
the nearest is a minimum without branches.
"""

from __future__ import annotations

from math import floor

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robots.se2 import Array

Index = NDArray[np.int32]

CELL_M = 0.1
MAX_POINTS = 16384  # 14 bits
NOTHING = 2**31 - 1
MAX_REACH_CELLS = 4  # squared distances up to 2 * 4.5**2 cells in parts of _PARTS fit the other 17 bits
_PARTS = 3200


@njit(cache=True, inline="always")
def nearest(x: float, y: float, index: Index, origin: Array) -> int:
    """Return the number of the point the cell of (x, y) knows, -1 where it knows none."""
    column = floor((x - origin[0]) / CELL_M)
    row = floor((y - origin[1]) / CELL_M)
    if row < 0 or column < 0 or row >= index.shape[0] or column >= index.shape[1]:
        return -1
    key = index[row, column]
    return -1 if key == NOTHING else int(key) & (MAX_POINTS - 1)


@njit(cache=True)
def stamp(index: Index, origin: Array, number: int, x: float, y: float, reach: int) -> bool:
    """Let the cells within ``reach`` cells know a point; say whether it lies far enough inside the grid."""
    wide = 2 * reach + 1
    column_f, row_f = (x - origin[0]) / CELL_M, (y - origin[1]) / CELL_M
    column, row = floor(column_f) - reach, floor(row_f) - reach
    if row < 0 or column < 0 or row + wide > index.shape[0] or column + wide > index.shape[1]:
        return False
    left = np.float32(column + 0.5 - column_f)
    low = np.float32(row + 0.5 - row_f)
    for r in range(wide):
        up = np.float32(r) + low
        line = index[row + r]
        for c in range(wide):
            aside = np.float32(c) + left
            parts = np.int32((aside * aside + up * up) * np.float32(_PARTS))
            line[column + c] = min(line[column + c], parts * np.int32(MAX_POINTS) + np.int32(number))
    return True
