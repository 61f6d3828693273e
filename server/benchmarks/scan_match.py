"""How accurate and how fast scans are matched in pairs, beside small_gicp where that is installed."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import dataclass
from math import atan2, cos, hypot, nan, radians, sin
from pathlib import Path
from time import thread_time
from typing import Any

import numpy as np

from robots.estimation.scans.matching import match_scans, reference_of
from robots.scan_config import ScanMatchConfig
from robots.se2 import Array, GaussianPose, Pose2, wrap
from robots.types import LaserScan
from server.benchmarks.scan_pairs import ScanPair, buildings, pairs

_CONFIG = ScanMatchConfig()
_NEAR_M, _NEAR_RAD = 0.10, radians(2.0)

Matcher = Callable[[ScanPair], GaussianPose | None]


@dataclass(frozen=True, slots=True, eq=False)
class _Outcome:
    """One match: error in metres and radians, its squared Mahalanobis distance, processor time in seconds."""

    building: str
    error_m: float
    error_rad: float
    nees: float
    refused: bool
    time_s: float


def measure(folder: Path | None, count: int, seed: int) -> dict[str, Any]:
    """Match ``count`` pairs in each building, ours and the rival taking turns.

    Times are the processor's, from two ``LaserScan`` to the pose with covariance; ``with_reference_ms`` has
    the reference scan prepared beforehand. A refused pair counts with the error of its guess.
    """
    every = list(pairs(buildings(folder), count, seed))
    rival = _small_gicp()
    matchers: dict[str, Matcher] = {"ours": _ours}
    if rival is not None:
        matchers["small_gicp"] = rival
    for matcher in matchers.values():
        matcher(every[0])  # compiled before it counts
    outcomes: dict[str, list[_Outcome]] = {name: [] for name in matchers}
    prepared_s = []
    for pair in every:
        for name, matcher in matchers.items():
            outcomes[name].append(_outcome(pair, matcher))
        prepared_s.append(_with_reference_s(pair))
    result: dict[str, Any] = {"pairs": len(every), **_summary(outcomes["ours"])}
    result["with_reference_ms_p50"] = float(np.median(prepared_s)) * 1e3
    result["mean_error_cm_in"] = {
        name: float(np.mean([o.error_m for o in outcomes["ours"] if o.building == name])) * 100.0
        for name in dict.fromkeys(pair.building for pair in every)
    }
    result["small_gicp"] = _summary(outcomes["small_gicp"]) if rival is not None else "not installed"
    return result


def _summary(outcomes: list[_Outcome]) -> dict[str, Any]:
    errors_m = np.array([o.error_m for o in outcomes])
    errors_rad = np.array([o.error_rad for o in outcomes])
    times_ms = np.array([o.time_s for o in outcomes]) * 1e3
    nees = np.array([o.nees for o in outcomes])
    return {
        "mean_error_cm": float(errors_m.mean()) * 100.0,
        "median_error_cm": float(np.median(errors_m)) * 100.0,
        "mean_error_deg": float(np.degrees(errors_rad.mean())),
        "within_10_cm_2_deg": float(np.mean((errors_m < _NEAR_M) & (errors_rad < _NEAR_RAD))),
        "refused": sum(o.refused for o in outcomes),
        "mean_nees_of_3": float(np.nanmean(nees)) if np.isfinite(nees).any() else nan,
        "ms_p50": float(np.median(times_ms)),
        "ms_p99": float(np.percentile(times_ms, 99)),
    }


def _outcome(pair: ScanPair, matcher: Matcher) -> _Outcome:
    began = thread_time()  # of this thread alone: other work on the machine does not count
    found = matcher(pair)
    took = thread_time() - began
    pose = pair.guess if found is None else found.mean
    error = np.array([pose.x - pair.true.x, pose.y - pair.true.y, wrap(pose.theta - pair.true.theta)])
    nees = nan
    if found is not None and np.any(found.covariance):
        nees = float(error @ np.linalg.solve(found.covariance, error))
    return _Outcome(pair.building, hypot(error[0], error[1]), abs(error[2]), nees, found is None, took)


def _ours(pair: ScanPair) -> GaussianPose | None:
    found = match_scans(pair.reference, pair.scan, pair.guess, _CONFIG)
    return None if found is None else found.pose


def _with_reference_s(pair: ScanPair) -> float:
    reference = reference_of(pair.reference, _CONFIG)
    began = thread_time()
    match_scans(reference, pair.scan, pair.guess, _CONFIG)
    return thread_time() - began


def _small_gicp() -> Matcher | None:
    """Return the rival (point-to-point ICP, its most accurate mode on flat scans); None without it."""
    try:
        library = importlib.import_module("small_gicp")
    except ImportError:
        return None

    def match(pair: ScanPair) -> GaussianPose | None:
        found = library.align(
            _in_space(pair.reference),
            _in_space(pair.scan),
            init_T_target_source=_homogeneous(pair.guess),
            registration_type="ICP",
            downsampling_resolution=0.02,
            max_correspondence_distance=0.5,
        ).T_target_source
        return GaussianPose.exact(Pose2(found[0, 3], found[1, 3], atan2(found[1, 0], found[0, 0])))

    return match


def _in_space(scan: LaserScan) -> Array:
    """Return the hits as points in space, (n, 3)."""
    beams = np.flatnonzero(np.isfinite(scan.ranges_m))
    angles = scan.angle_min_rad + beams * scan.angle_increment_rad
    ranges = scan.ranges_m[beams].astype(np.float64)
    return np.column_stack([ranges * np.cos(angles), ranges * np.sin(angles), np.zeros(len(beams))])


def _homogeneous(pose: Pose2) -> Array:
    matrix = np.eye(4)
    matrix[:2, :2] = [[cos(pose.theta), -sin(pose.theta)], [sin(pose.theta), cos(pose.theta)]]
    matrix[:2, 3] = pose.x, pose.y
    return matrix
