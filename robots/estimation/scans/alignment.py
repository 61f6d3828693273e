"""Point-to-line ICP (Censi 2008) of points with normals against indexed surface points.

The index is a grid whose cells know the surface point nearest to them. Where the surface points are in the
order of the beams, the true nearest is found from there by walking along them.
"""

from __future__ import annotations

from math import cos, inf, sin, sqrt

import numpy as np
from numba import njit

from robots.estimation.scans.nearest import CELL_M, NOTHING, Index, nearest, stamp
from robots.se2 import Array

_ITERATIONS = 25
_COARSE, _STRIDE = 3, 3
INLIER_M = 0.12
_REACH_CELLS = 3  # of the index of one scan
_SKIP_M = 0.04
_TOPS, _BELL_M = 4, 0.25  # of the correlative search
_SOFT = 0.3  # of the gate
_GATE_M, _LAST_GATE_M = 0.5, 0.2
_ILLUSION, _SOUND = 0.01, 0.05  # mean squared share of the normals along a direction: noise, and surely real
_DAMPING = 0.5


@njit(cache=True)
def solve3(a: Array, b: Array, x: Array) -> None:
    """Solve the symmetric positive definite system a x = b, (3, 3) and (3,), by its LDL^T factors."""
    l10, l20 = a[0, 1] / a[0, 0], a[0, 2] / a[0, 0]
    d1 = a[1, 1] - l10 * a[0, 1]
    u = a[1, 2] - l10 * a[0, 2]
    l21 = u / d1
    d2 = a[2, 2] - l20 * a[0, 2] - l21 * u
    y1 = b[1] - l10 * b[0]
    y2 = b[2] - l20 * b[0] - l21 * y1
    x[2] = y2 / d2
    x[1] = y1 / d1 - l21 * x[2]
    x[0] = b[0] / a[0, 0] - l10 * x[1] - l20 * x[2]


@njit(cache=True)
def take_back(hessian: Array, points: int, sound: Array) -> tuple[float, float, float]:
    """Write the Hessian without what is feigned; return the scale (a, b; b, d) of x and y that does it.

    In a bare corridor the scatter of the normals alone feigns information along it, and lets the scan stick
    to the last ones: a direction of the plane that hardly any surface faces counts for nothing.
    """
    m = float(max(points, 1))
    xx, xy, yy = hessian[0, 0] / m, hessian[0, 1] / m, hessian[1, 1] / m
    mean, half = (xx + yy) / 2.0, (xx - yy) / 2.0
    root = sqrt(half * half + xy * xy)
    weak, strong = _sound_share(mean - root), _sound_share(mean + root)
    a, b, d = strong, 0.0, strong
    if weak < strong and root > 0.0:
        # outer product of the strong direction: (1 + half/root, xy/root; ., 1 - half/root) / 2
        p, q = 0.5 * (1.0 + half / root), 0.5 * xy / root
        a, b, d = weak + (strong - weak) * p, (strong - weak) * q, weak + (strong - weak) * (1.0 - p)
    for r in range(2):
        f, g = (a, b) if r == 0 else (b, d)
        for k in range(3):
            sound[r, k] = f * hessian[0, k] + g * hessian[1, k]
    for r in range(2):
        u, v = sound[r, 0], sound[r, 1]
        sound[r, 0], sound[r, 1] = a * u + b * v, b * u + d * v
        sound[2, r] = sound[r, 2]
    sound[2, 2] = hessian[2, 2]
    return a, b, d


@njit(cache=True)
def _sound_share(share: float) -> float:
    return sqrt(min(max((share - _ILLUSION) / (_SOUND - _ILLUSION), 0.0), 1.0))


@njit(cache=True)
def covariance_of(hessian: Array, points: int, sd_m: float, correlated: float) -> Array:
    """Return the covariance (3, 3) of an alignment whose residuals have this deviation."""
    information = np.empty((3, 3))
    take_back(hessian, points, information)
    information /= sd_m * sd_m * correlated
    for axis in range(3):
        information[axis, axis] += 1e-1 if axis == 2 else 1e-2  # nothing is vaguer than 10 m, 180 degrees
    covariance, unit, column = np.empty((3, 3)), np.zeros(3), np.empty(3)
    for axis in range(3):
        unit[:] = 0.0
        unit[axis] = 1.0
        solve3(information, unit, column)
        covariance[axis] = column
    return (covariance + covariance.T) / 2.0


