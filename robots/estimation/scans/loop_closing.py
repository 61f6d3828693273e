"""Loops closed at tags that are seen again.

The tag's id says which place this is, so nothing has to be recognised; the laser says how the robot stands
there now against how it stood there then, far better than the antenna does. The surroundings of a sighting
are the surface points of the scans taken shortly before and after it: a single scan may face the other way.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import hypot, pi, sqrt

import numpy as np

from robots.estimation.scans.cloud_matching import Cloud, CloudMatch, Window, match_clouds
from robots.estimation.scans.points import ScanPoints
from robots.scan_config import LoopConfig
from robots.se2 import Array, GaussianPose, Pose2, wrap
from robots.types import FloatArray32

_SAME_PLACE = 13.8  # chi-square, 2 degrees of freedom: 1 in 1000 right matches is refused
# Surroundings are as bent as dead reckoning and scan matching bend them over the metres they are gathered on.
_BENT = np.diag([0.03**2, 0.03**2, 0.01**2])
_SEARCH_SD, _MOST_WINDOW_M = 3.0, 1.5
_ON_THE_SPOT = 40  # scans that are kept of one spot: more say nothing new
_LIKE_THE_GRAPH = 25.0  # 3 degrees of freedom; the graph's covariance is only first order


@dataclass(frozen=True, slots=True)
class Sighting:
    """A tag seen from a pose vertex.

    ``place_m`` of the tag in the vertex' frame, ``covariance`` (2, 2); ``driven_m`` when.
    """

    vertex: int
    tag: int
    place_m: tuple[float, float]
    covariance: Array
    driven_m: float


@dataclass(frozen=True, slots=True, eq=False)
class Loop:
    """Pose of vertex ``later`` in the frame of vertex ``earlier``, matched by laser."""

    earlier: int
    later: int
    earlier_from_later: GaussianPose


@dataclass(frozen=True, slots=True, eq=False)
class _KeyScan:
    driven_m: float
    local_from_base: Pose2
    points: FloatArray32
    normals: FloatArray32


@dataclass(frozen=True, slots=True)
class _Place:
    driven_m: float
    local_from_anchor: Pose2


class LoopCloser:
    """Keeps the surroundings of sightings and matches those of one tag with each other, one pair a call."""

    def __init__(self, config: LoopConfig) -> None:
        self._config = config
        self._scans: list[_KeyScan] = []
        self._driven: list[float] = []  # of the scans
        self._places: dict[int, _Place] = {}
        self._sightings: dict[int, list[Sighting]] = {}  # by tag
        self._waiting: deque[Sighting] = deque()
        self._pairs: deque[tuple[Sighting, Sighting]] = deque()

    def keep(self, local_from_base: Pose2, driven_m: float, scan: ScanPoints) -> None:
        """Keep a scan's points, in the base frame, if the robot has moved on since the last one kept."""
        if not len(scan.points):
            return
        if self._scans:
            moved = self._scans[-1].local_from_base.between(local_from_base)
            near = hypot(moved.x, moved.y) < self._config.key_scan_m
            if near and abs(moved.theta) < self._config.key_scan_rad:
                return
            if len(self._driven) >= _ON_THE_SPOT and (
                driven_m - self._driven[-_ON_THE_SPOT] < self._config.key_scan_m
            ):
                return
        points, normals = scan.points.astype(np.float32), scan.normals.astype(np.float32)
        self._scans.append(_KeyScan(driven_m, local_from_base, points, normals))
        self._driven.append(driven_m)

    def anchored(self, vertex: int, local_from_anchor: Pose2, driven_m: float) -> None:
        """Note where in the tracker's local frame a pose vertex is."""
        self._places[vertex] = _Place(driven_m, local_from_anchor)

    def sighted(self, sighting: Sighting) -> None:
        """Note a sighting; it is matched with earlier ones once its surroundings have been seen."""
        of_tag = self._sightings.setdefault(sighting.tag, [])
        if of_tag and sighting.driven_m - of_tag[-1].driven_m < 2.0 * self._config.reach_m:
            return  # the surroundings would be the same scans
        of_tag.append(sighting)
        if len(of_tag) > 1:
            self._waiting.append(sighting)

    def close(
        self, driven_m: float, poses: Sequence[Pose2], relative: Callable[[int, int], GaussianPose]
    ) -> Loop | None:
        """Match at most one pair of sightings that is due; return the loop if the match holds.

        ``poses``: where the graph has its vertices now; ``relative``: how surely it knows the second of two
        in the frame of the first.
        """
        while self._waiting and driven_m - self._waiting[0].driven_m >= self._config.reach_m:
            later = self._waiting.popleft()
            self._pairs.extend((earlier, later) for earlier in self._chosen(later, poses))
        if not self._pairs:
            return None
        earlier, later = self._pairs.popleft()
        belief = relative(earlier.vertex, later.vertex)
        match = self.match(earlier.vertex, later.vertex, belief)
        if match is None or not _same_tag(match.pose, earlier, later):
            return None
        return Loop(earlier.vertex, later.vertex, match.pose)

    def match(self, earlier: int, later: int, belief: GaussianPose) -> CloudMatch | None:
        """Match the surroundings of two vertices; None where the match is not to be trusted.

        ``belief``: pose of the later in the frame of the earlier. It says how far to search and what is too
        far off to be true.
        """
        match = match_clouds(
            self.surroundings(earlier), self.surroundings(later), belief.mean, self._window(belief)
        )
        if (
            match is None
            or match.overlap < self._config.min_overlap
            or match.margin < self._config.min_margin
        ):
            return None
        bent = GaussianPose(match.pose.mean, match.pose.covariance + _BENT)
        return replace(match, pose=bent) if _agrees(belief, bent) else None

    def _window(self, belief: GaussianPose) -> Window:
        """Return where to search: as far as the graph may be off, but near the tag."""
        sd_m = sqrt(max(belief.covariance[0, 0], belief.covariance[1, 1]))
        sd_rad = sqrt(belief.covariance[2, 2])
        reach_m = min(max(self._config.window_m, _SEARCH_SD * sd_m), _MOST_WINDOW_M)
        turn_rad = max(self._config.window_rad, _SEARCH_SD * sd_rad)
        return Window(reach_m, turn_rad if turn_rad < pi / 2.0 else pi)

    def apart(self, earlier: int, later: int) -> bool:
        """Say whether two vertices were passed at other times: their surroundings share no scan."""
        a, b = self._places.get(earlier), self._places.get(later)
        return a is not None and b is not None and b.driven_m - a.driven_m >= 2.0 * self._config.reach_m

    def surroundings(self, vertex: int) -> Cloud:
        """Return the surface points seen shortly before and after a vertex was made, in its frame."""
        place = self._places[vertex]
        low = np.searchsorted(self._driven, place.driven_m - self._config.reach_m)
        high = np.searchsorted(self._driven, place.driven_m + self._config.reach_m, side="right")
        points, normals = [np.zeros((0, 2))], [np.zeros((0, 2))]
        for scan in self._scans[low:high]:
            anchor_from_base = place.local_from_anchor.between(scan.local_from_base)
            points.append(anchor_from_base.transform(scan.points.astype(np.float64)))
            normals.append(Pose2(0.0, 0.0, anchor_from_base.theta).transform(scan.normals.astype(np.float64)))
        return Cloud(np.concatenate(points), np.concatenate(normals))

    def _chosen(self, later: Sighting, poses: Sequence[Pose2]) -> list[Sighting]:
        """Return the earlier sightings to match with: those facing the same way first, then the newest."""
        heading = poses[later.vertex].theta
        earlier = [s for s in self._sightings[later.tag] if s.vertex < later.vertex]
        earlier.sort(key=lambda s: (round(abs(wrap(poses[s.vertex].theta - heading)), 1), -s.vertex))
        return earlier[: self._config.earlier_sightings]


def _same_tag(earlier_from_later: GaussianPose, earlier: Sighting, later: Sighting) -> bool:
    """Say whether the match puts the tag where both sightings saw it."""
    pose = earlier_from_later.mean
    x, y = pose.transform_point(*later.place_m)
    gap = np.array([x - earlier.place_m[0], y - earlier.place_m[1]])
    turned = Pose2(0.0, 0.0, pose.theta).transform(np.eye(2)).T
    spread = earlier.covariance + turned @ later.covariance @ turned.T + earlier_from_later.covariance[:2, :2]
    return bool(gap @ np.linalg.solve(spread, gap) < _SAME_PLACE)


def _agrees(relative: GaussianPose, match: GaussianPose) -> bool:
    """Say whether a match may be, given the pose of one vertex in the frame of the other in the graph."""
    error = match.mean.as_array() - relative.mean.as_array()
    error[2] = wrap(error[2])
    spread = relative.covariance + match.covariance
    return bool(error @ np.linalg.solve(spread, error) < _LIKE_THE_GRAPH)
