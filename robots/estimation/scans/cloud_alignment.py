"""Surfaces of clouds with what is seen as free before them, and the alignment of two of them."""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2, cos, floor, hypot, inf, pi, sin

import numpy as np
from numba import njit

from robots.estimation.scans.local_map import thin
from robots.estimation.scans.nearest import CELL_M, MAX_POINTS, NOTHING, Index, nearest
from robots.se2 import Array

_BEARINGS = 360  # of the free space seen round the anchor
_ITERATIONS = 20
_INLIER_M = 0.12
_EXPLAINED_M = 0.15
_CLEAR_M = 0.3  # so far in front of what is seen, a point that is not explained contradicts


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """A cloud, thinned and indexed, in its anchor's frame.

    ``points``, ``normals`` (n, 2); ``index`` int32 (h, w): nearest point of each cell, -1 where none is near;
    ``origin`` (2,) its lower left corner; ``sight_m`` (360,): how far the anchor sees in each direction, 0
    where it is not known.
    """

    points: Array
    normals: Array
    index: Index
    origin: Array
    sight_m: Array


def surface(points: Array, normals: Array) -> Surface:
    """Return the surface of points and normals, (n, 2)."""
    if not len(points):
        return Surface(points, normals, np.zeros((0, 0), np.int32), np.zeros(2), np.zeros(_BEARINGS))
    low = np.floor((points.min(axis=0) - 0.6) / CELL_M) * CELL_M
    size = np.ceil((points.max(axis=0) + 0.6 - low) / CELL_M).astype(int)
    index = np.full((size[1], size[0]), NOTHING, np.int32)
    room = min(len(points), MAX_POINTS)
    kept_points, kept_normals = np.empty((room, 2)), np.empty((room, 2))
    kept = thin(points, normals, kept_points, kept_normals, 0, index, low)
    points, normals = kept_points[:kept].copy(), kept_normals[:kept].copy()
    return Surface(points, normals, index, low, _sight(points))


@njit(cache=True)
def _sight(points: Array) -> Array:
    """Return the distance to the nearest point in each direction, shape (360,); 0 where there is none."""
    nearest = np.full(_BEARINGS, inf)
    for i in range(points.shape[0]):
        r = hypot(points[i, 0], points[i, 1])
        half = 0.04 / max(r, 0.04)  # points lie about 4 cm apart
        bearing = atan2(points[i, 1], points[i, 0])
        first = floor((bearing - half + pi) / (2.0 * pi) * _BEARINGS)
        last = floor((bearing + half + pi) / (2.0 * pi) * _BEARINGS)
        for k in range(first, last + 1):
            nearest[k % _BEARINGS] = min(nearest[k % _BEARINGS], r)
    for k in range(_BEARINGS):
        if nearest[k] == inf:
            nearest[k] = 0.0
    return nearest


def explained(target_from_source: Array, source: Surface, target: Surface) -> tuple[int, int]:
    """Return how many source points lie on the target's surface, and how many where it saw free space."""
    on, off = _explained(
        target_from_source, source.points, source.normals,
        target.points, target.normals, target.index, target.origin, target.sight_m,
    )  # fmt: skip
    return int(on), int(off)


@njit(cache=True)
def _explained(
    pose: Array,
    points: Array,
    normals: Array,
    map_points: Array,
    map_normals: Array,
    index: Index,
    origin: Array,
    sight: Array,
) -> tuple[int, int]:
    c, s = cos(pose[2]), sin(pose[2])
    on, off = 0, 0
    for i in range(points.shape[0]):
        x = pose[0] + c * points[i, 0] - s * points[i, 1]
        y = pose[1] + s * points[i, 0] + c * points[i, 1]
        k = nearest(x, y, index, origin)
        if k >= 0 and hypot(x - map_points[k, 0], y - map_points[k, 1]) < _EXPLAINED_M:
            mx, my = c * normals[i, 0] - s * normals[i, 1], s * normals[i, 0] + c * normals[i, 1]
            unknown = (mx == 0.0 and my == 0.0) or (map_normals[k, 0] == 0.0 and map_normals[k, 1] == 0.0)
            if unknown or mx * map_normals[k, 0] + my * map_normals[k, 1] > 0.5:
                on += 1
                continue
        bearing = int((atan2(y, x) + pi) / (2.0 * pi) * _BEARINGS) % _BEARINGS
        if hypot(x, y) < sight[bearing] - _CLEAR_M:
            off += 1
    return on, off


