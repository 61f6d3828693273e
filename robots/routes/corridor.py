"""Whether a place lies in a corridor: for some way walls run along it on both sides, but for doors."""

from __future__ import annotations

from math import cos, pi, sin

import numpy as np
from numba import njit

from robots.routes.outlook import FREE, UNKNOWN, WALL, Kinds, Plan
from robots.se2 import Array

_AXES = 60  # directions in half a turn
_STEP_M, _STEPS = 0.2, 48  # ahead, and as many behind
_WIDE_M = 3.2  # no corridor is wider
_LEAST, _TIMES = 25, 3.0  # steps that it is long, at the least, and how many times its width
_STRAIGHT_M = 0.3  # a wall may be off its line by this
_MOSTLY = 0.55  # of each side is wall, the rest doors and other corridors


def is_corridor(plan: Plan, place_m: Array) -> bool:
    """Say whether a place (2,) of the world frame lies in a corridor."""
    column, row = (place_m - plan.origin_m) / plan.resolution_m
    return bool(_is_corridor(plan.cells, column, row, plan.resolution_m))


@njit(cache=True)
def _is_corridor(cells: Kinds, column: float, row: float, cell_m: float) -> bool:
    lefts, rights = np.empty(2 * _STEPS + 1), np.empty(2 * _STEPS + 1)
    for axis in range(_AXES):
        dx, dy = cos(pi * axis / _AXES), sin(pi * axis / _AXES)
        behind = _open_steps(cells, column, row, -dx, -dy, cell_m)
        ahead = _open_steps(cells, column, row, dx, dy, cell_m)
        count = behind + ahead + 1
        if count < _LEAST:
            continue
        for k in range(count):
            out = (k - behind) * _STEP_M / cell_m
            x, y = column + out * dx, row + out * dy
            lefts[k] = _room_m(cells, x, y, -dy, dx, cell_m)
            rights[k] = _room_m(cells, x, y, dy, -dx, cell_m)
        if (lefts[:count] + rights[:count] < _WIDE_M).sum() >= _LEAST // 4 and _runs_on(
            lefts[:count], rights[:count], behind
        ):
            return True
    return False


@njit(cache=True)
def _runs_on(lefts: Array, rights: Array, here: int) -> bool:
    """Say whether about a step some stretch has both walls, long enough for how far they are apart."""
    for first in range(0, here + 1, 2):
        last = max(first + _LEAST, here + 1)
        while last <= len(lefts):
            left, right = np.median(lefts[first:last]), np.median(rights[first:last])
            wide = left + right
            if wide > _WIDE_M:
                break
            least = int(np.ceil(_TIMES * wide / _STEP_M))
            if last - first >= least:
                walls = (np.abs(lefts[first:last] - left) < _STRAIGHT_M).mean()
                others = (np.abs(rights[first:last] - right) < _STRAIGHT_M).mean()
                if walls >= _MOSTLY and others >= _MOSTLY:
                    return True
                break
            last = first + least
    return False


@njit(cache=True)
def _open_steps(cells: Kinds, column: float, row: float, dx: float, dy: float, cell_m: float) -> int:
    """Return how many steps it is to a wall or to what nobody has seen."""
    height, width = cells.shape
    half = 0.5 * cell_m
    for step in range(round(_STEPS * _STEP_M / half)):
        i, j = int(np.floor(row + 0.5 * step * dy)), int(np.floor(column + 0.5 * step * dx))
        if not (0 <= i < height and 0 <= j < width) or cells[i, j] == UNKNOWN or cells[i, j] == WALL:
            return int(max(0.0, step * half - cell_m) / _STEP_M)
    return _STEPS


@njit(cache=True)
def _room_m(cells: Kinds, column: float, row: float, dx: float, dy: float, cell_m: float) -> float:
    """Return how far it is to a wall or a thing; farther than any corridor's where none has been seen."""
    height, width = cells.shape
    for step in range(round(2.0 * _WIDE_M / cell_m)):
        i, j = int(np.floor(row + 0.5 * step * dy)), int(np.floor(column + 0.5 * step * dx))
        if not (0 <= i < height and 0 <= j < width) or cells[i, j] == UNKNOWN:
            break
        if cells[i, j] != FREE:
            return 0.5 * step * cell_m
    return 2.0 * _WIDE_M
