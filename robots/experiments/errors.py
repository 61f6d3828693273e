"""How far a robot's trajectory, tags and map are from the truth, rigidly aligned and from the fixed start."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robots.evaluation import Alignment, align
from robots.experiments.course import Course
from robots.graph_report import IntArray
from robots.se2 import Array, Pose2


@dataclass(frozen=True, slots=True)
class Errors:
    """Root mean squares in metres: of the positions, of the tags, and of the walls as the laser saw them.

    The map's error is the distance between where a laser point would be drawn and where that wall truly is.
    """

    trajectory_m: float
    tags_m: float
    map_m: float


NAMES = ("trajectory", "tags", "map")


@dataclass(frozen=True, slots=True)
class Judged:
    """The same estimate after rigid alignment, and as it lies when the start is known.

    ``rescaled_m`` is the trajectory's error when its scale may be chosen too.
    """

    aligned: Errors
    from_start: Errors
    rescaled_m: float


def judge(
    course: Course, ticks: IntArray, poses: Array, tags_m: Array, tag_order: IntArray, world_from_map: Pose2
) -> Judged:
    """Compare an estimate with the truth of a course.

    Trajectory and map are aligned by the trajectory, tags by the tags (rigidly, Umeyama 1991).

    Args:
        course: what truly happened.
        ticks: (k,) ticks of the course, all frames among them.
        poses: (k, 3) estimated, in the map frame.
        tags_m: (m, 2) estimated, in the map frame.
        tag_order: (m,) which of the course's tags each is.
        world_from_map: where the map frame truly lies.
    """
    truth, true_tags = course.poses[ticks], course.tags_m[tag_order]
    framed = np.searchsorted(ticks, course.frames)
    true_points = _points(course.poses[course.frames], course.frame_points)
    points = _points(poses[framed], course.frame_points)
    by_path = align(poses[:, :2], truth[:, :2])
    by_tags = align(tags_m, true_tags) if len(tags_m) > 2 else by_path
    c, s = np.cos(world_from_map.theta), np.sin(world_from_map.theta)
    placed = Alignment(np.array([[c, -s], [s, c]]), np.array([world_from_map.x, world_from_map.y]))

    def errors(path: Alignment, of_tags: Alignment) -> Errors:
        return Errors(
            rms(path.apply(poses[:, :2]) - truth[:, :2]),
            rms(of_tags.apply(tags_m) - true_tags),
            rms(path.apply(points) - true_points),
        )

    path = by_path.apply(poses[:, :2]) - truth[:, :2].mean(axis=0)
    true_path = truth[:, :2] - truth[:, :2].mean(axis=0)
    scale = np.sum(path * true_path) / np.sum(path**2)  # Umeyama 1991 eq. 42, the rotation found already
    return Judged(errors(by_path, by_tags), errors(placed, placed), rms(scale * path - true_path))


def rms(gaps_m: Array) -> float:
    """Return the root mean square length of (n, 2) gaps; NaN where there are none."""
    return float(np.sqrt(np.mean(np.sum(gaps_m**2, axis=1)))) if len(gaps_m) else float("nan")


def _points(poses: Array, points_in_base: Array) -> Array:
    """Return laser points, (p, 2), seen from poses (f, 3) at (f, b, 2) in the base frame; misses left out."""
    c, s = np.cos(poses[:, 2, None]), np.sin(poses[:, 2, None])
    x, y = points_in_base[..., 0], points_in_base[..., 1]
    placed = np.stack([poses[:, 0, None] + c * x - s * y, poses[:, 1, None] + s * x + c * y], axis=-1)
    return placed[np.isfinite(x)]
