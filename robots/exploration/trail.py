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
        self._rows: Array = np.zeros((64, 4))  # the first of them are its points
        self._count = 0

    def note(self, now_s: float, pose: Pose2) -> None:
        """Note where it is."""
        if self._count:
            x, y, _, _ = self._rows[self._count - 1].tolist()
            if hypot(x - pose.x, y - pose.y) < _EVERY_M:
                return
        if self._count == len(self._rows):
            self._rows = np.concatenate([self._rows, np.zeros_like(self._rows)])
        self._rows[self._count] = pose.x, pose.y, pose.theta, now_s
        self._count += 1

    @property
    def points(self) -> Array:
        """All of it, (k, 4): x, y, heading and stamp, oldest first; points noted later do not change it."""
        return self._rows[: self._count]


def rest_of(path_m: Array, pose: Pose2) -> Array:
    """Return a path, (n, 2), from its point nearest to the robot on."""
    if len(path_m) == 0:
        return path_m
    return path_m[int(np.hypot(path_m[:, 0] - pose.x, path_m[:, 1] - pose.y).argmin()) :]


def is_at_end(path_m: Array, pose: Pose2) -> bool:
    """Say whether a robot has come to the end of a path, (n, 2), or has none."""
    return len(path_m) == 0 or hypot(path_m[-1, 0] - pose.x, path_m[-1, 1] - pose.y) < _ARRIVED_M
