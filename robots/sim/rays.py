"""Ray casting on the grid, exact, from cell border to cell border (DDA)."""

from __future__ import annotations

from math import cos, floor, hypot, inf, sin, sqrt

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robots.se2 import Array
from robots.sim.world import GLASS, SMOKE, WALL, Cells, World

SMOKE_DEPTH_M = 0.3  # a laser beam is lost after so much smoke

_CLEAR, _HIT, _LOST = 0, 1, 2


@njit(cache=True)
def _cast(
    cells: Cells,
    column0: float,
    row0: float,
    dx: float,
    dy: float,
    reach: float,
    stops: int,
    loses: int,
    smoke_depth: float,
    seen: Cells,
    mark: bool,
) -> tuple[float, int]:
    """Follow the unit vector (dx, dy); return (distance in cells, what ended the beam).

    Mark the cells passed.
    """
    rows, columns = cells.shape
    column, row = floor(column0), floor(row0)
    step_c, step_r = (1 if dx > 0 else -1), (1 if dy > 0 else -1)
    next_c = ((column + (1 if dx > 0 else 0)) - column0) / dx if dx != 0.0 else inf
    next_r = ((row + (1 if dy > 0 else 0)) - row0) / dy if dy != 0.0 else inf
    delta_c = abs(1.0 / dx) if dx != 0.0 else inf
    delta_r = abs(1.0 / dy) if dy != 0.0 else inf
    t = 0.0
    smoke = 0.0
    while t < reach:
        if row < 0 or column < 0 or row >= rows or column >= columns:
            return t, _HIT
        code = cells[row, column]
        if code & stops:
            return t, _HIT
        if code & loses:
            return t, _LOST
        if mark:
            seen[row, column] = 1
        following = min(next_c, next_r)
        if code & SMOKE:
            smoke += min(following, reach) - t
            if smoke > smoke_depth:
                return t, _LOST
        t = following
        if next_c < next_r:
            next_c += delta_c
            column += step_c
        else:
            next_r += delta_r
            row += step_r
    return reach, _CLEAR


@njit(cache=True)
def _disc(x: float, y: float, dx: float, dy: float, centre_x: float, centre_y: float, radius: float) -> float:
    """Return the distance along the unit vector (dx, dy) to a disc; inf when it is missed or behind."""
    px, py = centre_x - x, centre_y - y
    ahead = px * dx + py * dy
    aside2 = px * px + py * py - ahead * ahead
    if ahead <= 0.0 or aside2 >= radius * radius:
        return inf
    return max(0.0, ahead - sqrt(radius * radius - aside2))


@njit(cache=True)
def _fan(
    cells: Cells,
    origin: tuple[float, float],
    resolution: float,
    x: float,
    y: float,
    angles: Array,
    reach_m: float,
    discs: Array,
    radius: float,
    stops: int,
    loses: int,
    smoke_m: float,
    seen: Cells,
    mark: bool,
) -> Array:
    """Return the range in metres for each angle, shape (n,); inf for a far reading."""
    ranges = np.empty(angles.size)
    column0, row0 = (x - origin[0]) / resolution, (y - origin[1]) / resolution
    smoke_depth = smoke_m / resolution
    for i in range(angles.size):
        dx, dy = cos(angles[i]), sin(angles[i])
        nearest = inf
        for k in range(discs.shape[0]):
            nearest = min(nearest, _disc(x, y, dx, dy, discs[k, 0], discs[k, 1], radius))
        reach = min(reach_m, nearest) / resolution
        t, end = _cast(cells, column0, row0, dx, dy, reach, stops, loses, smoke_depth, seen, mark)
        if end == _HIT:
            ranges[i] = t * resolution
        elif end == _CLEAR and nearest < reach_m:
            ranges[i] = nearest
        else:
            ranges[i] = inf
    return ranges


@njit(cache=True)
def _circles(
    cells: Cells,
    rows: NDArray[np.int64],
    columns: NDArray[np.int64],
    beams: int,
    reach: float,
    smoke_depth: float,
    seen: Cells,
) -> None:
    for k in range(rows.size):
        for i in range(beams):
            dx, dy = cos(2.0 * np.pi * i / beams), sin(2.0 * np.pi * i / beams)
            _cast(cells, columns[k] + 0.5, rows[k] + 0.5, dx, dy, reach, WALL, GLASS, smoke_depth, seen, True)


def cast(
    world: World,
    x_m: float,
    y_m: float,
    angles_rad: Array,
    reach_m: float,
    *,
    stops: int = WALL,
    loses: int = GLASS,
    smoke_depth_m: float = SMOKE_DEPTH_M,
    discs_m: Array | None = None,
    disc_radius_m: float = 0.0,
    seen: Cells | None = None,
) -> Array:
    """Return the range in metres to what stops each beam, shape (n,); inf where nothing within reach does.

    ``angles_rad`` (n,) in the world frame; ``stops`` and ``loses`` are cell flags (a beam that meets
    ``loses`` comes back far); ``discs_m`` (k, 2) centres of other robots; ``seen`` uint8 (h, w) gets 1 in
    every cell a beam passes.
    """
    ranges: Array = _fan(
        world.cells,
        world.origin_m,
        world.resolution_m,
        float(x_m),
        float(y_m),
        angles_rad,
        float(reach_m),
        np.zeros((0, 2)) if discs_m is None else discs_m,
        float(disc_radius_m),
        stops,
        loses,
        float(smoke_depth_m),
        np.zeros((1, 1), np.uint8) if seen is None else seen,
        seen is not None,
    )
    return ranges


def in_sight(
    world: World, a_m: tuple[float, float], b_m: tuple[float, float], stops: int = WALL | GLASS
) -> bool:
    """Return whether the straight line between two points, metres, meets nothing of ``stops``.

    Smoke does not count.
    """
    distance = hypot(b_m[0] - a_m[0], b_m[1] - a_m[1])
    angle = np.array([np.arctan2(b_m[1] - a_m[1], b_m[0] - a_m[0])])
    hit = cast(world, *a_m, angle, distance, stops=stops, loses=0, smoke_depth_m=inf)
    return bool(np.isinf(hit[0]))


def look_round(
    world: World, rows: NDArray[np.int64], columns: NDArray[np.int64], reach_m: float, beams: int = 720
) -> Cells:
    """Return the cells seen by full circles of beams from the centres of the cells given, uint8 (h, w)."""
    seen = np.zeros_like(world.cells)
    reach, smoke_depth = reach_m / world.resolution_m, SMOKE_DEPTH_M / world.resolution_m
    _circles(world.cells, rows, columns, beams, reach, smoke_depth, seen)
    return seen
