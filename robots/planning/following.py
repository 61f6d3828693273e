"""Following a path: pure pursuit with a turn on the spot for large angles.

Slowed by what the laser sees ahead.
"""

from __future__ import annotations

from math import atan2, cos, hypot, isfinite, sin

import numpy as np
from numba import njit

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
    distances = np.hypot(path[:, 0] - pose.x, path[:, 1] - pose.y)
    at = int(distances.argmin())
    best = min(at + 1, len(path) - 1)
    while at < len(path) - 1 and distances[at] < _LOOK_AHEAD_M:
        at += 1
        if _clear_line(grid, pose.x, pose.y, float(path[at, 0]), float(path[at, 1])):
            best = at
    return float(path[best, 0]), float(path[best, 1])


def _clear_line(grid: PlanGrid, x0: float, y0: float, x1: float, y1: float) -> bool:
    steps = max(1, int(hypot(x1 - x0, y1 - y0) / (grid.cell_m / 2.0)))
    for k in range(2, steps + 1):  # the robot's own cell may be too close to something
        row, column = grid.cell_of(x0 + (x1 - x0) * k / steps, y0 + (y1 - y0) * k / steps)
        if not grid.holds(row, column) or grid.steps[row, column] == 0:
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