def align(start: Array, target: Surface, source: Surface) -> tuple[Array, Array, int, float]:
    """Return pose (3,), Hessian (3, 3), matched points and rms in metres of the alignment from a start.

    Point-to-line ICP (Censi 2008) of the source on the target and of the target on the source at once.
    """
    pose, hessian, matched, rms = _align(
        start, target.points, target.normals, target.index, target.origin,
        source.points, source.normals, source.index, source.origin,
    )  # fmt: skip
    return pose, hessian, int(matched), float(rms)


@njit(cache=True)
def _align(
    start: Array,
    t_points: Array,
    t_normals: Array,
    t_index: Index,
    t_origin: Array,
    s_points: Array,
    s_normals: Array,
    s_index: Index,
    s_origin: Array,
) -> tuple[Array, Array, int, float]:
    pose = start.copy()
    hessian = np.zeros((3, 3))
    gradient = np.zeros(3)
    matched, squares = 0, 0.0
    gate = 0.4
    j = np.zeros(3)
    for iteration in range(_ITERATIONS):
        hessian[:, :] = 0.0
        gradient[:] = 0.0
        matched, squares = 0, 0.0
        c, s = cos(pose[2]), sin(pose[2])
        for way in range(2):
            points = s_points if way == 0 else t_points
            normals = s_normals if way == 0 else t_normals
            for i in range(points.shape[0]):
                px, py, qx, qy = points[i, 0], points[i, 1], normals[i, 0], normals[i, 1]
                if qx == 0.0 and qy == 0.0:
                    continue
                if way == 0:  # into the target's frame
                    rx, ry = c * px - s * py, s * px + c * py
                    x, y = pose[0] + rx, pose[1] + ry
                    k = nearest(x, y, t_index, t_origin)
                    if k < 0:
                        continue
                    dx, dy = x - t_points[k, 0], y - t_points[k, 1]
                    nx, ny = t_normals[k, 0], t_normals[k, 1]
                    qx, qy = c * qx - s * qy, s * qx + c * qy
                else:  # into the source's frame
                    ux, uy = px - pose[0], py - pose[1]
                    x, y = c * ux + s * uy, -s * ux + c * uy
                    k = nearest(x, y, s_index, s_origin)
                    if k < 0:
                        continue
                    dx, dy = x - s_points[k, 0], y - s_points[k, 1]
                    nx, ny = s_normals[k, 0], s_normals[k, 1]
                    qx, qy = c * qx + s * qy, -s * qx + c * qy
                if dx * dx + dy * dy > gate * gate or nx * qx + ny * qy < 0.7:
                    continue
                e = nx * dx + ny * dy
                if way == 0:
                    j[0], j[1], j[2] = nx, ny, -nx * ry + ny * rx
                else:
                    mx, my = c * nx - s * ny, s * nx + c * ny
                    j[0], j[1], j[2] = -mx, -my, mx * uy - my * ux
                w = 1.0 / (1.0 + (e / _INLIER_M) ** 2)
                for a in range(3):
                    gradient[a] += w * j[a] * e
                    for b in range(3):
                        hessian[a, b] += w * j[a] * j[b]
                if abs(e) < _INLIER_M:
                    matched += 1
                    squares += e * e
        damped = hessian.copy()
        for a in range(3):
            damped[a, a] += 0.5
        step = np.linalg.solve(damped, -gradient)
        pose += step
        gate = max(0.2, gate * 0.85)
        if iteration > 4 and abs(step[0]) + abs(step[1]) < 2e-4 and abs(step[2]) < 1e-4:
            break
    return pose, hessian, matched, (squares / max(matched, 1)) ** 0.5
