"""Log-odds occupancy: casting a scan into a grid (Moravec's evidence grid, one update per cell and scan)."""

from __future__ import annotations

from math import cos, floor, isfinite, sin

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robots.types import FloatArray32

LogOdds = NDArray[np.int16]

_PROVED, _FELT = 1, 2


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
    Far readings come from glass, smoke and beams that slide off a wall too. They clear with half the weight,
    no further than to be told from the unknown, nothing that a body felt, and end at what stood there till
    now, which they wear down slowly: a wall behind a pane stays, what has walked away does not.
    ``touched`` (same shape, int32, 0 at first) holds four times the ``mark`` of the last scan that
    changed a cell, 1 more once a beam that came back crossed or ended in it (see ``proved``), 2 more where
    something was felt.
    """
    rows, columns = grid.shape
    freest = -2 * miss  # by far readings alone
    for i in range(ranges.shape[0]):  # hits first: they take precedence over beams that graze the same cell
        r = float(ranges[i])
        if not isfinite(r) or r >= range_max - 1e-3 or r >= limit or r <= 0.02:
            continue
        a = theta + angle_min + i * increment
        c = floor((x + r * cos(a) - origin_x) / resolution)
        w = floor((y + r * sin(a) - origin_y) / resolution)
        if 0 <= w < rows and 0 <= c < columns and touched[w, c] >> 2 != mark:
            touched[w, c] = 4 * mark | touched[w, c] & _FELT | _PROVED
            grid[w, c] = min(bound, grid[w, c] + hit)
    for i in range(ranges.shape[0]):
        r = float(ranges[i])
        if r <= 0.02:
            continue
        far = not isfinite(r) or r >= range_max - 1e-3
        reach = min(range_max, limit) if far else min(r, limit)
        weight = max(1, miss // 2) if far else miss
        back = 0 if far else _PROVED
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
            if 0 <= w < rows and 0 <= c < columns:
                before = touched[w, c]
                if before >> 2 == mark:
                    if back:
                        touched[w, c] = before | back
                elif far:
                    stands = grid[w, c] >= hit
                    if before & _FELT == 0 and grid[w, c] > freest:
                        grid[w, c] = max(freest, grid[w, c] - (1 if stands else weight))
                        touched[w, c] = 4 * mark | before & 3
                    if stands:
                        break  # more likely a mirror or a pane before it than that it has gone
                else:
                    grid[w, c] = max(-bound, grid[w, c] - weight)
                    touched[w, c] = 4 * mark | before & 3 | back
            if next_x < next_y:
                travelled = next_x
                next_x += inv_x
                c += step_c
            else:
                travelled = next_y
                next_y += inv_y
                w += step_w


def proved(touched: NDArray[np.int32]) -> NDArray[np.bool_]:
    """Return the cells, (h, w), that beams crossed or met that came back, of ``cast_scan``'s ``touched``.

    What only others crossed may be free, or lie behind glass.
    """
    found: NDArray[np.bool_] = (touched & _PROVED).astype(np.bool_)
    return found


@njit(cache=True)
def stamp_disc(
    grid: LogOdds, touched: NDArray[np.int32], row: int, column: int, radius_cells: int, value: int
) -> None:
    """Set the cells of a disc to at least ``value``: an obstacle that was felt, not seen."""
    rows, columns = grid.shape
    for w in range(max(0, row - radius_cells), min(rows, row + radius_cells + 1)):
        for c in range(max(0, column - radius_cells), min(columns, column + radius_cells + 1)):
            if (w - row) ** 2 + (c - column) ** 2 <= radius_cells**2:
                grid[w, c] = max(grid[w, c], value)
                touched[w, c] |= _FELT
