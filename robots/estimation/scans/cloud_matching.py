"""Matching two clouds of surface points: what a loop closure measures.

Each cloud was gathered by the scans round an anchor. A correlative search over the window of poses (Olson
2009) proposes every distinct alignment, point-to-line ICP in both directions refines each, and what one cloud
saw as free space contradicts walls of the other. The best alignment comes with its margin over the second
best, so that a place which merely looks alike can be refused.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, pi, radians, sin

import numpy as np

from robots.estimation.scans.alignment import covariance_of
from robots.estimation.scans.cloud_alignment import Surface, align, explained, surface
from robots.estimation.scans.cloud_search import peaks
from robots.se2 import Array, GaussianPose, Pose2, wrap

REACH_M = 15.0  # points farther from the anchor are left out: there a degree is half a metre
_MIN_POINTS = 30
_PEAKS = 6
_SAME_M, _SAME_RAD = 0.2, radians(6.0)  # alignments nearer than this are one
_POINT_SD_M = 0.03
_CORRELATED_POINTS = 6.0  # the clouds' own errors are shared by neighbours and by both directions
_CLOUD_SD_M, _CLOUD_SD_RAD = (
    0.01,
    radians(0.25),
)  # how far a cloud bends over the few metres it was gathered on


@dataclass(frozen=True, slots=True, eq=False)
class Cloud:
    """Surface points round an anchor, in the anchor's frame.

    ``points`` (n, 2) in metres; ``normals`` (n, 2), unit, towards the sensor, zero where unknown.
    """

    points: Array
    normals: Array


@dataclass(frozen=True, slots=True)
class Window:
    """How far off the guess may be.

    Metres to each side along x and y, radians to each side; pi for any heading.
    """

    reach_m: float = 0.6
    turn_rad: float = radians(30.0)


@dataclass(frozen=True, slots=True, eq=False)
class CloudMatch:
    """An alignment of two clouds.

    ``pose``: ``target_from_source`` with covariance. ``overlap``: share of the points where both clouds could
    see that both saw, the smaller of the two directions. ``rms_m``: residual across the surfaces of the
    points that match. ``margin``: 0 where another pose in the window explains the clouds as well, 1 where
    none does at all.
    """

    pose: GaussianPose
    overlap: float
    rms_m: float
    margin: float


def match_clouds(target: Cloud, source: Cloud, guess: Pose2, window: Window) -> CloudMatch | None:
    """Return the best alignment of the source with the target within the window round ``guess``.

    ``guess`` is ``target_from_source``. None where a cloud has too few points or no alignment was
    found; whether an alignment is good enough is the caller's to judge by ``overlap`` and ``margin``.

    Raises:
        ValueError: a cloud has not one normal for each point.
    """
    target_surface, source_surface = surface(*_usable(target)), surface(*_usable(source))
    if min(len(target_surface.points), len(source_surface.points)) < _MIN_POINTS:
        return None
    starts = peaks(target_surface, source_surface, guess.as_array(), window.reach_m, window.turn_rad, _PEAKS)
    found: list[_Candidate] = []
    for start in starts:
        pose, hessian, matched, rms = align(start, target_surface, source_surface)
        if any(_same(pose, other.pose) for other in found) or not _inside(pose, guess, window):
            continue
        overlap, support = _overlap(pose, target_surface, source_surface)
        found.append(_Candidate(pose, hessian, matched, rms, overlap, overlap * support))
    if not found:
        return None
    found.sort(key=lambda candidate: -candidate.score)
    best = found[0]
    if best.score <= 0.0:
        return None
    margin = 1.0 - found[1].score / best.score if len(found) > 1 else 1.0
    covariance = _covariance(best)
    return CloudMatch(GaussianPose(Pose2.from_array(best.pose), covariance), best.overlap, best.rms_m, margin)


@dataclass(frozen=True, slots=True, eq=False)
class _Candidate:
    pose: Array
    hessian: Array
    matched: int  # pairs, both directions
    rms_m: float
    overlap: float
    score: float


def _usable(cloud: Cloud) -> tuple[Array, Array]:
    points = np.asarray(cloud.points, np.float64).reshape(-1, 2)
    normals = np.asarray(cloud.normals, np.float64).reshape(-1, 2)
    if len(points) != len(normals):
        raise ValueError(f"a cloud needs one normal for each point, not {len(normals)} for {len(points)}")
    with np.errstate(invalid="ignore", over="ignore"):
        good = (np.abs(points) <= REACH_M).all(axis=1) & np.isfinite(normals).all(axis=1)
    return np.ascontiguousarray(points[good]), np.ascontiguousarray(normals[good])


def _overlap(pose: Array, target: Surface, source: Surface) -> tuple[float, float]:
    """Return the overlap (the smaller of both directions) and the share of all points that are explained."""
    c, s = cos(pose[2]), sin(pose[2])
    back = np.array([-c * pose[0] - s * pose[1], s * pose[0] - c * pose[1], -pose[2]])
    there, missed_there = explained(pose, source, target)
    here, missed_here = explained(back, target, source)
    overlap = min(there / max(there + missed_there, 1), here / max(here + missed_here, 1))
    support = (there + here) / (len(target.points) + len(source.points))
    return overlap, support


def _covariance(best: _Candidate) -> Array:
    sd_m = max(_POINT_SD_M, best.rms_m)
    bent = np.diag([_CLOUD_SD_M**2, _CLOUD_SD_M**2, _CLOUD_SD_RAD**2])
    covariance: Array = covariance_of(best.hessian, best.matched, sd_m, _CORRELATED_POINTS) + bent
    return covariance


def _same(a: Array, b: Array) -> bool:
    return bool(np.hypot(a[0] - b[0], a[1] - b[1]) < _SAME_M and abs(wrap(float(a[2] - b[2]))) < _SAME_RAD)


def _inside(pose: Array, guess: Pose2, window: Window) -> bool:
    """Say whether an alignment lies in the window, or hardly outside."""
    slack_m, slack_rad = 0.2, radians(5.0)
    return bool(
        abs(pose[0] - guess.x) <= window.reach_m + slack_m
        and abs(pose[1] - guess.y) <= window.reach_m + slack_m
        and (window.turn_rad >= pi or abs(wrap(float(pose[2] - guess.theta))) <= window.turn_rad + slack_rad)
    )
