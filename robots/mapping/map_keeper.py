"""A robot's submaps, which one is being written, and the map they make together."""

from __future__ import annotations

from math import hypot

from robots.config import MappingConfig
from robots.mapping.fused import FusedGrid
from robots.mapping.submap import Submap
from robots.planning.following import free_ahead
from robots.se2 import Pose2
from robots.types import LaserScan, SubmapReport

_NEW_SUBMAP_M = 2.5  # anchors nearer than so much driving share a submap
FELT_RADIUS_M = 0.08
SEEN_AHEAD_M = 0.25  # what the laser sees so near need not be felt


class MapKeeper:
    """Writes scans into the newest submap and draws all of them into ``fused`` in the map frame."""

    def __init__(self, config: MappingConfig) -> None:
        self.fused = FusedGrid(config.resolution_m)
        self._config = config
        self._submaps: list[Submap] = []
        self._reported: dict[int, int] = {}  # anchor -> version
        self._local_from_anchor = Pose2()  # of the submap being written
        self._begun_m = 0.0
        self._drawn: dict[int, tuple[int, Pose2]] = {}  # anchor -> version, and where its anchor was
        self._report_due_s = 0.0
        self._closed: list[Submap] = []  # finished since the last report

    def begin(self, anchor: int, map_from_anchor: Pose2, local_from_base: Pose2, driven_m: float) -> None:
        """Start a submap at an anchor, where the robot stands now."""
        if self._submaps:
            self._closed.append(self._submaps[-1])
        self._submaps.append(Submap(anchor, map_from_anchor, self._config))
        self._local_from_anchor = local_from_base
        self._begun_m = driven_m

    def anchored(self, anchor: int, map_from_anchor: Pose2, local_from_base: Pose2, driven_m: float) -> None:
        """Note a new anchor here: a new submap begins unless the last one has only just begun."""
        if driven_m - self._begun_m >= _NEW_SUBMAP_M:
            self.begin(anchor, map_from_anchor, local_from_base, driven_m)

    def add_scan(self, local_from_base: Pose2, scan: LaserScan) -> None:
        """Write a scan taken at a pose in the tracker's local frame."""
        self._submaps[-1].add_scan(self._local_from_anchor.between(local_from_base), scan)

    def add_free(self, local_from_base: Pose2, radius_m: float) -> None:
        """Write that the robot's own place is free."""
        self._submaps[-1].add_free(self._local_from_anchor.between(local_from_base), radius_m)

    def add_obstacle(self, local_from_base: Pose2, radius_m: float, scan: LaserScan | None) -> None:
        """Write an obstacle that was felt right ahead, where the laser sees none.

        Glass, or bricks below its plane.
        """
        if scan is not None and free_ahead(scan, radius_m) < SEEN_AHEAD_M:
            return
        point = local_from_base @ Pose2(radius_m + FELT_RADIUS_M, 0.0, 0.0)
        self._submaps[-1].add_obstacle(self._local_from_anchor.between(point), FELT_RADIUS_M)

    def draw(self, poses: list[Pose2]) -> None:
        """Draw the submaps that moved or were written where the graph now has their anchors."""
        for submap in self._submaps:
            pose = poses[submap.anchor]
            version, place = self._drawn.get(submap.anchor, (-1, pose))
            if version != submap.version or _differs(place, pose):
                self._put(submap, pose)
                self._drawn[submap.anchor] = submap.version, pose

    def take_reports(self, stamp_s: float) -> tuple[SubmapReport, ...]:
        """Return the submaps to report now: finished ones at once, the one being written every so often."""
        due, self._closed = self._closed, []
        if stamp_s >= self._report_due_s:
            self._report_due_s = stamp_s + self._config.report_every_s
            due = [*due, self._submaps[-1]]
        return tuple(self._report(s) for s in due if self._reported.get(s.anchor) != s.version)

    def all_reports(self) -> tuple[SubmapReport, ...]:
        """Return every submap as it is now."""
        return tuple(submap.report() for submap in self._submaps)

    def _report(self, submap: Submap) -> SubmapReport:
        self._reported[submap.anchor] = submap.version
        return submap.report()

    def _put(self, submap: Submap, map_from_anchor: Pose2) -> None:
        grid_from_cells = Pose2(submap.origin_x, submap.origin_y)
        place = map_from_anchor @ submap.anchor_from_grid @ grid_from_cells
        self.fused.put(submap.anchor, submap.version, place, submap.cells, touched=submap.touched)


def _differs(a: Pose2, b: Pose2) -> bool:
    return hypot(a.x - b.x, a.y - b.y) > 0.01 or abs(a.theta - b.theta) > 0.002
