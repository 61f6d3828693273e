"""Laser scans as points with surface normals."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import inf, isfinite, sqrt

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robots.se2 import Array
from robots.types import FloatArray32, LaserScan

_NEIGHBOURS = 4  # beams to either side that may share a beam's surface
_SURFACE_M = 0.15  # more are taken while nearer than this: a shorter piece leaves the normal to the noise
_ROBOT_SIZE_M = 0.6  # a free-standing thing up to this wide may be a robot
_CLEAR_BEHIND_M = 0.3  # free-standing: what is seen on both sides of it lies so much farther away
_ENOUGH_POINTS = 20


@dataclass(frozen=True, slots=True, eq=False)
class ScanPoints:
    """End points of a scan with surface normals, in the base frame.

    ``points`` (n, 2) in metres, in the order of the beams; ``normals`` (n, 2), unit, towards the sensor, zero
    where unknown; ``far_fraction`` is the share of beams that hit nothing. Things as small as a robot that
    stand free are left out where enough else is seen: they may be other robots, and a scan matched to one
    that drives away would be dragged along.
    """

    points: Array
    normals: Array
    far_fraction: float


def scan_points(scan: LaserScan, max_range_m: float, smooth: bool = False) -> ScanPoints:
    """Return the scan's hits within ``max_range_m``, without isolated ones, with their normals.

    ``smooth`` moves each point onto the line through its neighbours: less noise, but door frames and other
    small things lose their depth, which a map of many scans would miss.
    """
    if not isfinite(scan.angle_min_rad) or not isfinite(scan.angle_increment_rad):
        return ScanPoints(np.zeros((0, 2)), np.zeros((0, 2)), 1.0)
    limit = min(max_range_m, scan.range_max_m)
    directions = _directions(len(scan.ranges_m), scan.angle_min_rad, scan.angle_increment_rad)
    increment = abs(scan.angle_increment_rad)
    points, normals, far = _points(scan.ranges_m, directions, increment, limit, scan.range_max_m, smooth)
    return ScanPoints(points, normals, far)


@lru_cache(maxsize=16)
def _directions(beams: int, angle_min_rad: float, increment_rad: float) -> Array:
    """Return the unit vectors of the beams, (n, 2): the same ones scan after scan."""
    angles = angle_min_rad + np.arange(beams) * increment_rad
    directions = np.column_stack([np.cos(angles), np.sin(angles)])
    directions.flags.writeable = False
    return directions


@njit(cache=True)
def _standing_free(
    ranges: FloatArray32, xy: Array, hit: NDArray[np.bool_], linked: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Mark the beams of things up to a robot's size with clear space on both sides."""
    n = ranges.shape[0]
    marked = np.zeros(n, np.bool_)
    start = 0
    while start < n:
        if not hit[start]:
            start += 1
            continue
        end = start  # the last beam of an unbroken surface
        while end + 1 < n and linked[end]:
            end += 1
        dx, dy = xy[end, 0] - xy[start, 0], xy[end, 1] - xy[start, 1]
        if dx * dx + dy * dy < _ROBOT_SIZE_M * _ROBOT_SIZE_M and start > 0 and end < n - 1:
            before, after = ranges[start - 1], ranges[end + 1]
            clear_before = not hit[start - 1] or before > ranges[start] + _CLEAR_BEHIND_M
            clear_after = not hit[end + 1] or after > ranges[end] + _CLEAR_BEHIND_M
            if clear_before and clear_after:
                marked[start : end + 1] = True
        start = end + 1
    return marked


@njit(cache=True)
def _points(
    ranges: FloatArray32, directions: Array, increment: float, limit: float, range_max: float, smooth: bool
) -> tuple[Array, Array, float]:
    n = ranges.shape[0]
    xy = np.zeros((n, 2))
    hit = np.zeros(n, np.bool_)
    far = 0
    for i in range(n):
        r = float(ranges[i])
        if not isfinite(r) or r >= range_max - 1e-3:
            far += 1
            continue
        if r <= 0.02 or r >= limit:
            continue
        xy[i, 0], xy[i, 1] = r * directions[i, 0], r * directions[i, 1]
        hit[i] = True
    gap = np.full(n, inf)  # squared distance to the next beam's point
    unbroken = np.zeros(n, np.bool_)  # with the next beam, for what stands free
    for i in range(n - 1):
        if hit[i] and hit[i + 1]:
            dx, dy = xy[i + 1, 0] - xy[i, 0], xy[i + 1, 1] - xy[i, 1]
            gap[i] = dx * dx + dy * dy
            unbroken[i] = gap[i] <= max(0.15, 4.0 * ranges[i] * increment) ** 2
    marked = _standing_free(ranges, xy, hit, unbroken)
    points = np.empty((n, 2))
    normals = np.zeros((n, 2))
    standing_free = np.zeros(n, np.bool_)
    count, free = 0, 0
    for i in range(n):
        if not hit[i]:
            continue
        x, y = xy[i, 0], xy[i, 1]
        gate = max(0.12, 4.0 * ranges[i] * increment) ** 2  # a surface seen at up to about 75 degrees
        k, mx, my, sxx, sxy, syy = 0, 0.0, 0.0, 0.0, 0.0, 0.0
        for step in (-1, 1):  # walk outwards while the surface continues
            j = i
            while True:
                before = j if step > 0 else j - 1  # gap[before] lies between j and the next one
                if before < 0 or gap[before] > gate:
                    break
                j += step
                dx, dy = xy[j, 0] - x, xy[j, 1] - y
                if dx * dx + dy * dy > _SURFACE_M * _SURFACE_M and abs(j - i) > _NEIGHBOURS:
                    break
                mx, my = mx + dx, my + dy
                sxx, sxy, syy = sxx + dx * dx, sxy + dx * dy, syy + dy * dy
                k += 1
        if k == 0:
            continue  # an isolated return: a mixed pixel at an edge
        points[count, 0], points[count, 1] = x, y
        standing_free[count] = marked[i]
        free += marked[i]
        if k >= 3:
            m = k + 1.0
            cxx, cxy, cyy = sxx - mx * mx / m, sxy - mx * my / m, syy - my * my / m
            mean, diff = (cxx + cyy) / 2.0, (cxx - cyy) / 2.0
            root = sqrt(diff * diff + cxy * cxy)
            small, large = mean - root, mean + root
            if large > 1e-6 and small < 0.12 * large:
                # eigenvector of the small eigenvalue
                nx, ny = cxy, small - cxx
                if abs(nx) + abs(ny) < 1e-9:
                    nx, ny = (1.0, 0.0) if cxx < cyy else (0.0, 1.0)
                size = sqrt(nx * nx + ny * ny)
                if nx * x + ny * y > 0.0:
                    size = -size
                nx, ny = nx / size, ny / size
                normals[count, 0], normals[count, 1] = nx, ny
                if smooth:
                    across = (nx * mx + ny * my) / m
                    points[count, 0], points[count, 1] = x + nx * across, y + ny * across
        count += 1
    if count - free >= _ENOUGH_POINTS and free > 0:
        kept = 0
        for i in range(count):
            if not standing_free[i]:
                points[kept], normals[kept] = points[i], normals[i]
                kept += 1
        count = kept
    return points[:count].copy(), normals[:count].copy(), far / max(n, 1)
