"""From what a reader reports of a tag to a range and a bearing with their deviations."""

from __future__ import annotations

from math import cos, pi, radians, sin, sqrt

import numpy as np

from robots.config import AgentConfig
from robots.estimation.tag_filter import RangeSighting
from robots.se2 import Array, GaussianPose, Pose2
from robots.types import RobotSighting, TagSighting

_CONE_SD_RAD = radians(60.0) / sqrt(12.0)  # anywhere in the cone of a directional antenna (Ziparo 2007)


class Ranging:
    """Turns sightings into ranges; it remembers what it needs of earlier ones."""

    def __init__(self, config: AgentConfig) -> None:
        self._config = config

    def range(self, sighting: TagSighting, stamp_s: float) -> RangeSighting | None:
        """Return the range of a sighting from afar; None where it does not tell one yet."""
        ranging = self._config.ranging
        if sighting.range_m is None:
            return None
        deviation = ranging.range_sd_m + ranging.range_sd_per_m * sighting.range_m
        bearing, bearing_sd, antenna = sighting.bearing_rad, None, Pose2()
        if sighting.antenna is not None:
            antenna = self._antenna(sighting.antenna)
            bearing, bearing_sd = 0.0, _CONE_SD_RAD
        elif bearing is not None:
            bearing_sd = ranging.bearing_sd_rad
        return RangeSighting(
            sighting.tag_id, stamp_s, sighting.range_m, deviation, bearing, bearing_sd, antenna
        )

    def _antenna(self, which: str) -> Pose2:
        ahead = self._config.antenna.ahead_m
        return Pose2(ahead, 0.0, 0.0) if which == "front" else Pose2(-ahead, 0.0, pi)


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
