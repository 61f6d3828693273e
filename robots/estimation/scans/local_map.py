"""The local map a scan is matched against.

Surface points of the most recent scans, found by a nearest-point index. Kleiner 2006 section IV (after Hähnel
2004) keeps a local grid of the most recent scans. Here each cell of that grid knows the nearest surface point
with its normal, so the alignment is continuous and not bound to the cell size.
"""

from __future__ import annotations

from collections import deque
from math import floor

import numpy as np
from numba import njit

from robots.estimation.scans.nearest import (
    CELL_M,
    MAX_POINTS,
    MAX_REACH_CELLS,
    NOTHING,
    Index,
    nearest,
    stamp,
)
from robots.se2 import Array, Pose2

_KEEP_APART_M = 0.04  # a point this near to an older one of the map adds nothing
_REBUILT_EVERY = 3  # insertions; in between the map only grows


class LocalMap:
    """Points and normals of the last ``scans`` inserted scans in the local frame, and the index over them.

    ``points``, ``normals``: (n, 2), the normals zero where unknown; ``index``, ``origin``: see ``nearest``.
    Up to two scans more are kept until the map is built anew.
    """

    def __init__(self, scans: int, half_width_m: float) -> None:
        self._scans: deque[tuple[Array, Array]] = deque(maxlen=scans)
        self._cells = 2 * int(np.ceil(half_width_m / CELL_M))
        self.clear()

    def clear(self) -> None:
        """Forget everything: the robot was carried elsewhere."""
        self._scans.clear()
        self._until_rebuilt = 0
        self._count = 0
        self._points: Array = np.empty((0, 2))
        self._normals: Array = np.empty((0, 2))
        self.origin: Array = np.zeros(2)
        self.index: Index = np.zeros((0, 0), np.int32)

    def __len__(self) -> int:
        return len(self._scans)

    @property
    def points(self) -> Array:
        """Surface points, (n, 2), in the local frame."""
        return self._points[: self._count]

    @property
    def normals(self) -> Array:
        """Normals of the points, (n, 2), zero where unknown."""
        return self._normals[: self._count]

    def insert(self, local_from_base: Pose2, points: Array, normals: Array) -> None:
        """Add a scan, points and normals (n, 2) in the base frame.

        The oldest scan leaves when the map is full.
        """
        rotation = Pose2(0.0, 0.0, local_from_base.theta)
        self._scans.append((local_from_base.transform(points), rotation.transform(normals)))
        if self._until_rebuilt == 0:
            self._rebuild(local_from_base)
            self._until_rebuilt = _REBUILT_EVERY
        else:
            self._add(*self._scans[-1])
        self._until_rebuilt -= 1

    def _rebuild(self, centre: Pose2) -> None:
        """Build the map anew from its scans, the oldest first, with the index centred here."""
        if self.index.shape != (self._cells, self._cells):
            self.index = np.empty((self._cells, self._cells), np.int32)
        half = self._cells // 2
        self.origin = np.array([(floor(v / CELL_M) - half) * CELL_M for v in (centre.x, centre.y)])
        self.index.fill(NOTHING)
        self._count = 0
        for points, normals in self._scans:
            self._add(points, normals)

    def _add(self, points: Array, normals: Array) -> None:
        room = self._count + len(points)
        if room > len(self._points):
            grown = min(max(2 * len(self._points), room), MAX_POINTS)
            self._points = np.concatenate([self.points, np.empty((grown - self._count, 2))])
            self._normals = np.concatenate([self.normals, np.empty((grown - self._count, 2))])
        self._count = thin(points, normals, self._points, self._normals, self._count, self.index, self.origin)


@njit(cache=True)
def thin(
    new_points: Array,
    new_normals: Array,
    points: Array,
    normals: Array,
    count: int,
    index: Index,
    origin: Array,
) -> int:
    """Add the points, (m, 2), that say something new to the ``count`` there; return how many there are."""
    for i in range(new_points.shape[0]):
        x, y = new_points[i, 0], new_points[i, 1]
        nx, ny = new_normals[i, 0], new_normals[i, 1]
        j = nearest(x, y, index, origin)
        if j >= 0:
            dx, dy = points[j, 0] - x, points[j, 1] - y
            same_side = nx * normals[j, 0] + ny * normals[j, 1] > 0.7 or (nx == 0.0 and ny == 0.0)
            if dx * dx + dy * dy < _KEEP_APART_M * _KEEP_APART_M and same_side:
                continue
        if count < points.shape[0] and stamp(index, origin, count, x, y, MAX_REACH_CELLS):
            points[count, 0], points[count, 1] = x, y
            normals[count, 0], normals[count, 1] = nx, ny
            count += 1
    return count
