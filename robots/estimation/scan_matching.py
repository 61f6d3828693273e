"""Incremental scan matching: the pose that best aligns a scan with the local map of recent scans.

Point-to-line ICP (Censi 2008) over the nearest-point index, with a correlative search (Olson 2009) over a
coarse window where the plain start does not lead to a good alignment. The covariance is the Hessian's, scaled
by the residuals.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, exp, floor, hypot, sin

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robots.config import ScanMatchConfig
from robots.estimation.local_map import CELL_M, LocalMap
from robots.estimation.scan_points import ScanPoints
from robots.se2 import Array, GaussianPose, Pose2, wrap

_ITERATIONS = 25
_INLIER_M = 0.12
_ILLUSION, _SOUND = 0.01, 0.05  # mean squared share of the normals along a direction: noise, and surely real
_CORRELATED_POINTS = 3.0  # neighbouring beams share the map's errors: so many points count as one


@dataclass(frozen=True, slots=True, eq=False)
class ScanMatch:
    """An alignment of a scan with the local map.

    ``pose`` with covariance in the local frame, share of matched points, rms residual in metres.
    """

    pose: GaussianPose
    overlap: float
    rms_m: float


def match(local_map: LocalMap, scan: ScanPoints, guess: Pose2, config: ScanMatchConfig) -> ScanMatch | None:
    """Align a scan with the map, starting from ``guess`` (``local_from_base``).

    None where the scan cannot be trusted: too many far readings, too few points, too little overlap with the
    map, or a correction larger than odometry can be wrong (Kleiner 2006: then the pose is updated by odometry
    only).
    """
    if (
        scan.far_fraction > config.max_far_fraction
        or len(scan.points) < config.min_points
        or not len(local_map)
    ):
        return None
    start = guess.as_array()
    arguments = (
        scan.points,
        scan.normals,
        local_map.points,
        local_map.normals,
        local_map.index,
        local_map.origin,
    )
    pose, hessian, overlap, rms = _icp(start, *arguments)
    if overlap < config.min_overlap or not _plausible(start, pose, config):
        coarse = _correlate(start, scan.points, local_map.points, local_map.index, local_map.origin)
        second = _icp(coarse, *arguments)
        if second[2] > overlap:
            pose, hessian, overlap, rms = second
    if overlap < config.min_overlap or not _plausible(start, pose, config):
        return None
    sd = max(config.point_sd_m, rms)
    information = without_illusions(hessian, len(scan.points)) / (sd**2 * _CORRELATED_POINTS)
    covariance = np.linalg.inv(information + np.diag([1e-2, 1e-2, 1e-1]))
    return ScanMatch(GaussianPose(Pose2.from_array(pose), covariance), overlap, rms)


def without_illusions(hessian: Array, points: int) -> Array:
    """Take back the information along a direction that hardly any surface faces.

    In a bare corridor the scatter of the normals alone feigns information along it, and lets the scan stick
    to the last ones.
    """
    share, directions = np.linalg.eigh(hessian[:2, :2] / max(points, 1))
    keep = np.clip((share - _ILLUSION) / (_SOUND - _ILLUSION), 0.0, 1.0)
    scale = np.eye(3)
    scale[:2, :2] = directions @ np.diag(np.sqrt(keep)) @ directions.T
    sound: Array = scale @ hessian @ scale
    return sound


def _plausible(start: Array, pose: Array, config: ScanMatchConfig) -> bool:
    moved = hypot(pose[0] - start[0], pose[1] - start[1])
    turned = abs(wrap(float(pose[2] - start[2])))
    return moved <= config.max_correction_m and turned <= config.max_correction_rad


@njit(cache=True)
def _nearest(x: float, y: float, index: NDArray[np.int32], origin: Array) -> int:
    column = floor((x - origin[0]) / CELL_M)
    row = floor((y - origin[1]) / CELL_M)
    if row < 0 or column < 0 or row >= index.shape[0] or column >= index.shape[1]:
        return -1
    return int(index[row, column])


@njit(cache=True)
def _icp(
    start: Array,
    points: Array,
    normals: Array,
    map_points: Array,
    map_normals: Array,
    index: NDArray[np.int32],
    origin: Array,
) -> tuple[Array, Array, float, float]:
    """Return pose, Hessian, share of inliers and rms residual of the alignment.

    Pose (3,), Hessian (3, 3) of the squared residuals in metres, rms residual of the inliers in metres.
    """
    pose = start.copy()
    n = points.shape[0]
    hessian = np.zeros((3, 3))
    gradient = np.zeros(3)
    inliers = 0
    squares = 0.0
    gate = 0.5
    for iteration in range(_ITERATIONS):
        hessian[:, :] = 0.0
        gradient[:] = 0.0
        inliers = 0
        squares = 0.0
        c, s = cos(pose[2]), sin(pose[2])
        for i in range(n):
            rx = c * points[i, 0] - s * points[i, 1]
            ry = s * points[i, 0] + c * points[i, 1]
            x, y = pose[0] + rx, pose[1] + ry
            k = _nearest(x, y, index, origin)
            if k < 0:
                continue
            dx, dy = x - map_points[k, 0], y - map_points[k, 1]
            if dx * dx + dy * dy > gate * gate:
                continue
            nx, ny = map_normals[k, 0], map_normals[k, 1]
            if nx == 0.0 and ny == 0.0:  # no surface known there: both components count, a little
                w = 0.15 / (1.0 + (dx * dx + dy * dy) / (_INLIER_M * _INLIER_M))
                for axis in range(2):
                    ax, ay = (1.0, 0.0) if axis == 0 else (0.0, 1.0)
                    jt = -ax * ry + ay * rx
                    e = ax * dx + ay * dy
                    _accumulate(hessian, gradient, ax, ay, jt, e, w)
                if dx * dx + dy * dy < _INLIER_M * _INLIER_M:
                    inliers += 1
                continue
            if normals[i, 0] != 0.0 or normals[i, 1] != 0.0:  # the same side of the same surface?
                mx = c * normals[i, 0] - s * normals[i, 1]
                my = s * normals[i, 0] + c * normals[i, 1]
                if mx * nx + my * ny < 0.5:
                    continue
            e = nx * dx + ny * dy
            w = 1.0 / (1.0 + (e / _INLIER_M) ** 2)  # Cauchy-like: clutter pulls little
            _accumulate(hessian, gradient, nx, ny, -nx * ry + ny * rx, e, w)
            if abs(e) < _INLIER_M:
                inliers += 1
                squares += e * e
        damped = hessian.copy()
        damped[0, 0] += 0.5
        damped[1, 1] += 0.5
        damped[2, 2] += 0.5
        step = np.linalg.solve(damped, -gradient)
        pose[0] += step[0]
        pose[1] += step[1]
        pose[2] += step[2]
        gate = max(0.2, gate * 0.8)
        if iteration > 4 and abs(step[0]) + abs(step[1]) < 2e-4 and abs(step[2]) < 1e-4:
            break
    return pose, hessian, inliers / max(n, 1), (squares / max(inliers, 1)) ** 0.5


@njit(cache=True)
def _accumulate(hessian: Array, gradient: Array, jx: float, jy: float, jt: float, e: float, w: float) -> None:
    hessian[0, 0] += w * jx * jx
    hessian[0, 1] += w * jx * jy
    hessian[0, 2] += w * jx * jt
    hessian[1, 1] += w * jy * jy
    hessian[1, 2] += w * jy * jt
    hessian[2, 2] += w * jt * jt
    hessian[1, 0], hessian[2, 0], hessian[2, 1] = hessian[0, 1], hessian[0, 2], hessian[1, 2]
    gradient[0] += w * jx * e
    gradient[1] += w * jy * e
    gradient[2] += w * jt * e


@njit(cache=True)
def _correlate(
    start: Array, points: Array, map_points: Array, index: NDArray[np.int32], origin: Array
) -> Array:
    """Return the pose of highest alignment likelihood on a coarse lattice round ``start``."""
    stride = max(1, points.shape[0] // 60)
    best, best_score = start.copy(), -1.0
    for turn in range(-8, 9):
        theta = start[2] + turn * 0.05
        c, s = cos(theta), sin(theta)
        for ix in range(-5, 6):
            for iy in range(-5, 6):
                px, py = start[0] + ix * 0.1, start[1] + iy * 0.1
                score = 0.0
                for i in range(0, points.shape[0], stride):
                    x = px + c * points[i, 0] - s * points[i, 1]
                    y = py + s * points[i, 0] + c * points[i, 1]
                    k = _nearest(x, y, index, origin)
                    if k >= 0:
                        dx, dy = x - map_points[k, 0], y - map_points[k, 1]
                        score += exp(-(dx * dx + dy * dy) / (2.0 * 0.1 * 0.1))
                score -= 1e-3 * (ix * ix + iy * iy + turn * turn)
                if score > best_score:
                    best_score = score
                    best[0], best[1], best[2] = px, py, theta
    return best
