"""The local map a scan is matched against.

Surface points of the most recent scans, found by a nearest-point index. Kleiner 2006 section IV (after Hähnel
2004) keeps a local grid of the most recent scans. Here each cell of that grid knows the nearest surface point
with its normal, so the alignment is continuous and not bound to the cell size.
"""

from __future__ import annotations

from math import floor, sqrt

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robots.estimation.nearest import CELL_M, MAX_POINTS, MAX_REACH_CELLS, NOTHING, Index, nearest, stamp
from robots.se2 import Array, Pose2

_KEEP_APART_M = 0.04  # a point this near to one of the map is that one, seen again
_SWEEP_EVERY = 5  # insertions between two removals of what was not seen for long
_MOST_SIGHTINGS = 10  # a point is the mean of so many at most: the map stays able to follow


class LocalMap:
    """Points and normals the last ``scans`` inserted scans saw in the local frame, and the index over them.

    A point seen again is averaged across its surface. ``points``, ``normals``: (n, 2); ``index``, ``origin``:
    see ``nearest``.
    """

    def __init__(self, scans: int, half_width_m: float) -> None:
        self._scans = scans
        self._cells = 2 * int(np.ceil(half_width_m / CELL_M))
        self.clear()

    def clear(self) -> None:
        """Forget everything: the robot was carried elsewhere."""
        self._inserted = 0
        self._count = 0
        self._points: Array = np.empty((MAX_POINTS, 2))
        self._normals: Array = np.empty((MAX_POINTS, 2))
        self._seen: NDArray[np.int32] = np.zeros(MAX_POINTS, np.int32)  # number of the last scan that saw it
        self._sightings: NDArray[np.int32] = np.zeros(MAX_POINTS, np.int32)
        self.origin: Array = np.zeros(2)
        self.index: Index = np.zeros((0, 0), np.int32)

    def __len__(self) -> int:
        return min(self._inserted, self._scans)

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

        What the last ``scans`` scans have not seen leaves the map within a few insertions.
        """
        if self._inserted % _SWEEP_EVERY == 0:
            self._sweep(local_from_base)
        self._inserted += 1
        rotation = Pose2(0.0, 0.0, local_from_base.theta)
        self._count = _insert(
            local_from_base.transform(points), rotation.transform(normals), self._inserted,
            self._points, self._normals, self._seen, self._sightings, self._count, self.index, self.origin,
        )  # fmt: skip

    def _sweep(self, centre: Pose2) -> None:
        """Remove what was not seen for long or lies far off, and centre the index here."""
        if self.index.shape != (self._cells, self._cells):
            self.index = np.empty((self._cells, self._cells), np.int32)
        half = self._cells // 2
        self.origin = np.array([(floor(v / CELL_M) - half) * CELL_M for v in (centre.x, centre.y)])
        oldest = self._inserted - self._scans + 1
        self._count = _sweep(
            self._points, self._normals, self._seen, self._sightings, self._count,
            oldest, self.index, self.origin,
        )  # fmt: skip


@njit(cache=True)
def _sweep(
    points: Array,
    normals: Array,
    seen: NDArray[np.int32],
    sightings: NDArray[np.int32],
    count: int,
    oldest: int,
    index: Index,
    origin: Array,
) -> int:
    index[:, :] = NOTHING
    kept = 0
    for i in range(count):
        if seen[i] > oldest and stamp(index, origin, kept, points[i, 0], points[i, 1], MAX_REACH_CELLS):
            points[kept], normals[kept] = points[i], normals[i]
            seen[kept], sightings[kept] = seen[i], sightings[i]
            kept += 1
    return kept


@njit(cache=True)
def _insert(
    new_points: Array,
    new_normals: Array,
    now: int,
    points: Array,
    normals: Array,
    seen: NDArray[np.int32],
    sightings: NDArray[np.int32],
    count: int,
    index: Index,
    origin: Array,
) -> int:
    for i in range(new_points.shape[0]):
        x, y = new_points[i, 0], new_points[i, 1]
        nx, ny = new_normals[i, 0], new_normals[i, 1]
        known = nx != 0.0 or ny != 0.0
        j = nearest(x, y, index, origin)
        if j >= 0:
            dx, dy = x - points[j, 0], y - points[j, 1]
            mx, my = normals[j, 0], normals[j, 1]
            if dx * dx + dy * dy < _KEEP_APART_M * _KEEP_APART_M and (not known or nx * mx + ny * my > 0.7):
                if known and seen[j] < now:  # once a scan
                    sightings[j] = min(sightings[j] + 1, _MOST_SIGHTINGS)
                    across = (dx * mx + dy * my) / sightings[j]
                    points[j, 0] += across * mx
                    points[j, 1] += across * my
                    mx += (nx - mx) / sightings[j]
                    my += (ny - my) / sightings[j]
                    size = sqrt(mx * mx + my * my)
                    normals[j, 0], normals[j, 1] = mx / size, my / size
                seen[j] = now
                continue
        if count < points.shape[0] and stamp(index, origin, count, x, y, MAX_REACH_CELLS):
            points[count], normals[count] = new_points[i], new_normals[i]
            seen[count], sightings[count] = now, 1
            count += 1
    return count
