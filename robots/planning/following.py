"""Following a path: pure pursuit with a turn on the spot for large angles.

Slowed by what the laser sees ahead.
"""

from __future__ import annotations

from math import atan2, cos, floor, hypot, isfinite, sin

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robots.config import BodyConfig
from robots.planning.plan_grid import PlanGrid
from robots.se2 import Array, Pose2, wrap
from robots.types import FloatArray32, LaserScan

_LOOK_AHEAD_M = 0.5
_TURN_ON_SPOT_RAD = 0.7
_REACTION_S = 0.45  # one control period and the time to stop


def follow(
    path: Array, pose: Pose2, grid: PlanGrid, scan: LaserScan | None, body: BodyConfig
) -> tuple[float, float]:
    """Return velocities (m/s, rad/s) that follow a path from a pose.

    ``path`` (n, 2) points and ``pose`` in the map frame.
    """
    if len(path) == 0:
        return 0.0, 0.0
    x, y = _target(path, pose, grid)
    error = wrap(atan2(y - pose.y, x - pose.x) - pose.theta)
    remaining = hypot(path[-1][0] - pose.x, path[-1][1] - pose.y)
    turn = max(-body.max_turn_radps, min(body.max_turn_radps, 2.5 * error))
    if abs(error) > _TURN_ON_SPOT_RAD:
        return 0.0, turn
    speed = body.max_speed_mps * max(0.2, cos(error)) * max(0.3, 1.0 - abs(error))
    speed = min(speed, max(0.1, remaining * 1.5))
    if scan is not None:
        free = free_ahead(scan, body.radius_m + 0.02)
        speed = min(speed, max(0.0, (free - 0.03) / _REACTION_S))
    return speed, turn


def _target(path: Array, pose: Pose2, grid: PlanGrid) -> tuple[float, float]:
    """Return the farthest point of the path within the look-ahead distance with a clear way to it.

    Clear is what can be driven in a straight line.
    """
    best = _farthest_clear(path, pose.x, pose.y, grid.steps, grid.origin, grid.cell_m)
    return float(path[best, 0]), float(path[best, 1])


@njit(cache=True)
def _farthest_clear(
    path: Array, x: float, y: float, steps: NDArray[np.uint8], origin: tuple[float, float], cell_m: float
) -> int:
    at = 0
    for k in range(1, len(path)):
        if hypot(path[k, 0] - x, path[k, 1] - y) < hypot(path[at, 0] - x, path[at, 1] - y):
            at = k
    best = min(at + 1, len(path) - 1)
    while at < len(path) - 1 and hypot(path[at, 0] - x, path[at, 1] - y) < _LOOK_AHEAD_M:
        at += 1
        if _clear_line(steps, origin, cell_m, x, y, path[at, 0], path[at, 1]):
            best = at
    return best


@njit(cache=True)
def _clear_line(
    steps: NDArray[np.uint8],
    origin: tuple[float, float],
    cell_m: float,
    x0: float,
    y0: float,
    x1: float,
    y1: float,
) -> bool:
    count = max(1, int(hypot(x1 - x0, y1 - y0) / (cell_m / 2.0)))
    for k in range(2, count + 1):  # the robot's own cell may be too close to something
        row = floor((y0 + (y1 - y0) * k / count - origin[1]) / cell_m)
        column = floor((x0 + (x1 - x0) * k / count - origin[0]) / cell_m)
        if row < 0 or column < 0 or row >= steps.shape[0] or column >= steps.shape[1]:
            return False
        if steps[row, column] == 0:
            return False
    return True


def free_ahead(scan: LaserScan, half_width_m: float) -> float:
    """Return how far (m) a body of that half width can drive straight ahead before the nearest echo."""
    return float(
        _free_ahead(
            scan.ranges_m, scan.angle_min_rad, scan.angle_increment_rad, scan.range_max_m, half_width_m
        )
    )


@njit(cache=True)
def _free_ahead(
    ranges: FloatArray32, angle_min: float, increment: float, range_max: float, half_width: float
) -> float:
    free = range_max
    for i in range(ranges.shape[0]):
        r = float(ranges[i])
        if not isfinite(r) or r <= 0.02 or r >= range_max - 1e-3:
            continue
        a = angle_min + i * increment
        x, y = r * cos(a), r * sin(a)
        if x > 0.0 and abs(y) < half_width:
            front = x - (half_width * half_width - y * y) ** 0.5
            free = min(free, max(0.0, front))
    return free
