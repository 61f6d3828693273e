"""Does a scan contradict the map it should have been taken in? So a robot that was carried off notices it."""

from __future__ import annotations

from math import atan2, cos, floor, hypot, isfinite, sin

from numba import njit

from robots.se2 import Array, Pose2
from robots.types import FloatArray32, LaserScan

_BEYOND_M = 0.5  # a beam that goes on so far behind a surface went through it
_NEAR_M = 0.3  # one that ends so near to it saw it
_ENOUGH = 30  # surface points that have to be in view


def share_seen_through(scan: LaserScan, local_from_base: Pose2, surface: Array) -> float:
    """Return the share of the surface points in view that the scan's beams go through.

    A new room shows surfaces that the map lacks, and contradicts nothing; another place shows none that it
    has. ``surface`` (n, 2) in the local frame, metres. 0 where too few of its points are in view.
    """
    pose = local_from_base.as_array()
    through, seen = _count(
        scan.ranges_m, scan.angle_min_rad, scan.angle_increment_rad, scan.range_max_m, pose, surface
    )
    return through / (through + seen) if through + seen >= _ENOUGH else 0.0


@njit(cache=True)
def _count(
    ranges: FloatArray32, angle_min: float, increment: float, range_max: float, pose: Array, surface: Array
) -> tuple[int, int]:
    through, seen = 0, 0
    if increment <= 0.0:
        return through, seen
    c, s = cos(pose[2]), sin(pose[2])
    for i in range(len(surface)):
        dx, dy = surface[i, 0] - pose[0], surface[i, 1] - pose[1]
        x, y = c * dx + s * dy, -s * dx + c * dy
        away = hypot(x, y)
        angle = atan2(y, x) - angle_min
        k = floor((angle % 6.283185307179586) / increment + 0.5)
        if k < 1 or k >= len(ranges) - 1 or away > range_max - _BEYOND_M:
            continue
        shortest, nearest = 1e9, 1e9
        for near in (k - 1, k, k + 1):
            reading = float(ranges[near])
            if not isfinite(reading):
                reading = range_max
            shortest = min(shortest, reading)
            nearest = min(nearest, abs(reading - away))
        if nearest <= _NEAR_M:
            seen += 1
        elif shortest > away + _BEYOND_M:
            through += 1
    return through, seen