@njit(cache=True)
def icp(
    start: Array,
    points: Array,
    normals: Array,
    map_points: Array,
    map_normals: Array,
    index: Index,
    origin: Array,
    ordered: bool,
    soft_m: float,
    hold: float,
) -> tuple[Array, Array, float, float]:
    """Return pose, Hessian, share of inliers and rms residual of the alignment.

    Pose (3,), Hessian (3, 3) of the squared residuals in metres, rms residual of the inliers in metres.
    ``ordered``: the map's points are in the order of the beams. ``soft_m``: residuals beyond it lose weight;
    at first, while the pose is far off, only larger ones. ``hold``: weight of the start as a measurement, in
    points: where no surface faces, the pose stays there. For a start that is fused with the result afterwards
    it has to be 0, or it would count twice.
    """
    pose = start.copy()
    n, last = points.shape[0], map_points.shape[0] - 1
    hessian = np.zeros((3, 3))
    gradient = np.zeros(3)
    damped = np.zeros((3, 3))
    step = np.zeros(3)
    inliers = 0
    squares = 0.0
    gate = _GATE_M
    for iteration in range(_ITERATIONS):
        hxx, hxy, hxt, hyy, hyt, htt = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        gx, gy, gt = 0.0, 0.0, 0.0
        inliers = 0
        squares = 0.0
        c, s = cos(pose[2]), sin(pose[2])
        soft = max(soft_m, _SOFT * gate)
        for i in range(0, n, _STRIDE if iteration < _COARSE else 1):
            rx = c * points[i, 0] - s * points[i, 1]
            ry = s * points[i, 0] + c * points[i, 1]
            x, y = pose[0] + rx, pose[1] + ry
            k = nearest(x, y, index, origin)
            if k < 0:
                continue
            dx, dy = x - map_points[k, 0], y - map_points[k, 1]
            d2 = dx * dx + dy * dy
            if ordered:
                moved = False
                while k < last:  # along the beams while it comes nearer
                    ex, ey = x - map_points[k + 1, 0], y - map_points[k + 1, 1]
                    e2 = ex * ex + ey * ey
                    if e2 >= d2:
                        break
                    k, dx, dy, d2, moved = k + 1, ex, ey, e2, True
                while k > 0 and not moved:
                    ex, ey = x - map_points[k - 1, 0], y - map_points[k - 1, 1]
                    e2 = ex * ex + ey * ey
                    if e2 >= d2:
                        break
                    k, dx, dy, d2 = k - 1, ex, ey, e2
            if d2 > gate * gate:
                continue
            nx, ny = map_normals[k, 0], map_normals[k, 1]
            if nx == 0.0 and ny == 0.0:  # no surface known there: both components count, a little
                w = 0.15 / (1.0 + d2 / (soft * soft))
                hxx += w
                hyy += w
                hxt -= w * ry
                hyt += w * rx
                htt += w * (rx * rx + ry * ry)
                gx += w * dx
                gy += w * dy
                gt += w * (rx * dy - ry * dx)
                if d2 < INLIER_M * INLIER_M:
                    inliers += 1
                continue
            if normals[i, 0] != 0.0 or normals[i, 1] != 0.0:  # the same side of the same surface?
                mx = c * normals[i, 0] - s * normals[i, 1]
                my = s * normals[i, 0] + c * normals[i, 1]
                if mx * nx + my * ny < 0.5:
                    continue
            e = nx * dx + ny * dy
            jt = rx * ny - ry * nx
            w = 1.0 / (1.0 + e * e / (soft * soft))  # Cauchy-like: clutter pulls little
            wx, wy, wt = w * nx, w * ny, w * jt
            hxx += wx * nx
            hxy += wx * ny
            hxt += wx * jt
            hyy += wy * ny
            hyt += wy * jt
            htt += wt * jt
            gx += wx * e
            gy += wy * e
            gt += wt * e
            if abs(e) < INLIER_M:
                inliers += 1
                squares += e * e
        hessian[0, 0], hessian[0, 1], hessian[0, 2] = hxx, hxy, hxt
        hessian[1, 0], hessian[1, 1], hessian[1, 2] = hxy, hyy, hyt
        hessian[2, 0], hessian[2, 1], hessian[2, 2] = hxt, hyt, htt
        a, b, d = 1.0, 0.0, 1.0
        if hold > 0.0:
            a, b, d = take_back(hessian, n, damped)
        else:
            damped[:, :] = hessian
        ex, ey, et = pose[0] - start[0], pose[1] - start[1], pose[2] - start[2]
        gradient[0], gradient[1] = -(a * gx + b * gy) - hold * ex, -(b * gx + d * gy) - hold * ey
        gradient[2] = -gt - hold * et
        for axis in range(3):
            damped[axis, axis] += hold + _DAMPING
        solve3(damped, gradient, step)
        step[0], step[1] = a * step[0] + b * step[1], b * step[0] + d * step[1]
        pose += step
        gate = max(_LAST_GATE_M, gate * 0.8)
        if iteration > _COARSE and abs(step[0]) + abs(step[1]) < 4e-4 and abs(step[2]) < 2e-4:
            break
    return pose, hessian, inliers / max(n, 1), sqrt(squares / max(inliers, 1))


