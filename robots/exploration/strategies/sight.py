"""What lay within the small range in sight of a trail, kept up while the trail and the map grow.

Looking round anew from every place of a trail costs the more, the longer the trail. What was in sight of a
place stays as it was until a cell about it changes: only new places and those near changes look again.
"""

from __future__ import annotations

from math import atan2, ceil, cos, floor, pi, sin

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robots.planning.plan_grid import FREE, PlanGrid
from robots.se2 import Array

Mask = NDArray[np.bool_]
Cells = NDArray[np.uint8]
Counts = NDArray[np.int32]
CLEAR_CONE_RAD = pi / 3.0  # of the camera that looks for victims
_TILE = 16  # cells: where cells changed is known to a square of so many


class Sight:
    """Counts for each cell of a grid how many places of a trail have it in sight.

    What ``look`` returns depends on what it is given alone, never on what it was asked before.
    """

    def __init__(self) -> None:
        self._frame: tuple[object, ...] = ()
        self._free: Mask = np.zeros((0, 0), bool)
        self._counts: Counts = np.zeros((2, 0, 0), np.int32)  # of safe and of cleared ground
        self._views: dict[bytes, tuple[int, int, Cells]] = {}  # row, column and what is in sight from there

    def look(self, grid: PlanGrid, trail: Array, safe_m: float) -> tuple[Mask, Mask]:
        """Return which free cells lay in sight of a trail within ``safe_m``, and in the camera's cone.

        Args:
            grid: the plan grid, (h, w) cells.
            trail: x, y, heading of where robots were, (k, 3 or more).
            safe_m: the small range.

        Returns:
            Safe and cleared cells, bool (h, w) each.
        """
        free, half = grid.cells == FREE, floor(safe_m / grid.cell_m) + 1
        frame = free.shape, grid.origin, grid.cell_m, safe_m
        if frame != self._frame:
            self._frame, self._views = frame, {}
            self._counts = np.zeros((2, *free.shape), np.int32)
        elif self._views:
            self._forget(_seen_by(_changed_tiles(free, self._free), self._views, half))
        self._free = free
        names = dict.fromkeys(row.tobytes() for row in np.ascontiguousarray(trail[:, :3], np.float64))
        self._forget([name for name in self._views if name not in names])
        for name in names:
            if name not in self._views:
                x, y, heading = np.frombuffer(name)
                row, column = grid.cell_of(x, y)
                view = _look(free, x, y, heading, *grid.origin, grid.cell_m, safe_m, row, column, half)
                self._views[name] = row, column, view
                _count(self._counts, view, row, column, 1)
        return self._counts[0] > 0, self._counts[1] > 0

    def _forget(self, names: list[bytes]) -> None:
        for name in names:
            row, column, view = self._views.pop(name)
            _count(self._counts, view, row, column, -1)


def _seen_by(changed: Mask, views: dict[bytes, tuple[int, int, Cells]], half: int) -> list[bytes]:
    """Return the places that have tiles in sight that changed."""
    at = np.array([(row, column) for row, column, _ in views.values()])
    low, high = np.maximum(at - half, 0) // _TILE, (at + half) // _TILE + 1
    # how many tiles changed above and left of each corner
    sums = np.pad(changed.astype(np.int64).cumsum(0).cumsum(1), ((1, 0), (1, 0)))
    low, high = (np.clip(corner, 0, changed.shape) for corner in (low, high))
    inside = (
        sums[high[:, 0], high[:, 1]] - sums[low[:, 0], high[:, 1]]
        - sums[high[:, 0], low[:, 1]] + sums[low[:, 0], low[:, 1]]
    )  # fmt: skip
    return [name for name, count in zip(views, inside, strict=True) if count > 0]


@njit(cache=True)
def _changed_tiles(free: Mask, before: Mask) -> Mask:
    rows, columns = free.shape
    changed = np.zeros((rows // _TILE + 1, columns // _TILE + 1), np.bool_)
    for r in range(rows):
        for c in range(columns):
            if free[r, c] != before[r, c]:
                changed[r // _TILE, c // _TILE] = True
    return changed


@njit(cache=True)
def _look(
    free: Mask, x: float, y: float, heading: float, left: float, low: float, cell: float, reach: float,
    row: int, column: int, half: int,
) -> Cells:  # fmt: skip
    """Return a square about the place: free cells in sight 1, ahead 3. Rays end half a cell apart."""
    rows, columns = free.shape
    view = np.zeros((2 * half + 1, 2 * half + 1), np.uint8)
    rays = ceil(2.0 * pi * reach / (0.5 * cell))
    steps = floor(reach / (0.5 * cell))
    for ray in range(rays):
        angle = ray * 2.0 * pi / rays
        turn = angle - heading
        mark = 3 if abs(atan2(sin(turn), cos(turn))) <= 0.5 * CLEAR_CONE_RAD else 1
        across, along = sin(angle), cos(angle)
        for step in range(steps + 1):
            r = floor((y + 0.5 * step * cell * across - low) / cell)
            c = floor((x + 0.5 * step * cell * along - left) / cell)
            if r < 0 or c < 0 or r >= rows or c >= columns or not free[r, c]:
                if step > 1:  # the robot's own cell may be in doubt
                    break
                continue
            view[r - row + half, c - column + half] |= mark
    return view


@njit(cache=True)
def _count(counts: Counts, view: Cells, row: int, column: int, by: int) -> None:
    side = view.shape[0]
    top, left = row - side // 2, column - side // 2
    for v in range(max(0, -top), min(side, counts.shape[1] - top)):
        for u in range(max(0, -left), min(side, counts.shape[2] - left)):
            if view[v, u] & 1:
                counts[0, top + v, left + u] += by
            if view[v, u] & 2:
                counts[1, top + v, left + u] += by
