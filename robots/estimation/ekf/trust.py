"""Which sightings and places an EKF may believe at all, and when a tag is no longer where it was."""

from __future__ import annotations

from math import isfinite

from robots.estimation.tag_filter import RangeSighting
from robots.tags.map_memory import TagBelief

_FAR_OFF = 25.0  # squared deviations
_TIMES, _FOR_S = 6, 10.0  # in a row and longer than an error of the radio lasts, while others fit
_OTHERS_S = 10.0
_MOVES = 3  # a tag that moved so often is not one tag
_FARTHEST_M, _GREATEST_SD_M, _LEAST_SD_M = 1e6, 1e3, 1e-4


class TagTrust:
    """Counts sightings that contradict a tag's place while other tags fit theirs."""

    def __init__(self) -> None:
        self._misfits: dict[str, tuple[int, float]] = {}  # in a row, and since when
        self._moves: dict[str, int] = {}
        self._fitted: dict[str, float] = {}  # when a tag last fitted

    def is_banned(self, tag_id: str) -> bool:
        """Whether a tag has moved so often that it cannot be one that stays where it is."""
        return self._moves.get(tag_id, 0) >= _MOVES

    def judge(self, tag_id: str, stamp_s: float, distance: float) -> bool:
        """Take in a squared innovation; say whether the tag has to have moved."""
        if distance < _FAR_OFF:
            self._misfits.pop(tag_id, None)
            self._fitted[tag_id] = stamp_s
            return False
        count, since_s = self._misfits.get(tag_id, (0, stamp_s))
        self._misfits[tag_id] = (count + 1, since_s)
        if count + 1 < _TIMES or stamp_s - since_s < _FOR_S:
            return False
        others = (s for t, s in self._fitted.items() if t != tag_id)
        if max(others, default=-1e9) < stamp_s - _OTHERS_S:
            return False  # it may be the robot that is not where it thinks
        del self._misfits[tag_id]
        self._moves[tag_id] = self._moves.get(tag_id, 0) + 1
        return True


def plausible(sighting: RangeSighting) -> bool:
    """Whether a sighting is one that a radio can make."""
    bearing = 0.0 if sighting.bearing_rad is None else sighting.bearing_rad
    sd = 1.0 if sighting.bearing_sd_rad is None else sighting.bearing_sd_rad
    antenna = sighting.base_from_antenna
    numbers = (sighting.range_m, sighting.range_sd_m, bearing, sd, *antenna.as_array())
    return (
        all(map(isfinite, numbers))
        and isfinite(sighting.stamp_s)
        and 0.0 <= sighting.range_m < _FARTHEST_M
        and sighting.range_sd_m > 0.0
        and sd > 0.0
    )


def plausible_belief(belief: TagBelief) -> bool:
    """Whether a place that another robot left is one that a robot can believe."""
    numbers = (belief.x_m, belief.y_m, belief.variance_x, belief.covariance_xy, belief.variance_y)
    if not all(map(isfinite, numbers)) or max(abs(belief.x_m), abs(belief.y_m)) > _FARTHEST_M:
        return False
    least, greatest = _LEAST_SD_M**2, _GREATEST_SD_M**2
    if not (least < belief.variance_x < greatest and least < belief.variance_y < greatest):
        return False
    return belief.covariance_xy**2 < belief.variance_x * belief.variance_y
