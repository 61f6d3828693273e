"""Laser scans as points with surface normals."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, hypot, isfinite, sin, sqrt

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

    ``points`` (n, 2) in metres; ``normals`` (n, 2), unit, towards the sensor, zero where unknown;
    ``far_fraction`` is the share of beams that hit nothing. Things as small as a robot that stand free are
    left out where enough else is seen: they may be other robots, and a scan matched to one that drives away
    would be dragged along.
    """

    points: Array
    normals: Array
    far_fraction: float


def scan_points(scan: LaserScan, max_range_m: float) -> ScanPoints:
    """Return the scan's hits within ``max_range_m``, without isolated ones, with their normals."""
    limit = min(max_range_m, scan.range_max_m)
    points, normals, standing_free, far = _points(
        scan.ranges_m, scan.angle_min_rad, scan.angle_increment_rad, limit, scan.range_max_m
    )
    if len(points) - standing_free.sum() >= _ENOUGH_POINTS:
        points, normals = points[~standing_free], normals[~standing_free]
    return ScanPoints(points, normals, far)


@njit(cache=True)
def _standing_free(
    ranges: FloatArray32, xy: Array, hit: NDArray[np.bool_], increment: float
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
        while end + 1 < n and hit[end + 1]:
            jump = hypot(xy[end + 1, 0] - xy[end, 0], xy[end + 1, 1] - xy[end, 1])
            if jump > max(0.15, 4.0 * ranges[end] * increment):
                break
            end += 1
        wide = hypot(xy[end, 0] - xy[start, 0], xy[end, 1] - xy[start, 1])
        if wide < _ROBOT_SIZE_M and start > 0 and end < n - 1:
            before, after = ranges[start - 1], ranges[end + 1]
            clear_before = not hit[start - 1] or before > ranges[start] + _CLEAR_BEHIND_M
            clear_after = not hit[end + 1] or after > ranges[end] + _CLEAR_BEHIND_M
            if clear_before and clear_after:
                marked[start : end + 1] = True
        start = end + 1
    return marked


@njit(cache=True)
def _points(
    ranges: FloatArray32, angle_min: float, increment: float, limit: float, range_max: float
) -> tuple[Array, Array, NDArray[np.bool_], float]:
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
        a = angle_min + i * increment
        xy[i, 0], xy[i, 1] = r * cos(a), r * sin(a)
        hit[i] = True
    marked = _standing_free(ranges, xy, hit, increment)
    points = np.empty((n, 2))
    normals = np.zeros((n, 2))
    standing_free = np.zeros(n, np.bool_)
    count = 0
    for i in range(n):
        if not hit[i]:
            continue
        r = hypot(xy[i, 0], xy[i, 1])
        gate = max(0.12, 4.0 * r * increment)  # neighbours on a surface seen at up to about 75 degrees
        k, mx, my, sxx, sxy, syy = 0, 0.0, 0.0, 0.0, 0.0, 0.0
        for step in (-1, 1):  # walk outwards while the surface continues
            px, py = xy[i, 0], xy[i, 1]
            j = i + step
            while 0 <= j < n and hit[j]:
                if hypot(xy[j, 0] - px, xy[j, 1] - py) > gate:
                    break
                far_off = hypot(xy[j, 0] - xy[i, 0], xy[j, 1] - xy[i, 1]) > _SURFACE_M
                if far_off and abs(j - i) > _NEIGHBOURS:
                    break
                px, py = xy[j, 0], xy[j, 1]
                dx, dy = px - xy[i, 0], py - xy[i, 1]
                mx, my = mx + dx, my + dy
                sxx, sxy, syy = sxx + dx * dx, sxy + dx * dy, syy + dy * dy
                k += 1
                j += step
        if k == 0:
            continue  # an isolated return: a mixed pixel at an edge
        points[count, 0], points[count, 1] = xy[i, 0], xy[i, 1]
        standing_free[count] = marked[i]
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
                size = hypot(nx, ny)
                nx, ny = nx / size, ny / size
                if nx * xy[i, 0] + ny * xy[i, 1] > 0.0:
                    nx, ny = -nx, -ny
                normals[count, 0], normals[count, 1] = nx, ny
        count += 1
    return points[:count].copy(), normals[:count].copy(), standing_free[:count].copy(), far / max(n, 1)
