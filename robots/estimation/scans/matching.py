"""Scan matching: the pose that best aligns a scan with another one, or with the local map of recent scans.

Point-to-line ICP (Censi 2008) over a nearest-point index, with a correlative search (Olson 2009) over a
coarse window where the plain start does not lead to a good alignment. The covariance is the Hessian's, scaled
by the residuals.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import hypot, isfinite

import numpy as np

from robots.estimation.scans.alignment import correlate, covariance_of, icp, index_scan
from robots.estimation.scans.local_map import LocalMap
from robots.estimation.scans.nearest import MAX_POINTS, Index
from robots.estimation.scans.points import ScanPoints, scan_points
from robots.scan_config import ScanMatchConfig
from robots.se2 import Array, GaussianPose, Pose2, wrap
from robots.types import LaserScan

_MAP_CORRELATED = 3.0  # neighbouring beams share the map's errors: so many points count as one
_SCAN_CORRELATED = 6.0  # of a pair of scans: each point was moved onto the line of about so many
_SCAN_SD_M = 0.005  # residuals of smoothed points are no smaller on real walls
_INDEX_REACH_M = 40.0
_SCAN_SOFT_M, _MAP_SOFT_M = 0.06, 0.12  # two noises of 3 cm; the errors of the map's poses as well
_HOLD = 0.1  # the guess of a pair: 15 cm or 9 degrees, decides only where no surface does
_DOUBT = 0.7  # below this overlap a second start is tried, and believed where it is much better:
_MUCH_BETTER = 0.2  # a little more overlap is won by sliding along a corridor into what is known


@dataclass(frozen=True, slots=True, eq=False)
class ScanMatch:
    """An alignment of a scan with the local map, or with a reference scan.

    ``pose`` with covariance in the local frame, or in the base frame of the reference; share of matched
    points, rms residual in metres.
    """

    pose: GaussianPose
    overlap: float
    rms_m: float


@dataclass(frozen=True, slots=True, eq=False)
class ScanReference:
    """A scan others are matched against, prepared once.

    ``index`` int32 (h, w): the point nearest to each cell, -1 where none is near; ``origin`` (2,) the corner
    of cell (0, 0) in metres.
    """

    points: ScanPoints
    index: Index
    origin: Array


def reference_of(scan: LaserScan, config: ScanMatchConfig) -> ScanReference:
    """Return a scan prepared as the reference of ``match_scans``."""
    points = scan_points(scan, config.max_range_m, smooth=True)
    stride = -(-len(points.points) // MAX_POINTS)
    if stride > 1:
        thinned = (
            np.ascontiguousarray(points.points[::stride]),
            np.ascontiguousarray(points.normals[::stride]),
        )
        points = ScanPoints(*thinned, points.far_fraction)
    return ScanReference(points, *index_scan(points.points, _INDEX_REACH_M))


def match_scans(
    reference: LaserScan | ScanReference, scan: LaserScan | ScanPoints, guess: Pose2, config: ScanMatchConfig
) -> ScanMatch | None:
    """Align a scan with another one, starting from ``guess`` (``reference_from_scan``).

    None where a scan cannot be trusted: too many far readings, too few points, too little overlap, or a
    correction larger than the configuration allows.
    """
    if isinstance(reference, LaserScan):
        reference = reference_of(reference, config)
    if isinstance(scan, LaserScan):
        scan = scan_points(scan, config.max_range_m, smooth=True)
    if not _usable(reference.points, config):
        return None
    points = reference.points
    target = points.points, points.normals, reference.index, reference.origin, True, _SCAN_SOFT_M, _HOLD
    return _match(target, scan, guess, config, _SCAN_SD_M, _SCAN_CORRELATED)


def match(local_map: LocalMap, scan: ScanPoints, guess: Pose2, config: ScanMatchConfig) -> ScanMatch | None:
    """Align a scan with the map, starting from ``guess`` (``local_from_base``).

    None where the scan cannot be trusted: too many far readings, too few points, too little overlap with the
    map, or a correction larger than odometry can be wrong (Kleiner 2006: then the pose is updated by odometry
    only).
    """
    if not len(local_map):
        return None
    target = local_map.points, local_map.normals, local_map.index, local_map.origin, False, _MAP_SOFT_M, 0.0
    return _match(target, scan, guess, config, config.point_sd_m, _MAP_CORRELATED)


def _match(
    target: tuple[Array, Array, Index, Array, bool, float, float],
    scan: ScanPoints,
    guess: Pose2,
    config: ScanMatchConfig,
    least_sd_m: float,
    correlated: float,
) -> ScanMatch | None:
    if not _usable(scan, config) or not (isfinite(guess.x) and isfinite(guess.y) and isfinite(guess.theta)):
        return None
    start = guess.as_array()
    pose, hessian, overlap, rms = icp(start, scan.points, scan.normals, *target)
    failed = overlap < config.min_overlap or not _plausible(start, pose, config)
    if failed or overlap < _DOUBT:
        points, _, index, origin, *_ = target
        elsewhere = correlate(start, scan.points, points, index, origin)
        second = icp(elsewhere, scan.points, scan.normals, *target)
        if second[2] > overlap + (0.0 if failed else _MUCH_BETTER):
            pose, hessian, overlap, rms = second
    if overlap < config.min_overlap or not _plausible(start, pose, config):
        return None
    covariance = covariance_of(hessian, len(scan.points), max(least_sd_m, rms), correlated)
    return ScanMatch(GaussianPose(Pose2.from_array(pose), covariance), overlap, rms)


def _usable(scan: ScanPoints, config: ScanMatchConfig) -> bool:
    return scan.far_fraction <= config.max_far_fraction and len(scan.points) >= config.min_points


def _plausible(start: Array, pose: Array, config: ScanMatchConfig) -> bool:
    moved = hypot(pose[0] - start[0], pose[1] - start[1])
    turned = abs(wrap(float(pose[2] - start[2])))
    return moved <= config.max_correction_m and turned <= config.max_correction_rad
