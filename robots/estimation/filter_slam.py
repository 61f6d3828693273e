"""SLAM over radio tags for one robot: a filter over pose and tags, fed by the tracker.

Wheels, inertial unit and scan matching give displacements; the filter moves by them and corrects itself at
each tag heard. Where it was is kept as anchors with the measured displacements between them: the map hangs on
them, and a batch solve begins from them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import hypot, sqrt

import numpy as np

from robots.config import AgentConfig
from robots.estimation.anchor_log import AnchorLog
from robots.estimation.drops import Drops
from robots.estimation.odometry import motion_mean
from robots.estimation.passage import Passage
from robots.estimation.radio.cones import ConeWatch, Crossing, HearsCones
from robots.estimation.radio.model import RadioModel
from robots.estimation.radio.ranging import Ranging, seen_from_anchor
from robots.estimation.slip.patches import UNKNOWN, Grip, Slippage
from robots.estimation.tag_filter import RangeSighting, TagFilter
from robots.estimation.tag_graph.smoothing import smooth_radio
from robots.estimation.tracked import TrackedSlam
from robots.graph_report import GraphReport
from robots.se2 import GaussianPose, Pose2, compose_jacobians
from robots.tags.map_memory import TagBelief
from robots.tags.memory import TagMemoryError
from robots.tags.sealed import open_memory
from robots.types import ImuReading, Observation, TagSighting

_WRITE_EVERY_S = 5.0  # a tag within reach is written so often
_JUMPED_M = 0.25  # what was planned before such a correction is planned anew
_LEAST = 1e-10  # variance of a step in any direction


class FilterSlam(TrackedSlam):
    """Pose, anchors and tags of one robot, in its map frame, estimated by a filter."""

    def __init__(
        self,
        robot_id: str,
        config: AgentConfig,
        stamp_s: float,
        imu: ImuReading | None,
        make_filter: Callable[[str, AgentConfig, Pose2], TagFilter],
    ) -> None:
        super().__init__(config, imu)
        self._robot_id = robot_id
        self._filter = make_filter(robot_id, config, self._start)
        if imu is not None:  # the map begins at the heading that it tells
            self._filter.predict(GaussianPose(Pose2(), np.diag([0.0, 0.0, config.imu.yaw_sd_rad**2])))
        self._log = AnchorLog(stamp_s, None if imu is None else imu.yaw_rad)
        self._ranging = Ranging(config)
        self._drops, self._slippage = Drops(config), Slippage()
        self._cone_filter = self._filter if isinstance(self._filter, HearsCones) else None
        self._cones = ConeWatch(RadioModel(config.radio))
        self._taken = GaussianPose.exact()  # the tracker's pose since the anchor that the filter has
        self._anchors: list[Pose2] = [self._start]
        self._unsure_m = 0.0  # of the way driven, made while the wheels slipped
        self._moved_m = 0.0  # by which corrections moved the robot since its plans were made
        self._memories: dict[str, bytes] = {}  # last read, by tag
        self._revisions: dict[str, int] = {}  # of other robots' maps, as far as they were taken in
        self._written_s: dict[str, float] = {}

    @property
    def anchor(self) -> int:
        """The newest anchor."""
        return self._log.newest

    @property
    def anchors(self) -> list[Pose2]:
        """All anchors in the map frame."""
        return self._anchors

    @property
    def pose(self) -> Pose2:
        """Pose in the map frame."""
        return self._anchors[-1] @ self._tracker.anchor_from_base.mean

    @property
    def belief(self) -> GaussianPose:
        """Pose in the map frame with its covariance."""
        return GaussianPose(self.pose, (self._filter.belief @ self._step()).covariance)

    def tag_place(self, tag_id: str) -> tuple[float, float]:
        """Return where a tag is in the map frame.

        Raises:
            KeyError: it is not known where.
        """
        return self._places()[tag_id]

    def tag_places(self) -> list[tuple[float, float]]:
        """Return where the tags are whose place is known, in the map frame."""
        return list(self._places().values())

    def own_map(self) -> tuple[TagBelief, ...]:
        """Return the tags as this robot alone has them."""
        return self._filter.own_map()

    def take_doubts(self) -> tuple[str, ...]:
        """Return, once, what is wrong with tags, ranges and maps."""
        return self._filter.take_doubts()

    def predict(
        self, observation: Observation, moved: bool, slipping: bool, slip_share: float = UNKNOWN
    ) -> None:
        """Move by wheels and inertial unit; slipping wheels count by a third, in doubt (``slip/patches.py``).

        Without ``moved`` the wheels do not count. Where the bumper is pressed they tell nothing.
        """
        odometry = observation.odometry if moved else None
        grip: Grip | None = None
        if not observation.bumper:
            way = motion_mean(odometry, None, self._config.body)
            rolled_m = hypot(way.x, way.y)
            grip = self._slippage.observe(observation.stamp_s, rolled_m, slip_share)
            if self._slippage.on_patch:
                self._unsure_m += abs(grip.share) * rolled_m
        self._drops.follow(observation.tags_left, self.local_from_base, self.distance_m)
        self._tracker.predict(observation.stamp_s, odometry, observation.imu, slipping, grip)

    def pass_tags(self, observation: Observation) -> Passage:
        """Let the filter follow and take in what was heard; keep an anchor here where one is due."""
        afar = [s for s in observation.tag_sightings if not s.under_antenna]
        under = [s for s in observation.tag_sightings if s.under_antenna]
        passed = [s for s in under if self._is_new_pass(s.tag_id)]
        met = observation.robot_sightings
        self._sees_afar |= bool(afar or met)
        overdue = self._anchor_is_overdue
        crossings = self._crossings(observation.stamp_s, afar)
        if not (afar or under or met or overdue or crossings):
            return Passage()
        self._follow(observation.imu)
        before = self.pose
        if self._cone_filter is not None:
            for crossing in crossings:
                self._cone_filter.see_crossing(crossing)
        heard = self._hear(afar, observation.stamp_s)
        for sighting in (*afar, *under):
            self._read_memory(sighting)
        anchored = overdue or bool(passed) or (bool(heard or met) and self._has_moved())
        if anchored:
            self._add_anchor(observation)
        self._hang()
        self._note(observation, heard, passed)
        self._moved_m += before.distance(self.pose)
        moved = self._moved_m > _JUMPED_M
        if moved:
            self._moved_m = 0.0
        due = tuple(
            replace(s, memory=self._memories.get(s.tag_id, s.memory))
            for s in (*passed, *afar)
            if self._may_write(s, observation.stamp_s)
        )
        return Passage(due, anchored, moved, anchored)

    def report(self) -> GraphReport:
        """Return the graph as it leaves the process."""
        places = self._places()
        offsets = {tag_id: self._filter.range_offset(tag_id) for tag_id in places}
        report = self._log.report(self._anchors, places, self._filter.range_scale, offsets)
        radio = self._config.rslam
        return replace(report, range_scale_sd=radio.scale_sd, range_offset_sd_m=radio.offset_sd_m)

    def smoothed(self) -> GraphReport:
        """Return the graph as a batch solve of all that was recorded has it; nothing changes here."""
        return smooth_radio(self.report(), self._config)

    def _step(self) -> GaussianPose:
        """Return the displacement since the filter followed last.

        The tracker tells the pose since the anchor; the covariance of the last step is what that one's grew
        by. Where a scan match made it smaller instead, the step counts as exact.
        """
        here = self._tracker.anchor_from_base
        mean = self._taken.mean.between(here.mean)
        by_pose, by_motion = compose_jacobians(self._taken.mean, mean)
        grown = here.covariance - by_pose @ self._taken.covariance @ by_pose.T
        back = np.linalg.inv(by_motion)
        values, vectors = np.linalg.eigh(back @ grown @ back.T)
        return GaussianPose(mean, (vectors * np.maximum(values, _LEAST)) @ vectors.T)

    def _follow(self, imu: ImuReading | None) -> None:
        if self._tracker.anchor_from_base is self._taken:
            return
        self._filter.predict(self._step())
        self._taken = self._tracker.anchor_from_base
        if imu is None:
            return
        # its error stays for minutes: it tells the heading as well as itself, however often, and no better
        known, compass = self._filter.belief.covariance[2, 2], self._config.imu.yaw_sd_rad**2
        if known > compass:
            self._filter.see_heading(imu.yaw_rad, sqrt(known * compass / (known - compass)))

    def _crossings(self, stamp_s: float, afar: list[TagSighting]) -> list[Crossing]:
        if self._cone_filter is None or self._config.poses != "slam":
            return []
        return self._cones.watch(stamp_s, self.local_from_base, afar)

    def _hear(self, afar: list[TagSighting], stamp_s: float) -> list[RangeSighting]:
        if self._config.poses != "slam":
            return []
        # a robot that slips may stand still, where the signals' errors stay the same
        driven_m, here = self.distance_m - self._unsure_m, self.local_from_base
        ranged = [self._ranging.range(sighting, stamp_s, driven_m, here) for sighting in afar]
        heard = [self._with_drop(sighting) for sighting in ranged if sighting is not None]
        return [sighting for sighting in heard if self._filter.see(sighting)]

    def _with_drop(self, sighting: RangeSighting) -> RangeSighting:
        return replace(sighting, dropped=self._drops.place(sighting, self.local_from_base, self.distance_m))

    def _read_memory(self, sighting: TagSighting) -> None:
        if not sighting.memory or sighting.memory == self._memories.get(sighting.tag_id):
            return  # only the id was read, or nothing new
        self._memories[sighting.tag_id] = sighting.memory
        if not self._config.map_memory:
            return
        try:
            says = open_memory(sighting.memory, sighting.tag_id, self._config.tag_memory.key_bytes)
        except TagMemoryError:
            return  # the server tells of it; the tag is left as it is
        for each in says.memory.maps if says.trusted else ():
            if each.writer != self._robot_id and each.revision > self._revisions.get(each.writer, -1):
                self._revisions[each.writer] = each.revision
                self._filter.read_map(each)

    def _add_anchor(self, observation: Observation) -> None:
        yaw = None if observation.imu is None else observation.imu.yaw_rad
        self._log.add_anchor(self._tracker.restart(), observation.stamp_s, yaw)
        self._filter.anchor()
        self._taken = self._tracker.anchor_from_base
        self._anchor_driven_m = self.distance_m

    def _hang(self) -> None:
        """Place the anchors; what was learnt of the pose here moves the newest one."""
        if self._log.newest >= len(self._anchors):
            self._anchors = self._filter.anchors()
        self._anchors[-1] = self._filter.belief.mean @ self._taken.mean.inverse()

    def _note(self, observation: Observation, heard: list[RangeSighting], passed: list[TagSighting]) -> None:
        here = self._taken
        for ranged in heard:
            self._log.add_range(ranged, here)
        antenna = self._config.antenna
        for sighting in passed:
            self._log.add_passed(sighting.tag_id, (antenna.ahead_m, 0.0), np.diag(antenna.variances))
            self._last_passed = (sighting.tag_id, self.distance_m)
        for robot in observation.robot_sightings:
            place = seen_from_anchor(robot, here, self._config)
            self._log.add_meeting(robot.robot_id, observation.stamp_s, *place, here.mean)

    def _may_write(self, sighting: TagSighting, stamp_s: float) -> bool:
        if stamp_s < self._written_s.get(sighting.tag_id, -np.inf) + _WRITE_EVERY_S:
            return False
        self._written_s[sighting.tag_id] = stamp_s
        return True

    def _places(self) -> dict[str, tuple[float, float]]:
        heard = {tag_id: (belief.x_m, belief.y_m) for tag_id, belief in self._filter.tags().items()}
        return self._log.passed_places(self._anchors) | heard
