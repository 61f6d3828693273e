"""The pose since the last anchor: dead reckoning and scan matching fused.

Poses live in a *local frame* that never jumps. The scan matcher measures the pose relative to recent scans,
which carry the pose errors of their own time: taken as an absolute measurement, eq. (3) and (4) would shrink
the covariance for ever. To keep it honest the filter runs relative to a *reference* pose; when the robot has
left it behind, the reference moves on and its uncertainty is composed into the displacement.
"""

from __future__ import annotations

from math import cos, sin, sqrt

import numpy as np

from robots.config import AgentConfig
from robots.estimation.contradiction import share_seen_through
from robots.estimation.kalman import at_least, fuse
from robots.estimation.odometry import motion_covariance, motion_mean, predict
from robots.estimation.scans.local_map import LocalMap
from robots.estimation.scans.matching import match
from robots.estimation.scans.points import ScanPoints, scan_points
from robots.estimation.slip.patches import Grip
from robots.se2 import Array, GaussianPose, Pose2, wrap
from robots.types import ImuReading, LaserScan, Odometry

_REFERENCE_M = 1.0  # the reference moves on after so much: about the stretch whose scans overlap fully
_CONTRADICTION = 16.0  # squared Mahalanobis distance, 3 degrees of freedom: one honest match in a thousand
_PATIENCE = 5  # scans, a second
_DISAGREEMENT = 16.0  # of all matches since the reference together, 2 degrees of freedom: one in 3,000
_SEEN_THROUGH, _LOST_SCANS, _KNOWN_SCANS = 0.5, 3, 5  # so many scans in a row, in a map of so many scans
_LOST_SD_M, _LOST_SD_RAD = 10.0, 1.8  # anywhere near, facing anywhere
_BLIND_REFERENCE_M = 3.0  # and after so much where no scan can be matched


