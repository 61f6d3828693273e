"""From what a reader reports of a tag to a range and a bearing with their deviations."""

from __future__ import annotations

from math import cos, sin

import numpy as np

from robots.config import AgentConfig
from robots.estimation.radio.model import RadioModel
from robots.estimation.radio.signal_mean import SignalAverager
from robots.estimation.tag_filter import RangeSighting
from robots.se2 import Array, GaussianPose, Pose2
from robots.types import RobotSighting, TagSighting


class Ranging:
    """Turns sightings into ranges: measured ones as they are, signals by the mean of those of one place."""

    def __init__(self, config: AgentConfig) -> None:
        self._ranging = config.ranging
        self._model = RadioModel(config.radio)
        self._signals = SignalAverager(config.radio)

    def range(
        self, sighting: TagSighting, stamp_s: float, driven_m: float, local_from_base: Pose2 | None = None
    ) -> RangeSighting | None:
        """Return the range of a sighting from afar, made after ``driven_m`` of way; None while it tells none.

        A mean of signals belongs to the middle of the places where they were read, which lies behind: told
        as now, it would drag the robot back at every tag. ``local_from_base`` is the pose in a frame that
        never jumps.

        Raises:
            ValueError: the signal is not finite.
        """
        median_m = log_sd = None
        direction = self._model.direction(sighting.antenna)
        bearing, bearing_sd = direction.bearing_rad, direction.bearing_sd_rad
        base_from_antenna, here = direction.base_from_antenna, local_from_base or Pose2()
        if sighting.range_m is not None:
            range_m = sighting.range_m
            deviation = self._ranging.range_sd_m + self._ranging.range_sd_per_m * range_m
            if sighting.bearing_rad is not None:
                bearing, bearing_sd = sighting.bearing_rad, self._ranging.bearing_sd_rad
        elif sighting.rssi_dbm is not None:
            mean = self._signals.add(sighting.tag_id, sighting.antenna, sighting.rssi_dbm, driven_m, here)
            if mean is None:
                return None
            base_from_antenna = here.between(mean.local_from_base) @ base_from_antenna
            told = self._model.range_of(mean.rssi_dbm, mean.readings)
            range_m, deviation = told.range_m, told.sd_m
            median_m, log_sd = told.median_m, told.log_sd
        else:
            return None
        return RangeSighting(
            sighting.tag_id,
            stamp_s,
            range_m,
            deviation,
            bearing,
            bearing_sd,
            base_from_antenna,
            median_m,
            log_sd,
            independent=sighting.range_m is None,  # the mean of a place of its own
            in_cone=sighting.antenna is not None and median_m is not None,
        )


def seen_from_anchor(
    seen: TagSighting | RobotSighting, here: GaussianPose, config: AgentConfig
) -> tuple[tuple[float, float], Array]:
    """Return what was seen by range and bearing as a place in the anchor's frame, covariance (2, 2).

    ``here`` is the pose of the base since the anchor.
    """
    range_m, bearing = seen.range_m or 0.0, seen.bearing_rad or 0.0
    x, y = range_m * cos(bearing), range_m * sin(bearing)
    c, s = cos(here.mean.theta), sin(here.mean.theta)
    turned = np.array([[c, -s], [s, c]])
    by_pose = np.array([[1.0, 0.0, -s * x - c * y], [0.0, 1.0, c * x - s * y]])
    spread = turned @ np.array(config.ranging.covariance(range_m, bearing)) @ turned.T
    spread += by_pose @ here.covariance @ by_pose.T
    return here.mean.transform_point(x, y), (spread + spread.T) / 2.0
