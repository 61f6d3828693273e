"""The inner loops of the arena."""

from __future__ import annotations

from math import atan2, floor, hypot

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robots.estimation.radio.walls import count_walls
from robots.se2 import Array
from robots.sim.world import Cells, Mask


@njit(cache=True)
def walk(path: Array, x: float, y: float, theta: float, step: float) -> tuple[float, float, float, float]:
    """Return the pose after ``step`` metres along a path (n, 2) from a point near it, and how far that was.

    The robot makes for the point after the nearest and looks where it last went.
    """
    at = 0
    for k in range(len(path)):
        if hypot(path[k, 0] - x, path[k, 1] - y) < hypot(path[at, 0] - x, path[at, 1] - y):
            at = k
    left = step
    for k in range(min(at + 1, len(path) - 1), len(path)):
        dx, dy = path[k, 0] - x, path[k, 1] - y
        gap = hypot(dx, dy)
        if gap < 1e-9:
            continue
        part = min(gap, left)
        x, y, theta = x + dx / gap * part, y + dy / gap * part, atan2(dy, dx)
        left -= part
        if left <= 1e-9:
            break
    return x, y, theta, step - left


@njit(cache=True)
def edge_is_left(
    cells: NDArray[np.int32],
    origin: tuple[float, float],
    resolution: float,
    x: float,
    y: float,
    reach: float,
    occupied: int,
    free: int,
) -> bool:
    """Return whether free ground borders on the unknown somewhere in the square round a point of the map."""
    rows, columns = cells.shape
    top, bottom = floor((y - reach - origin[1]) / resolution), floor((y + reach - origin[1]) / resolution)
    left, right = floor((x - reach - origin[0]) / resolution), floor((x + reach - origin[0]) / resolution)
    for r in range(max(1, top), min(rows - 1, bottom + 1)):
        for c in range(max(1, left), min(columns - 1, right + 1)):
            if cells[r, c] > -free:
                continue
            for v, u in ((r - 1, c), (r + 1, c), (r, c - 1), (r, c + 1)):
                if -free < cells[v, u] < occupied:
                    return True
    return False


@njit(cache=True)
def way_is_clear(
    cells: NDArray[np.int32],
    origin: tuple[float, float],
    resolution: float,
    path: Array,
    x: float,
    y: float,
    ahead: float,
    keep_off: float,
    occupied: int,
) -> bool:
    """Return whether no obstacle of the map lies nearer than ``keep_off`` to the path, so far ahead."""
    rows, columns = cells.shape
    reach = int(keep_off / resolution) + 1
    near = keep_off / resolution
    at = 0
    for k in range(len(path)):
        if hypot(path[k, 0] - x, path[k, 1] - y) < hypot(path[at, 0] - x, path[at, 1] - y):
            at = k
    for k in range(at + 1, len(path)):
        if hypot(path[k, 0] - x, path[k, 1] - y) > ahead:
            break
        gx, gy = (path[k, 0] - origin[0]) / resolution, (path[k, 1] - origin[1]) / resolution
        row, column = floor(gy), floor(gx)
        for r in range(max(0, row - reach), min(rows, row + reach + 1)):
            for c in range(max(0, column - reach), min(columns, column + reach + 1)):
                if cells[r, c] >= occupied and hypot(c + 0.5 - gx, r + 0.5 - gy) < near:
                    return False
    return True


@njit(cache=True)
def absorb(own: Cells, team: Cells, counts: Mask, top: int, left: int, bottom: int, right: int) -> int:
    """Add what one robot saw within a window to what the team saw; return how many new cells count."""
    fresh = 0
    for r in range(top, bottom):
        for c in range(left, right):  # without branches, so that the compiler takes many cells at once
            fresh += own[r, c] & (1 - team[r, c]) & counts[r, c]
            team[r, c] |= own[r, c]
    return fresh


@njit(cache=True)
def tags_in_field(
    cells: Cells,
    origin: tuple[float, float],
    resolution: float,
    x0: float,
    y0: float,
    x1: float,
    y1: float,
    tags: Array,
    reach: float,
    by_sight: bool,
) -> Mask:
    """Return which tags (m, 2) come within reach on the way from one point to another.

    ``by_sight``: of the second point, and no wall may stand between.
    """
    found = np.zeros(len(tags), np.bool_)
    dx, dy = x1 - x0, y1 - y0
    length = dx * dx + dy * dy
    for k in range(len(tags)):
        tx, ty = tags[k, 0], tags[k, 1]
        if by_sight:
            if hypot(tx - x1, ty - y1) <= reach:
                walls = count_walls(
                    cells,
                    (x1 - origin[0]) / resolution,
                    (y1 - origin[1]) / resolution,
                    (tx - origin[0]) / resolution,
                    (ty - origin[1]) / resolution,
                    1,
                )
                found[k] = walls == 0
            continue
        share = 0.0 if length == 0.0 else min(1.0, max(0.0, ((tx - x0) * dx + (ty - y0) * dy) / length))
        found[k] = hypot(tx - x0 - share * dx, ty - y0 - share * dy) <= reach
    return found
