"""Log-odds occupancy: casting a scan into a grid (Moravec's evidence grid, one update per cell and scan)."""

from __future__ import annotations

from math import cos, floor, isfinite, sin

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robots.types import FloatArray32

LogOdds = NDArray[np.int16]


@njit(cache=True)
def cast_scan(
    grid: LogOdds,
    touched: NDArray[np.int32],
    mark: int,
    origin_x: float,
    origin_y: float,
    resolution: float,
    x: float,
    y: float,
    theta: float,
    ranges: FloatArray32,
    angle_min: float,
    increment: float,
    range_max: float,
    limit: float,
    hit: int,
    miss: int,
    bound: int,
) -> None:
    """Add one scan, taken at (x, y, theta) in the grid's frame, to the grid in place.

    Every cell changes at most once a scan: cells with a hit by ``hit``, cells crossed by a beam by ``-miss``.
    Far readings clear with half the weight, because glass and smoke return them too. ``touched`` (same shape,
    int32) remembers the cells of scan ``mark``.
    """
    rows, columns = grid.shape
    for i in range(ranges.shape[0]):  # hits first: they take precedence over beams that graze the same cell
        r = float(ranges[i])
        if not isfinite(r) or r >= range_max - 1e-3 or r >= limit or r <= 0.02:
            continue
        a = theta + angle_min + i * increment
        c = floor((x + r * cos(a) - origin_x) / resolution)
        w = floor((y + r * sin(a) - origin_y) / resolution)
        if 0 <= w < rows and 0 <= c < columns and touched[w, c] != mark:
            touched[w, c] = mark
            grid[w, c] = min(bound, grid[w, c] + hit)
    for i in range(ranges.shape[0]):
        r = float(ranges[i])
        if r <= 0.02:
            continue
        far = not isfinite(r) or r >= range_max - 1e-3
        reach = min(range_max, limit) if far else min(r, limit)
        weight = max(1, miss // 2) if far else miss
        a = theta + angle_min + i * increment
        dx, dy = cos(a), sin(a)
        # Amanatides and Woo: walk the cells from the sensor to the end of the beam
        gx, gy = (x - origin_x) / resolution, (y - origin_y) / resolution
        c, w = floor(gx), floor(gy)
        step_c = 1 if dx > 0 else -1
        step_w = 1 if dy > 0 else -1
        inv_x = 1.0 / abs(dx) if abs(dx) > 1e-12 else 1e12
        inv_y = 1.0 / abs(dy) if abs(dy) > 1e-12 else 1e12
        next_x = (c + 1 - gx if dx > 0 else gx - c) * inv_x
        next_y = (w + 1 - gy if dy > 0 else gy - w) * inv_y
        end = reach / resolution
        travelled = 0.0
        while travelled < end:
            if 0 <= w < rows and 0 <= c < columns and touched[w, c] != mark:
                touched[w, c] = mark
                grid[w, c] = max(-bound, grid[w, c] - weight)
            if next_x < next_y:
                travelled = next_x
                next_x += inv_x
                c += step_c
            else:
                travelled = next_y
                next_y += inv_y
                w += step_w


@njit(cache=True)
def mark_sure(
    sure: NDArray[np.uint8],
    origin_x: float,
    origin_y: float,
    resolution: float,
    x: float,
    y: float,
    theta: float,
    ranges: FloatArray32,
    angle_min: float,
    increment: float,
    range_max: float,
    limit: float,
) -> None:
    """Mark the cells crossed by beams of a scan, taken at (x, y, theta) in the grid's frame, that came back.

    What only others crossed may be free, or lie behind glass.
    """
    rows, columns = sure.shape
    for i in range(ranges.shape[0]):
        r = float(ranges[i])
        if not isfinite(r) or r >= range_max - 1e-3 or r <= 0.02:
            continue
        a = theta + angle_min + i * increment
        steps = int(2.0 * min(r, limit) / resolution) + 1
        dx, dy = min(r, limit) * cos(a) / steps, min(r, limit) * sin(a) / steps
        for k in range(steps + 1):
            c = floor((x + k * dx - origin_x) / resolution)
            w = floor((y + k * dy - origin_y) / resolution)
            if 0 <= w < rows and 0 <= c < columns:
                sure[w, c] = 1


@njit(cache=True)
def stamp_disc(grid: LogOdds, row: int, column: int, radius_cells: int, value: int) -> None:
    """Set the cells of a disc to at least ``value``: an obstacle that was felt, not seen."""
    rows, columns = grid.shape
    for w in range(max(0, row - radius_cells), min(rows, row + radius_cells + 1)):
        for c in range(max(0, column - radius_cells), min(columns, column + radius_cells + 1)):
            if (w - row) ** 2 + (c - column) ** 2 <= radius_cells**2:
                grid[w, c] = max(grid[w, c], value)