class PoseTracker:
    """Kalman filter of Kleiner 2006 section IV; ``restart`` is its reset at a tag."""

    def __init__(self, config: AgentConfig, heading_rad: float) -> None:
        self._config = config
        self.local_from_base = Pose2(0.0, 0.0, heading_rad)
        self.distance_m = 0.0
        self.matched = False
        self.points: ScanPoints | None = None  # of the latest scan
        self.lost = False  # the latest scan showed that the robot is not where it thought
        self._local_from_reference = self.local_from_base
        self._anchor_from_reference = GaussianPose.exact()
        self._reference_from_base = GaussianPose.exact()
        self._matched_here = False  # a scan was matched since the reference was set
        # What matching does not take back: the covariance since the reference with which scans went into the
        # map, and a disagreement of matches and wheels that goes on, whichever of them is wrong.
        self._lasting: Array = np.zeros((3, 3))
        self._disagreement, self._expected = np.zeros(2), np.zeros((2, 2))
        # the last anchor_from_base and what it was made of: it is asked for several times a step
        self._joined: tuple[tuple[GaussianPose, GaussianPose, Array, bool], GaussianPose] | None = None
        self._contradictions = 0  # matches in a row that were put aside
        self._foreign = 0  # scans in a row that look through the map's surfaces
        self._yaw_rad: float | None = None
        self._stamp_s: float | None = None
        self._map: LocalMap | None = None
        self._last_insert: Pose2 | None = None

    @property
    def anchor_from_base(self) -> GaussianPose:
        """Pose since the last restart, with covariance."""
        made_of = (
            self._anchor_from_reference,
            self._reference_from_base,
            self._lasting,
            self._matched_here,
        )
        if self._joined is None or any(a is not b for a, b in zip(self._joined[0], made_of, strict=True)):
            joined = self._anchor_from_reference @ self._with_map_error(self._reference_from_base)
            self._joined = made_of, joined
        return self._joined[1]

    def predict(
        self,
        stamp_s: float,
        odometry: Odometry | None,
        imu: ImuReading | None,
        slipping: bool,
        grip: Grip | None = None,
    ) -> None:
        """Move by the wheels, turn by the inertial unit where there is one (eq. 1 and 2).

        ``slipping``: the wheels say nothing about the distance; with ``grip``, how much they do.
        """
        config = self._config
        since_s = 0.0 if self._stamp_s is None else max(stamp_s - self._stamp_s, 0.0)
        turn, turn_sd = None, None
        if imu is not None:
            if self._yaw_rad is not None:
                turn = wrap(imu.yaw_rad - self._yaw_rad)
                turn_sd = config.imu.yaw_drift_sd_rad * sqrt(max(since_s, 1e-6))
            self._yaw_rad = imu.yaw_rad
        self._stamp_s = stamp_s
        mean = motion_mean(odometry, turn, config.body)
        if grip is not None:
            mean = Pose2(grip.share * mean.x, grip.share * mean.y, mean.theta)
        elif slipping:
            mean = Pose2(0.0, 0.0, mean.theta)
        if config.poses == "truth":
            covariance = np.zeros((3, 3))
        else:
            arm_m = config.body.track_width_m / 2.0
            slipping_s = since_s if slipping and grip is None else 0.0
            covariance = motion_covariance(mean, config.odometry, arm_m, turn_sd, slipping_s)
            if grip is not None:
                covariance[0, 0] += grip.variance_m2
        self.distance_m += sqrt(mean.x**2 + mean.y**2)
        self._reference_from_base = predict(self._reference_from_base, GaussianPose(mean, covariance))
        self._settle(_BLIND_REFERENCE_M)  # never right before a match: a fresh reference counts as exact

    def match(self, scan: LaserScan) -> bool:
        """Match a scan against the local map and fuse (eq. 3 and 4); say whether it could be used.

        Scans that see through the map's surfaces mean that the robot was carried off: then it is ``lost``,
        which the displacement's covariance says, and a new local map begins.
        """
        config = self._config.scan_match
        self.lost = False
        if self._config.poses == "truth":
            return False
        points = self.points = scan_points(scan, config.max_range_m)
        if self._map is None:
            reach = min(config.max_range_m, scan.range_max_m)
            self._map = LocalMap(config.local_scans, reach + config.local_scans * config.insert_after_m / 2.0)
        result = match(self._map, points, self.local_from_base, config)
        self.matched = result is not None and self._fuse(result.pose)
        if result is None and self._is_foreign(scan):
            self._lose()
        usable = points.far_fraction <= config.max_far_fraction and len(points.points) >= config.min_points
        if usable and not self._foreign and self._moved_since_insert():
            self._map.insert(self.local_from_base, points.points, points.normals)
            self._lasting = at_least(self._reference_from_base.covariance, self._lasting)
            self._last_insert = self.local_from_base
        return self.matched

    def _is_foreign(self, scan: LaserScan) -> bool:
        if self._map is None or len(self._map) < _KNOWN_SCANS:
            return False
        through = share_seen_through(scan, self.local_from_base, self._map.points)
        self._foreign = self._foreign + 1 if through > _SEEN_THROUGH else 0
        return self._foreign >= _LOST_SCANS

    def _lose(self) -> None:
        self._foreign = 0
        self.lost = True
        if self._map is not None:
            self._map.clear()
        self._last_insert = None
        heading = _LOST_SD_RAD if self._yaw_rad is None else 0.0  # a compass goes on knowing it
        anywhere = np.diag([_LOST_SD_M**2, _LOST_SD_M**2, heading**2])
        belief = self._reference_from_base
        self._reference_from_base = GaussianPose(belief.mean, belief.covariance + anywhere)

    def _fuse(self, matched: GaussianPose) -> bool:
        """Fuse the scan matcher's pose; say whether it was believed.

        One that contradicts odometry is put aside: an alignment to the wrong wall, or to robots that move. If
        the contradiction lasts, it is the odometry that is wrong (the wheels slip, or somebody carried the
        robot).
        """
        seen = self._in_reference(matched)
        predicted = self._reference_from_base
        loosened = GaussianPose(predicted.mean, predicted.covariance + np.eye(3) * 1e-9)
        innovation = seen.mean.as_array() - predicted.mean.as_array()
        innovation[2] = wrap(innovation[2])
        distance = float(innovation @ np.linalg.solve(loosened.covariance + seen.covariance, innovation))
        if distance > _CONTRADICTION and self._contradictions < _PATIENCE:
            self._contradictions += 1
            return False
        if self._contradictions >= _PATIENCE:
            loosened = GaussianPose(loosened.mean, loosened.covariance + np.diag([0.04, 0.04, 0.01]))
        self._contradictions = self._foreign = 0
        self._note_disagreement(innovation[:2], (loosened.covariance + seen.covariance)[:2, :2])
        self._reference_from_base = fuse(loosened, seen)  # (3), (4)
        self._matched_here = True
        self._settle(_REFERENCE_M)
        return True

    def _note_disagreement(self, innovation: Array, covariance: Array) -> None:
        """Add up innovations, which are independent where both are honest.

        In a corridor a scan may stick to what it saw last, or to a robot that drives ahead: each match is
        within the wheels' error, and all of them together are not.
        """
        self._disagreement = self._disagreement + innovation
        self._expected = self._expected + covariance
        total = self._disagreement
        if float(total @ np.linalg.solve(self._expected, total)) > _DISAGREEMENT:
            spread = np.zeros((3, 3))
            spread[:2, :2] = np.outer(total, total)
            self._lasting = at_least(self._lasting, spread)

    def restart(self) -> GaussianPose:
        """Return the displacement since the last restart and begin anew here: the filter's reset at a tag."""
        displacement = self.anchor_from_base
        self._anchor_from_reference = GaussianPose.exact()
        self._set_reference()
        return displacement

    def _settle(self, reach_m: float) -> None:
        self.local_from_base = self._local_from_reference @ self._reference_from_base.mean
        if np.hypot(self._reference_from_base.mean.x, self._reference_from_base.mean.y) > reach_m:
            self._anchor_from_reference = self.anchor_from_base
            self._set_reference()

    def _set_reference(self) -> None:
        self._local_from_reference = self.local_from_base
        self._reference_from_base = GaussianPose.exact()
        self._matched_here = False
        self._lasting = np.zeros((3, 3))
        self._disagreement, self._expected = np.zeros(2), np.zeros((2, 2))

    def _with_map_error(self, pose: GaussianPose) -> GaussianPose:
        """Add what repeated matching against the local map cannot average away."""
        if not self._matched_here:
            return pose
        config = self._config.scan_match
        error = np.diag([config.map_sd_m**2, config.map_sd_m**2, config.map_sd_rad**2])
        return GaussianPose(pose.mean, at_least(pose.covariance, self._lasting) + error)

    def _in_reference(self, pose: GaussianPose) -> GaussianPose:
        c, s = cos(self._local_from_reference.theta), sin(self._local_from_reference.theta)
        rotation: Array = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
        return GaussianPose(
            self._local_from_reference.between(pose.mean), rotation @ pose.covariance @ rotation.T
        )

    def _moved_since_insert(self) -> bool:
        last, config = self._last_insert, self._config.scan_match
        if last is None:
            return True
        moved = last.between(self.local_from_base)
        return (
            np.hypot(moved.x, moved.y) > config.insert_after_m or abs(moved.theta) > config.insert_after_rad
        )
