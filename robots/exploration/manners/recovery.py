"""Noticing that driving leads nowhere, and getting away from there."""

from __future__ import annotations

from math import cos, sin

import numpy as np
from numpy.typing import NDArray

from robots.planning.plan_grid import PlanGrid
from robots.planning.travel import UNREACHED
from robots.se2 import Array, Pose2, wrap

_PROGRESS_M, _PROGRESS_RAD = 0.15, 0.5
_BACK_OFF_S = 1.4
_BACK_OFF_MPS, _BACK_OFF_RADPS = -0.15, 0.6
_OPEN_STEP = 5  # cost of a cell with nothing near
_ASIDE_FROM_M, _ASIDE_TO_M = 1.0, 5.0  # how far to go to give way
_STANDS_S, _STANDS_MPS, _STANDS_RADPS = 1.5, 0.01, 0.1
_BLOCKED_S, _BLOCKED_RADIUS_M = 40.0, 0.35
_REPEATED_S = 25.0  # stuck again so soon: backing off a little does not help here
_PAUSE_S = 2.5  # without a decision: that the robot stood since says nothing


class Recovery:
    """Watches progress; when there is none, backs off for a moment, turning to the left and right in turn."""

    def __init__(self, stuck_after_s: float) -> None:
        self._stuck_after_s = stuck_after_s
        self._pose: Pose2 | None = None  # where progress was last seen
        self._since_s = self._asked_s = 0.0
        self._until_s: float | None = None
        self._times: list[float] = []
        self._stood_since_s: float | None = None
        self._nudges: list[float] = []
        self._backings = 0

    @property
    def active(self) -> bool:
        """Whether it is backing off now."""
        return self._until_s is not None

    def rest(self) -> None:
        """The robot means to stand still: no progress is expected."""
        self._pose = None
        self._stood_since_s = None

    def begins(self, now_s: float, pose: Pose2, bumped: bool) -> bool:
        """Say whether the robot has just been found stuck; it backs off from now on."""
        if now_s - self._asked_s > _PAUSE_S:
            self._since_s, self._stood_since_s = now_s, None
        self._asked_s = now_s
        if self._pose is None:
            self._pose, self._since_s = pose, now_s
            return False
        turned = abs(wrap(pose.theta - self._pose.theta))
        if self._pose.distance(pose) > _PROGRESS_M or turned > _PROGRESS_RAD:
            self._pose, self._since_s = pose, now_s
        elif now_s - self._since_s > self._stuck_after_s:
            bumped = True
        if not bumped:
            return False
        self._times = [time for time in self._times if now_s - time < _REPEATED_S] + [now_s]
        self._until_s = now_s + _BACK_OFF_S
        self._backings += 1
        return True

    def blocked(self, now_s: float, linear_mps: float, angular_radps: float) -> bool:
        """Take in what following the way comes to; say whether the place ahead is to blame.

        Standing before something in plain sight it backs off sooner than where nothing is seen. The first
        time only the way out of here is to blame; when it comes to the same soon after, the place is.
        """
        if abs(linear_mps) > _STANDS_MPS or abs(angular_radps) > _STANDS_RADPS:
            self._stood_since_s = None
        elif self._stood_since_s is None:
            self._stood_since_s = now_s
        elif now_s - self._stood_since_s > _STANDS_S:
            self._stood_since_s = None
            self._backings += 1
            self._until_s = now_s + _BACK_OFF_S
            self._nudges = [time for time in self._nudges if now_s - time < _REPEATED_S] + [now_s]
            if len(self._nudges) > 1:
                self._times = [time for time in self._times if now_s - time < _REPEATED_S] + [now_s]
                return True
        return False

    def velocities(self, now_s: float) -> tuple[float, float] | None:
        """Return the velocities (m/s, rad/s) of backing off; None once it is over."""
        if self._until_s is None:
            return None
        if now_s >= self._until_s:
            self._until_s, self._pose = None, None
            return None
        side = 1.0 if self._backings % 2 else -1.0
        return _BACK_OFF_MPS, side * _BACK_OFF_RADPS

    @property
    def keeps_failing(self) -> bool:
        """Whether it got stuck more than once lately: probably something else wants to pass here too."""
        return len(self._times) > 1

    def forget(self) -> None:
        """Begin to count anew."""
        self._times, self._nudges = [], []


class Blocked:
    """Ground that could not be driven, left alone for a while (map frame)."""

    def __init__(self) -> None:
        self._places: list[tuple[float, float, float]] = []  # x, y, until

    def add(self, place: tuple[float, float], now_s: float) -> None:
        """Leave a place alone from now on."""
        self._places.append((*place, now_s + _BLOCKED_S))

    def clear(self) -> bool:
        """Try all of it again; say whether there was any."""
        before, self._places = self._places, []
        return bool(before)

    def discs(self, now_s: float) -> Array:
        """Return what is left alone now, (n, 3): x, y, radius."""
        self._places = [place for place in self._places if place[2] > now_s]
        return np.array([(x, y, _BLOCKED_RADIUS_M) for x, y, _ in self._places]).reshape(-1, 3)


def place_ahead(pose: Pose2, distance_m: float) -> tuple[float, float]:
    """Return the point (x, y) so far ahead of the robot."""
    return pose.x + distance_m * cos(pose.theta), pose.y + distance_m * sin(pose.theta)


def spot_aside(
    grid: PlanGrid, costs: NDArray[np.int32], place: tuple[float, float], rng: np.random.Generator
) -> tuple[int, int] | None:
    """Return an open cell a little way off, one of those farthest from a place; None where there is none."""
    cost_m = costs / 5.0 * grid.cell_m
    spots = np.argwhere(
        (costs != UNREACHED) & (grid.steps == _OPEN_STEP) & (cost_m > _ASIDE_FROM_M) & (cost_m < _ASIDE_TO_M)
    )
    if len(spots) == 0:
        return None
    x, y = grid.centres_of(spots).T
    choices = np.argsort(-np.hypot(x - place[0], y - place[1]), kind="stable")[: max(1, len(spots) // 4)]
    row, column = spots[int(choices[rng.integers(len(choices))])]
    return int(row), int(column)
