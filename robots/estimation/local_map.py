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
from numpy.typing import NDArray

from robots.se2 import Array, Pose2

CELL_M = 0.1
REACH_CELLS = 4  # a cell knows points up to this many cells away: the catchment of the matcher is 0.4 m
_KEEP_APART_M = 0.04  # a point this near to an older one of the map adds nothing


class LocalMap:
    """Points and normals of the last ``scans`` inserted scans in the local frame, and the index over them."""

    def __init__(self, scans: int, half_width_m: float) -> None:
        self._scans: deque[tuple[Array, Array]] = deque(maxlen=scans)
        self._half_width_m = half_width_m
        self.points: Array = np.zeros((0, 2))
        self.normals: Array = np.zeros((0, 2))
        self.origin: Array = np.zeros(2)
        self.index: NDArray[np.int32] = np.zeros((0, 0), np.int32)

    def __len__(self) -> int:
        return len(self._scans)

    def insert(self, local_from_base: Pose2, points: Array, normals: Array) -> None:
        """Add a scan, points and normals (n, 2) in the base frame.

        The oldest scan leaves when the map is full.
        """
        rotation = Pose2(0.0, 0.0, local_from_base.theta)
        self._scans.append((local_from_base.transform(points), rotation.transform(normals)))
        self._rebuild(local_from_base)

    def clear(self) -> None:
        """Forget everything: the robot was carried elsewhere."""
        self._scans.clear()
        self.points = np.zeros((0, 2))
        self.normals = np.zeros((0, 2))
        self.index = np.zeros((0, 0), np.int32)

    def _rebuild(self, centre: Pose2) -> None:
        cells = 2 * int(np.ceil(self._half_width_m / CELL_M))
        self.origin = np.array(
            [
                floor(centre.x / CELL_M) * CELL_M - cells / 2 * CELL_M,
                floor(centre.y / CELL_M) * CELL_M - cells / 2 * CELL_M,
            ]
        )
        if self.index.shape != (cells, cells):
            self.index = np.empty((cells, cells), np.int32)
        points = np.concatenate([points for points, _ in self._scans])
        normals = np.concatenate([normals for _, normals in self._scans])
        keep = fill(points, normals, self.origin, self.index)
        self.points, self.normals = points[:keep].copy(), normals[:keep].copy()


@njit(cache=True)
def fill(points: Array, normals: Array, origin: Array, index: NDArray[np.int32]) -> int:
    """Thin the points in place, fill the nearest-point index and return how many points were kept."""
    rows, columns = index.shape
    index[:, :] = -1
    kept = 0
    for i in range(points.shape[0]):
        x, y = points[i, 0], points[i, 1]
        nx, ny = normals[i, 0], normals[i, 1]
        column = floor((x - origin[0]) / CELL_M)
        row = floor((y - origin[1]) / CELL_M)
        if row < 0 or column < 0 or row >= rows or column >= columns:
            continue
        j = index[row, column]
        if j >= 0:
            dx, dy = points[j, 0] - x, points[j, 1] - y
            same_side = nx * normals[j, 0] + ny * normals[j, 1] > 0.7 or (nx == 0.0 and ny == 0.0)
            if dx * dx + dy * dy < _KEEP_APART_M * _KEEP_APART_M and same_side:
                continue
        points[kept, 0], points[kept, 1] = x, y
        normals[kept, 0], normals[kept, 1] = nx, ny
        for r in range(max(0, row - REACH_CELLS), min(rows, row + REACH_CELLS + 1)):
            for c in range(max(0, column - REACH_CELLS), min(columns, column + REACH_CELLS + 1)):
                k = index[r, c]
                if k < 0:
                    index[r, c] = kept
                    continue
                cx, cy = origin[0] + (c + 0.5) * CELL_M, origin[1] + (r + 0.5) * CELL_M
                ax, ay = points[k, 0] - cx, points[k, 1] - cy
                bx, by = x - cx, y - cy
                if bx * bx + by * by < ax * ax + ay * ay:
                    index[r, c] = kept
        kept += 1
    return kept