@njit(cache=True)
def index_scan(points: Array, limit_m: float) -> tuple[Index, Array]:
    """Return the index (h, w) of the points of one scan, (n, 2) in the order of the beams, and its corner.

    A cell knows the nearest of the points within ``_REACH_CELLS`` cells of it. Points beyond ``limit_m`` are
    left out, and those so near to the last one that a step along the beams finds them.
    """
    low, high = np.zeros(2), np.zeros(2)
    for i in range(points.shape[0]):
        for axis in range(2):
            if abs(points[i, axis]) <= limit_m:
                low[axis] = min(low[axis], points[i, axis])
                high[axis] = max(high[axis], points[i, axis])
    origin = low - _REACH_CELLS * CELL_M
    columns = int((high[0] - origin[0]) / CELL_M) + 2 + _REACH_CELLS
    rows = int((high[1] - origin[1]) / CELL_M) + 2 + _REACH_CELLS
    index = np.full((rows, columns), NOTHING, np.int32)
    last_x, last_y = inf, inf
    for i in range(points.shape[0]):
        dx, dy = points[i, 0] - last_x, points[i, 1] - last_y
        if dx * dx + dy * dy >= _SKIP_M * _SKIP_M:
            last_x, last_y = points[i, 0], points[i, 1]
            stamp(index, origin, i, last_x, last_y, _REACH_CELLS)
    return index, origin


@njit(cache=True)
def correlate(start: Array, points: Array, map_points: Array, index: Index, origin: Array) -> Array:
    """Return the pose of highest alignment likelihood round ``start``, within 0.7 m and 30 degrees of it.

    A lattice of 0.2 m and 0.1 rad first, then one of half its width round its best places (Olson 2009).
    """
    stride = max(1, points.shape[0] // 60)
    tops = np.full(_TOPS, -inf)
    places = np.empty((_TOPS, 3))
    places[:] = start
    pose = np.empty(3)
    for turn in range(-4, 5):
        for ix in range(-3, 4):
            for iy in range(-3, 4):
                pose[0], pose[1], pose[2] = start[0] + ix * 0.2, start[1] + iy * 0.2, start[2] + turn * 0.1
                score = _likelihood(pose, points, stride, map_points, index, origin)
                score -= 4e-3 * (ix * ix + iy * iy + turn * turn)
                k = _TOPS
                while k > 0 and score > tops[k - 1]:
                    k -= 1
                if k < _TOPS:
                    tops[k + 1 :] = tops[k:-1].copy()
                    places[k + 1 :] = places[k:-1].copy()
                    tops[k], places[k] = score, pose
    best, best_score = start.copy(), -inf
    for k in range(_TOPS):
        for turn in range(-1, 2):
            for ix in range(-1, 2):
                for iy in range(-1, 2):
                    pose[:] = places[k]
                    pose[0] += 0.1 * ix
                    pose[1] += 0.1 * iy
                    pose[2] += 0.05 * turn
                    score = _likelihood(pose, points, stride, map_points, index, origin)
                    score -= 0.1 * ((pose[0] - start[0]) ** 2 + (pose[1] - start[1]) ** 2)
                    score -= 0.4 * (pose[2] - start[2]) ** 2
                    if score > best_score:
                        best_score = score
                        best[:] = pose
    return best


@njit(cache=True)
def _likelihood(
    pose: Array, points: Array, stride: int, map_points: Array, index: Index, origin: Array
) -> float:
    c, s = cos(pose[2]), sin(pose[2])
    score = 0.0
    for i in range(0, points.shape[0], stride):
        x = pose[0] + c * points[i, 0] - s * points[i, 1]
        y = pose[1] + s * points[i, 0] + c * points[i, 1]
        k = nearest(x, y, index, origin)
        if k >= 0:
            dx, dy = x - map_points[k, 0], y - map_points[k, 1]
            bell = 1.0 - (dx * dx + dy * dy) / (_BELL_M * _BELL_M)  # Epanechnikov's
            if bell > 0.0:
                score += bell
    return score
