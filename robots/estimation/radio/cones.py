"""What a directional antenna tells of bearings: a tag that it hears is in its cone, and was not just before.

That a tag is heard says only that it lies somewhere in the cone, the same again and again. When it falls
silent or is heard anew while the robot drives or turns past it, it is at the edge: a bearing as good as the
edge is sharp and the readings are frequent. Tags also fall silent behind corners and beyond the reach: a
crossing counts where it is at the edge rather than anywhere in the cone, and goes the way the robot moves.
"""

from __future__ import annotations

from bisect import bisect_right
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from math import copysign, exp, inf, pi, sqrt
from typing import Protocol, runtime_checkable

from robots.estimation.radio.model import Antenna, RadioModel
from robots.se2 import Pose2
from robots.types import TagSighting

EDGE_SD_RAD = pi / 45.0  # a cone is stated to some degrees
_WINDOW_S = 1.0  # in which the readings of a tag are counted
_MOMENT_S = 0.3  # in which those heard are counted: a robot that turns hears others soon
_SILENT = 5.0  # mean intervals without a reading: not by chance, but for one in 150
_PAUSE_S = 0.5
_LONGEST_S = 2.0  # a reader that is slower tells nothing of edges
_AT_EDGE = 0.7  # of the crossings in the middle of the reach; the others are corners, anywhere in the cone
_SURE_SD = 3.0
_REACH_SHARE, _NEAREST_M = 0.9, 0.3
_WIDEST_RAD = 0.2  # from the one side to the other; a faster turn tells little

Key = tuple[str, Antenna]


@dataclass(frozen=True, slots=True)
class Crossing:
    """A tag came into an antenna's cone or left it.

    ``base_from_first``, ``base_from_middle``, ``base_from_last``: the antenna when the tag surely was on the
    one side, probably at the edge, and surely on the other, in the base frame as it is now. ``outward``: it
    left. ``edge_rad`` is half the cone.
    """

    tag_id: str
    base_from_first: Pose2
    base_from_middle: Pose2
    base_from_last: Pose2
    outward: bool
    edge_rad: float
    reach_m: float


class ConeWatch:
    """Watches which tags the antennas of one robot hear."""

    def __init__(self, model: RadioModel) -> None:
        self._model = model
        self._recent: deque[tuple[float, Key]] = deque()
        self._inside: dict[Key, tuple[float, float]] = {}  # when it was heard last, and the interval then
        self._heard_s = self._since_s = -inf  # the newest reading, and the first without a pause since
        self._stamps_s: list[float] = []
        self._poses: list[Pose2] = []

    def watch(
        self, stamp_s: float, local_from_base: Pose2, sightings: Sequence[TagSighting]
    ) -> list[Crossing]:
        """Take in what was heard since the last observation; return the crossings found out by now."""
        self._keep(stamp_s, local_from_base)
        heard: list[Key] = [
            (s.tag_id, s.antenna) for s in sightings if s.antenna is not None and s.rssi_dbm is not None
        ]
        self._recent.extend((stamp_s, key) for key in heard)
        while self._recent and self._recent[0][0] <= stamp_s - _WINDOW_S:
            self._recent.popleft()
        if not heard:
            return []  # a reader that pauses is not one that drives past all tags
        interval_s = self._interval_s()
        if stamp_s > self._heard_s + _PAUSE_S or interval_s > _LONGEST_S / _SILENT:
            self._inside.clear()
            self._since_s = stamp_s
        self._heard_s = stamp_s
        first = self._since_s > stamp_s - _SILENT * interval_s
        crossings = []
        for key in dict.fromkeys(heard):
            if key not in self._inside and not first:
                crossings.append(self._crossing(key, stamp_s - interval_s, stamp_s, False))
            self._inside[key] = stamp_s, interval_s
        gone = [
            key
            for key, (last_s, usual_s) in self._inside.items()
            if last_s < stamp_s - _SILENT * max(interval_s, usual_s)
        ]
        for key in gone:
            last_s, usual_s = self._inside.pop(key)
            crossings.append(self._crossing(key, last_s, last_s + usual_s, True))
        return crossings

    def _interval_s(self) -> float:
        """Return the mean time between two readings of a tag by an antenna that hears it."""
        now_s = self._stamps_s[-1]
        audible = {key for stamp_s, key in self._recent if stamp_s > now_s - _MOMENT_S}
        step_s = self._stamps_s[-1] - self._stamps_s[-2] if len(self._stamps_s) > 1 else 0.0
        return max(_WINDOW_S * max(len(audible), 1) / len(self._recent), step_s)

    def _keep(self, stamp_s: float, local_from_base: Pose2) -> None:
        if self._stamps_s and stamp_s <= self._stamps_s[-1]:
            return
        self._stamps_s.append(stamp_s)
        self._poses.append(local_from_base)
        if self._stamps_s[0] < stamp_s - 3.0 * _LONGEST_S:
            kept = bisect_right(self._stamps_s, stamp_s - 2.0 * _LONGEST_S)
            del self._stamps_s[:kept], self._poses[:kept]

    def _crossing(self, key: Key, first_s: float, last_s: float, outward: bool) -> Crossing:
        here = self._poses[-1]
        antenna = self._model.direction(key[1]).base_from_antenna
        first, middle, last = (
            here.between(self._pose(at_s)) @ antenna for at_s in (first_s, (first_s + last_s) / 2.0, last_s)
        )
        config = self._model.config
        return Crossing(key[0], first, middle, last, outward, config.cone_rad / 2.0, config.reach_m)

    def _pose(self, stamp_s: float) -> Pose2:
        return self._poses[max(0, bisect_right(self._stamps_s, stamp_s + 1e-6) - 1)]


@runtime_checkable
class HearsCones(Protocol):
    """A filter that can make something of crossings."""

    def see_crossing(self, crossing: Crossing) -> None:
        """Take in that a tag came into the cone of an antenna or left it."""


@dataclass(frozen=True, slots=True)
class Expected:
    """Range and bearing at which a tag is expected, with variances."""

    range_m: float
    bearing_rad: float
    range_variance: float
    bearing_variance: float


def edge_of(
    crossing: Crossing, first: Expected, middle: Expected, last: Expected
) -> tuple[float, float] | None:
    """Return the bearing that a crossing tells, and its variance; None where it tells none.

    Between the edge, missed by a normal error, and a corner anywhere in the cone the variance counts for more
    the less sure it is that it was the edge (probabilistic data association, Bar-Shalom 1988, in short).
    ``first``, ``middle``, ``last``: what is expected from the three poses of the crossing.
    """
    farthest_m = middle.range_m + 2.0 * sqrt(middle.range_variance)
    if middle.range_m < _NEAREST_M or farthest_m > _REACH_SHARE * crossing.reach_m:
        return None
    edge = copysign(crossing.edge_rad, middle.bearing_rad)
    swept = last.bearing_rad - first.bearing_rad
    if abs(swept) > _WIDEST_RAD or swept * edge * (1.0 if crossing.outward else -1.0) <= 0.0:
        return None
    variance = EDGE_SD_RAD**2 + swept**2
    spread = middle.bearing_variance + variance
    if abs(middle.bearing_rad) + crossing.edge_rad < _SURE_SD * sqrt(spread):
        return None
    off = edge - middle.bearing_rad
    at_edge = _AT_EDGE * exp(-0.5 * off * off / spread) / sqrt(2.0 * pi * spread)
    elsewhere = (1.0 - _AT_EDGE) / (2.0 * crossing.edge_rad)
    sure = at_edge / (at_edge + elsewhere)
    return (edge, variance / sure) if sure > 0.5 else None
