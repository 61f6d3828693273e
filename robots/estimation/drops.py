"""Tags that a robot dropped itself lie where it dropped them.

The robot is told no id: the magazine holds one tag less, and a tag never heard before answers from where the
robot was. Where one place and no other fits, it is that tag's.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2, hypot, log, sqrt

import numpy as np

from robots.config import AgentConfig
from robots.estimation.ekf.waiting import range_of
from robots.estimation.tag_filter import Dropped, RangeSighting
from robots.se2 import Pose2, wrap

_LANDS_SD_M = 0.15  # a tag that falls lies so far from under the antenna's middle
_MOST_M = 3.0  # driven since; then dead reckoning does not tell the place well enough
_GATE = 2.5  # deviations of the range


@dataclass(frozen=True, slots=True)
class _Drop:
    local_from_tag: Pose2
    driven_m: float


class Drops:
    """Places in the tracker's frame, which never jumps, that wait for the ids of the tags dropped there."""

    def __init__(self, config: AgentConfig) -> None:
        self._ahead_m = config.antenna.ahead_m
        self._walk = config.odometry.distance_sd_per_sqrt_m
        self._left: int | None = None
        self._drops: list[_Drop] = []
        self._known: dict[str, None] = {}

    def follow(self, tags_left: int | None, local_from_base: Pose2, driven_m: float) -> None:
        """Note a drop here where the magazine holds fewer tags than before."""
        before, self._left = self._left, tags_left
        self._drops = [each for each in self._drops if driven_m - each.driven_m < _MOST_M]
        if before is not None and tags_left is not None and tags_left < before:
            tag = local_from_base @ Pose2(self._ahead_m, 0.0, 0.0)
            self._drops.append(_Drop(tag, driven_m))

    def place(self, sighting: RangeSighting, local_from_base: Pose2, driven_m: float) -> Dropped | None:
        """Return where a tag heard for the first time was dropped, in the base frame; None where unknown."""
        if sighting.tag_id in self._known:
            return None
        self._known[sighting.tag_id] = None
        fits = [each for each in self._drops if _fits(sighting, local_from_base, each)]
        if len(fits) != 1:
            return None
        self._drops.remove(fits[0])
        off = local_from_base.between(fits[0].local_from_tag)
        variance = _LANDS_SD_M**2 + self._walk**2 * (driven_m - fits[0].driven_m)
        return Dropped((off.x, off.y), variance * np.eye(2))


def _fits(sighting: RangeSighting, local_from_base: Pose2, drop: _Drop) -> bool:
    seen = (local_from_base @ sighting.base_from_antenna).between(drop.local_from_tag)
    away_m = max(hypot(seen.x, seen.y), _LANDS_SD_M)
    range_m, log_sd = range_of(sighting)
    off = log(range_m / away_m) / log_sd if log_sd else (range_m - away_m) / sighting.range_sd_m
    if abs(off) > _GATE:
        return False
    bearing, sd = sighting.bearing_rad, sighting.bearing_sd_rad
    if bearing is None or sd is None:
        return True
    # a cone is a uniform distribution: no wider than sqrt(3) deviations
    return abs(wrap(atan2(seen.y, seen.x) - bearing)) < sqrt(3.0) * sd + _LANDS_SD_M / away_m
