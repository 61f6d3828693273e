"""SLAM over tags for one robot: Kleiner 2006 section IV.

The tracker's filter estimates the displacement since the last anchor; a tag read resets it and makes an
anchor; the displacements are the edges of the tag graph, which is solved when a known tag is seen again. The
laser closes the loop there precisely.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from robots.config import AgentConfig
from robots.estimation.passage import Passage
from robots.estimation.radio.ranging import Ranging, seen_from_anchor
from robots.estimation.scans.loop_closing import LoopCloser, Sighting
from robots.estimation.tag_graph.graph import TagGraph
from robots.estimation.tag_graph.smoothing import smooth
from robots.estimation.tracked import TrackedSlam
from robots.graph_report import GraphReport
from robots.se2 import Array, GaussianPose, Pose2
from robots.tags.map_memory import TagBelief
from robots.types import ImuReading, LaserScan, Observation


class TagSlam(TrackedSlam):
    """Pose and tag graph of one robot, in its map frame.

    The frame begins at the robot's start; with an inertial unit its x axis points north.
    """

    def __init__(self, config: AgentConfig, stamp_s: float, imu: ImuReading | None) -> None:
        super().__init__(config, imu)
        self._graph = TagGraph(config, self._start, stamp_s, None if imu is None else imu.yaw_rad)
        self._ranging = Ranging(config)
        self._loops = LoopCloser(config.loops)
        self._loops.anchored(0, self._start, 0.0)

    @property
    def anchor(self) -> int:
        """The newest pose vertex."""
        return self._graph.newest

    @property
    def pose(self) -> Pose2:
        """Pose in the map frame."""
        return self._graph.poses[-1] @ self._tracker.anchor_from_base.mean

    @property
    def belief(self) -> GaussianPose:
        """Pose in the map frame with its covariance."""
        return self._graph.last_belief @ self._tracker.anchor_from_base

    @property
    def anchors(self) -> list[Pose2]:
        """All pose vertices in the map frame."""
        return self._graph.poses

    def tag_place(self, tag_id: str) -> tuple[float, float]:
        """Return where a tag is in the map frame.

        Raises:
            KeyError: it was never seen.
        """
        return self._graph.tags[tag_id][1]

    def tag_places(self) -> list[tuple[float, float]]:
        """Return where all tags are in the map frame."""
        return [place for _, place in self._graph.tags.values()]

    def own_map(self) -> tuple[TagBelief, ...]:
        """Return nothing: a tag graph leaves no map in the tags."""
        return ()

    def take_doubts(self) -> tuple[str, ...]:
        """Return nothing: the team finds what is wrong with a tag."""
        return ()

    def report(self) -> GraphReport:
        """Return the graph as it leaves the process."""
        return self._graph.report()

    def smoothed(self) -> GraphReport:
        """Return the graph as a batch solve of all that was recorded has it; nothing changes here."""
        return smooth(self._graph.report(), self._loops, self._config)

    def match(self, scan: LaserScan) -> None:
        """Fuse the scan matcher's pose (eq. 3 and 4)."""
        super().match(scan)
        if self._closes_loops and self._tracker.points is not None:
            self._loops.keep(self.local_from_base, self.distance_m, self._tracker.points)

    def pass_tags(self, observation: Observation) -> Passage:
        """Restart the filter at tags, keep the displacement as an edge, close loops, solve (eq. 5)."""
        read = tuple(s for s in observation.tag_sightings if s.under_antenna and self._is_new_pass(s.tag_id))
        # a range without a bearing says too little for a graph of places: those are for the filters
        seen = tuple(s for s in observation.tag_sightings if s.bearing_rad is not None)
        met = observation.robot_sightings
        self._sees_afar |= bool(seen or met)
        anchored = bool(read) or self._anchor_is_overdue or (bool(seen or met) and self._has_moved())
        if anchored:
            self._add_anchor(observation)
        known = False
        for sighting in read:
            known |= self._see(sighting.tag_id, (self._config.antenna.ahead_m, 0.0), self._antenna_spread)
            self._last_passed = (sighting.tag_id, self.distance_m)
        here = self.anchor_from_base
        for sighting in seen:
            ranged = self._ranging.range(sighting, observation.stamp_s, self.distance_m, self.local_from_base)
            if ranged is not None:
                known |= self._graph.add_range(ranged, here)
                placed = seen_from_anchor(replace(sighting, range_m=ranged.range_m), here, self._config)
                self._may_close_loop(sighting.tag_id, *placed)
        for robot in met:
            place = seen_from_anchor(robot, here, self._config)
            self._graph.add_meeting(robot.robot_id, observation.stamp_s, *place, here.mean)
        closed = self._close_loop()
        solving = (known or closed) and self._config.poses == "slam" and self._config.slam == "tag-graph"
        if solving:
            self._graph.solve()
        return Passage(read, anchored, solving, bool(read or seen or met) or anchored or closed)

    @property
    def _closes_loops(self) -> bool:
        config = self._config
        return config.loops.laser and config.poses == "slam" and config.slam == "tag-graph"

    @property
    def _antenna_spread(self) -> Array:
        return np.diag(self._config.antenna.variances)

    def _add_anchor(self, observation: Observation) -> None:
        yaw = None if observation.imu is None else observation.imu.yaw_rad
        vertex = self._graph.add_pose(self._tracker.restart(), observation.stamp_s, yaw)
        self._anchor_driven_m = self.distance_m
        if self._closes_loops:
            self._loops.anchored(vertex, self.local_from_base, self.distance_m)

    def _see(self, tag_id: str, place_m: tuple[float, float], covariance: Array) -> bool:
        """Note a sighting, given in the newest anchor's frame; say whether it is news of a known tag."""
        news = self._graph.add_sighting(tag_id, place_m, covariance)
        self._may_close_loop(tag_id, place_m, covariance)
        return news

    def _may_close_loop(self, tag_id: str, place_m: tuple[float, float], covariance: Array) -> None:
        if self._closes_loops:
            tag = self._graph.tags[tag_id][0]
            self._loops.sighted(Sighting(self.anchor, tag, place_m, covariance, self.distance_m))

    def _close_loop(self) -> bool:
        if not self._closes_loops:
            return False
        loop = self._loops.close(self.distance_m, self._graph.poses, self._graph.relative)
        if loop is None:
            return False
        self._graph.add_loop(loop.earlier, loop.later, loop.earlier_from_later)
        return True
