"""Do the wheels slip? Kleiner 2006 section IV: a decision tree on the wheels' velocity differences.

The extended tree also sees the last 0.3 s, the gyro and what the robot was told to do; where one of them is
missing the basic one decides.
"""

from __future__ import annotations

from collections import deque
from math import isfinite
from typing import Literal

from robots.estimation.slip.features import (
    BASIC_FEATURES,
    EXTENDED_FEATURES,
    WINDOW_S,
    Moment,
    Noise,
    basic_features,
    extended_features,
)
from robots.estimation.slip.noise import WalkNoise
from robots.estimation.slip.patches import UNKNOWN
from robots.estimation.slip.tree import SlipTrees, load_trees
from robots.se2 import wrap
from robots.types import Command, ImuReading, Odometry, WheelEncoders

_STILL_MPS = 0.02  # wheels slower than this stand still
_GAP_S = 0.5  # beyond so much without wheels the past says nothing about the present
_ROUNDING_S = 1e-6


class SlipDetector:
    """Watches one robot's observations in their order.

    ``kind``: the "extended" tree with the "basic" one where it lacks something, or the basic one alone.

    Raises:
        SlipTreeError: the trees that come with the program are damaged.
    """

    def __init__(
        self, kind: Literal["basic", "extended"] = "extended", trees: SlipTrees | None = None
    ) -> None:
        self._kind = kind
        self._trees = trees if trees is not None else load_trees(BASIC_FEATURES, EXTENDED_FEATURES)
        self._moments: deque[Moment] = deque()  # those of the window, and the one before it
        self._noise = Noise(WalkNoise(), WalkNoise())
        self._stamp_s: float | None = None
        self._pending = [0.0, 0.0, 0.0, 0.0]  # metres rolled while the clock stood still
        self.slipping = False
        self.share = UNKNOWN  # of slippage among moments like the last one

    def observe(
        self, stamp_s: float, odometry: Odometry | None, imu: ImuReading | None, command: Command | None
    ) -> bool:
        """Return whether the wheels slipped since the previous observation.

        ``command`` is the one that was in force meanwhile. Odometry that is not of four wheels says nothing.
        """
        before, self._stamp_s = self._stamp_s, stamp_s
        if not isinstance(odometry, WheelEncoders) or before is None or not 0.0 <= stamp_s - before <= _GAP_S:
            return self._forget()
        rolled = odometry.front_left_m, odometry.front_right_m, odometry.rear_left_m, odometry.rear_right_m
        for k in range(4):
            self._pending[k] += rolled[k]
        since_s = stamp_s - before
        if since_s < _ROUNDING_S:
            self._stamp_s = before
            return self.slipping
        wheels = [way / since_s for way in self._pending]
        self._pending = [0.0, 0.0, 0.0, 0.0]
        if not all(map(isfinite, wheels)):
            return self._forget()
        four = wheels[0], wheels[1], wheels[2], wheels[3]
        self._remember(Moment(stamp_s, since_s, four, self._unwrapped(imu), _motion(command)))
        self.share, self.slipping = UNKNOWN, False
        if max(map(abs, wheels)) >= _STILL_MPS:
            self._decide()
        return self.slipping

    def values(self) -> tuple[list[float] | None, list[float] | None]:
        """Return the features of the latest observation, basic and extended; None where there are none."""
        if not self._moments:
            return None, None
        moments = list(self._moments)
        edge_s = moments[-1].stamp_s - WINDOW_S + _ROUNDING_S
        first = next(k for k, moment in enumerate(moments) if moment.stamp_s > edge_s)
        extended = extended_features(moments[first:], moments[first - 1], self._noise) if first > 0 else None
        return basic_features(moments[-1], self._noise), extended

    def _decide(self) -> None:
        basic, extended = self.values()
        tree, values = self._trees.basic, basic
        if extended is not None and self._kind == "extended":
            tree, values = self._trees.extended, extended
        if values is not None:
            self.share = tree.share(values)
            self.slipping = self.share > tree.alarm_above

    def _remember(self, moment: Moment) -> None:
        self._moments.append(moment)
        front_left, _, rear_left, _ = moment.wheels
        rolled_m, since_s = moment.rolled_m, moment.since_s
        self._noise.differences.observe(front_left - rear_left, rolled_m, since_s)
        self._noise.mean.observe(sum(moment.wheels) / 4.0, rolled_m, since_s)
        edge_s = moment.stamp_s - WINDOW_S + _ROUNDING_S
        while len(self._moments) > 2 and self._moments[1].stamp_s <= edge_s:
            self._moments.popleft()

    def _unwrapped(self, imu: ImuReading | None) -> float | None:
        if imu is None:
            return None
        last = self._moments[-1].yaw_rad if self._moments else None
        return imu.yaw_rad if last is None else last + wrap(imu.yaw_rad - last)

    def _forget(self) -> bool:
        self._moments.clear()
        self._noise.differences.forget()
        self._noise.mean.forget()
        self._pending = [0.0, 0.0, 0.0, 0.0]
        self.share, self.slipping = UNKNOWN, False
        return False


def _motion(command: Command | None) -> tuple[float, float] | None:
    return None if command is None else (command.linear_mps, command.angular_radps)
