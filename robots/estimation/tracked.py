"""What both kinds of SLAM share: the tracker between anchors, and when a tag or an anchor is new."""

from __future__ import annotations

from math import hypot

from robots.config import AgentConfig
from robots.estimation.slip.patches import UNKNOWN
from robots.estimation.tracking import PoseTracker
from robots.se2 import GaussianPose, Pose2
from robots.types import ImuReading, LaserScan, Observation

_DENSE = 2.0  # anchors of a robot that sees from afar lie at most so many times apart
_SAME_PASS_M = 0.4  # a tag under the antenna again within so much driving is the same pass


class TrackedSlam:
    """Wheels, inertial unit and laser since the newest anchor."""

    def __init__(self, config: AgentConfig, imu: ImuReading | None) -> None:
        self._config = config
        self._start = Pose2(0.0, 0.0, 0.0 if imu is None else imu.yaw_rad)
        self._tracker = PoseTracker(config, self._start.theta)
        self._last_passed: tuple[str, float] | None = None  # id, way driven when it was under the antenna
        self._anchor_driven_m = 0.0
        self._sees_afar = False  # tags or robots, so far

    @property
    def distance_m(self) -> float:
        """Way driven so far."""
        return self._tracker.distance_m

    @property
    def local_from_base(self) -> Pose2:
        """Pose in the tracker's frame, which never jumps."""
        return self._tracker.local_from_base

    @property
    def anchor_from_base(self) -> GaussianPose:
        """Pose since the newest anchor."""
        return self._tracker.anchor_from_base

    def predict(
        self, observation: Observation, moved: bool, slipping: bool, slip_share: float = UNKNOWN
    ) -> None:
        """Move by wheels and inertial unit (Kleiner 2006 eq. 1 and 2).

        Without ``moved`` the wheels do not count: what was driven before the first observation is not part of
        the map.
        """
        odometry = observation.odometry if moved else None
        self._tracker.predict(observation.stamp_s, odometry, observation.imu, slipping)

    def match(self, scan: LaserScan) -> None:
        """Fuse the scan matcher's pose (Kleiner 2006 eq. 3 and 4)."""
        self._tracker.match(scan)

    def _is_new_pass(self, tag_id: str) -> bool:
        last = self._last_passed
        return last is None or last[0] != tag_id or self.distance_m - last[1] > _SAME_PASS_M

    def _has_moved(self, times: float = 1.0) -> bool:
        """Say whether the robot is farther from its anchor than so many times what a sighting asks for."""
        here, ranging = self.anchor_from_base.mean, self._config.ranging
        if abs(here.theta) > times * ranging.anchor_turn_rad:
            return True
        return hypot(here.x, here.y) > times * ranging.anchor_travel_m

    @property
    def _anchor_is_overdue(self) -> bool:
        driven_m = self.distance_m - self._anchor_driven_m
        if driven_m > self._config.mapping.submap_travel_m or self._tracker.lost:
            return True
        # a way that no scan holds straight bends where it is weakest: a batch solve has to be told where
        return self._sees_afar and self._tracker.points is None and self._has_moved(_DENSE)
