"""How wide the passages are that robots drove through, by the walls of the fused map to left and right."""

from __future__ import annotations

import numpy as np

from robots.routes.sight import OCCUPIED_FROM
from robots.se2 import Array
from robots.team import TeamGrid

NARROW_M = 0.75  # less, and people in gear have to squeeze through
_WIDE_M, _NARROWEST_M = 1.2, 0.6  # from here on a metre counts more, up to twice
_SQUEEZE_CM = 300  # so long a detour is better than squeezing through
_LOOK_M = 2.0  # to each side
_STEP_M = 0.25
_PASSED_M = 0.3  # at the least, where a robot came through
_AHEAD = 2  # steps over which the way's direction is taken


def narrowness(grid: TeamGrid, line_m: Array) -> tuple[float, int]:
    """Return the narrowest width (m) along a line of points (n, 2), and by how much its cost (cm) rises.

    Every metre counts 1 + (1.2 - width) / 0.6 times, once at 1.2 m and wider, twice at 0.6 m and narrower;
    a squeeze counts 3 m more. What nobody has looked at is no wall; 4 m is the widest that is looked for.
    """
    points = _resampled(line_m)
    if len(points) < 2:
        return 2.0 * _LOOK_M, 0
    widths = _widths(grid, points)
    times = np.clip((_WIDE_M - widths) / (_WIDE_M - _NARROWEST_M), 0.0, 1.0)
    steps = np.hypot(*np.diff(points, axis=0).T)
    more_cm = 100.0 * float(((times[1:] + times[:-1]) / 2.0 * steps).sum())
    narrowest = round(float(widths.min()), 2)
    return narrowest, round(more_cm) + (_SQUEEZE_CM if narrowest < NARROW_M else 0)


def _resampled(line_m: Array) -> Array:
    """Return points every 0.25 m of a line."""
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line_m, axis=0).T))])
    at = np.linspace(0.0, along[-1], int(along[-1] / _STEP_M) + 1)
    return np.column_stack([np.interp(at, along, line_m[:, 0]), np.interp(at, along, line_m[:, 1])])


def _widths(grid: TeamGrid, points: Array) -> Array:
    """Return the room (n,) between the walls across the way at each point."""
    count = len(points)
    indices = np.arange(count)
    ahead = points[np.minimum(indices + _AHEAD, count - 1)] - points[np.maximum(indices - _AHEAD, 0)]
    ahead /= np.maximum(np.hypot(*ahead.T), 1e-9)[:, None]
    across = np.column_stack([-ahead[:, 1], ahead[:, 0]])
    left, right = _room(grid, points, across), _room(grid, points, -across)
    in_wall = (left == 0.0) | (right == 0.0)  # it was driven through: the map errs there, not the robot
    return np.where(in_wall, 2.0 * _LOOK_M, np.maximum(left + right, _PASSED_M))


def _room(grid: TeamGrid, points: Array, towards: Array) -> Array:
    """Return how far (n,) it is from points to the first wall, at most 2 m."""
    steps = np.arange(0.0, _LOOK_M, grid.resolution_m / 2.0)
    places = points[:, None] + steps[None, :, None] * towards[:, None]
    columns = np.floor((places[..., 0] - grid.origin_m[0]) / grid.resolution_m).astype(int)
    rows = np.floor((places[..., 1] - grid.origin_m[1]) / grid.resolution_m).astype(int)
    height, width = grid.cells.shape
    inside = (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width)
    walls = np.zeros(inside.shape, bool)
    walls[inside] = grid.cells[rows[inside], columns[inside]] >= OCCUPIED_FROM
    first = walls.argmax(axis=1)
    return np.where(walls.any(axis=1), steps[first], _LOOK_M)
