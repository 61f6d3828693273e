"""Where a robot was, and what is left of its way."""

from __future__ import annotations

from math import hypot

import numpy as np

from robots.se2 import Array, Pose2

_EVERY_M = 0.25
_ARRIVED_M = 0.3


class Trail:
    """The poses of one robot in its map frame, one each quarter of a metre."""

    def __init__(self) -> None:
        self._points: list[tuple[float, float, float, float]] = []
        self._array: Array = np.zeros((0, 4))

    def note(self, now_s: float, pose: Pose2) -> None:
        """Note where it is."""
        if self._points and hypot(self._points[-1][0] - pose.x, self._points[-1][1] - pose.y) < _EVERY_M:
            return
        self._points.append((pose.x, pose.y, pose.theta, now_s))

    @property
    def points(self) -> Array:
        """All of it, (k, 4): x, y, heading and stamp, oldest first."""
        if len(self._array) < len(self._points):
            self._array = np.array(self._points)
        return self._array


def rest_of(path_m: Array, pose: Pose2) -> Array:
    """Return a path, (n, 2), from its point nearest to the robot on."""
    if len(path_m) == 0:
        return path_m
    return path_m[int(np.hypot(path_m[:, 0] - pose.x, path_m[:, 1] - pose.y).argmin()) :]


def is_at_end(path_m: Array, pose: Pose2) -> bool:
    """Say whether a robot has come to the end of a path, (n, 2), or has none."""
    return len(path_m) == 0 or hypot(path_m[-1, 0] - pose.x, path_m[-1, 1] - pose.y) < _ARRIVED_M
