"""Many submaps drawn into one grid; moving one costs only that one."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from math import ceil, cos, floor, sin

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robots.mapping.changes import Changes
from robots.mapping.occupancy import proved
from robots.se2 import Array, Pose2

_MARGIN_CELLS = 80


@dataclass(frozen=True, slots=True, eq=False)
class _Drawn:
    version: int
    map_from_grid: Pose2
    row: int  # of the drawing's corner, in cells from the map's origin (may be negative)
    column: int
    cells: NDArray[np.int16]
    touched: NDArray[np.int32] | None  # the submap's own, still being written where the submap is


class FusedGrid:
    """The sum of submaps' log-odds (tenths), int32, in a grid parallel to the map frame that grows as needed.

    Cell (0, 0) has its lower left corner at ``origin`` (x, y) in metres.
    """

    shared = False  # whether the cells are everybody's, as in experiments with one map

    def __init__(self, resolution_m: float) -> None:
        self.resolution_m = resolution_m
        self.cells: NDArray[np.int32] = np.zeros((0, 0), np.int32)
        self.changes = Changes()  # of the cells, while their shape and origin stay
        self._row0 = 0
        self._column0 = 0
        self._drawn: dict[Hashable, _Drawn] = {}

    @property
    def origin(self) -> tuple[float, float]:
        """Lower left corner (x, y) of cell (0, 0) in metres."""
        return self._column0 * self.resolution_m, self._row0 * self.resolution_m

    def unsure(self, free_logodds: int) -> NDArray[np.bool_] | None:
        """Return the free cells, (h, w), that no beam crossed that came back; None where it is not kept.

        Free are those of at most ``-free_logodds`` tenths. It is drawn when asked for, which is seldom.
        """
        kept = [(drawn, drawn.touched) for drawn in self._drawn.values() if drawn.touched is not None]
        if not kept:
            return None
        found: NDArray[np.bool_] = self.cells <= -free_logodds
        for drawn, touched in kept:
            row, column = drawn.row - self._row0, drawn.column - self._column0
            h, w = drawn.cells.shape
            sure = self._drawing(proved(touched), drawn.map_from_grid, drawn.row, drawn.column, (h, w))
            found[row : row + h, column : column + w] &= sure == 0
        return found

    def known(self) -> tuple[NDArray[np.int32], tuple[float, float]]:
        """Return the cells cut to those known, and the corner (x, y) in metres of the first of them.

        The same whatever the order in which the map grew; shape (0, 0) where nothing is known.
        """
        rows = np.flatnonzero(self.cells.any(axis=1))
        columns = np.flatnonzero(self.cells.any(axis=0))
        if not len(rows):
            return self.cells[:0, :0], (0.0, 0.0)
        row, column = int(rows[0]), int(columns[0])
        cut = self.cells[row : int(rows[-1]) + 1, column : int(columns[-1]) + 1]
        r = self.resolution_m
        return cut, ((self._column0 + column) * r, (self._row0 + row) * r)

    def covering(self, low_m: Array, high_m: Array, factor: int) -> FusedGrid:
        """Return a copy that reaches over a box with corners (x, y) too.

        It is larger by multiples of ``factor`` cells, so that squares of so many stay what they are.
        """
        r, (h, w) = self.resolution_m, self.cells.shape
        below, left = (
            -(-max(0, ceil((o - v) / r)) // factor) * factor
            for o, v in zip(self.origin[::-1], low_m[::-1], strict=True)
        )
        above, right = (
            -(-max(0, ceil((v - o) / r) - n) // factor) * factor
            for v, o, n in zip(high_m[::-1], self.origin[::-1], (h, w), strict=True)
        )
        copy = FusedGrid(r)
        copy.cells = np.pad(self.cells, ((below, above), (left, right)))
        copy._row0, copy._column0 = self._row0 - below, self._column0 - left
        return copy

    def put(
        self,
        key: Hashable,
        version: int,
        map_from_grid: Pose2,
        cells: NDArray[np.int16] | NDArray[np.int8],
        tolerance_m: float = 0.01,
        touched: NDArray[np.int32] | None = None,
    ) -> bool:
        """Draw a submap, replacing its earlier drawing; say whether anything changed.

        ``map_from_grid`` places the lower left corner of the submap's cell (0, 0). A submap that moved by
        less than ``tolerance_m`` at its far corner keeps its drawing. ``touched`` is what ``cast_scan`` keeps
        of the same cells; it is not copied.
        """
        old = self._drawn.get(key)
        if old is not None:
            stays = self._same_place(old.map_from_grid, map_from_grid, cells, tolerance_m)
            if old.version == version and stays:
                return False
            self._add(old, -1)
        if cells.size == 0:
            self._drawn.pop(key, None)
            return old is not None
        new = self._draw(version, map_from_grid, cells, touched)
        self._cover(new)
        self._add(new, 1)
        self._drawn[key] = new
        return True

    def drop(self, key: Hashable) -> None:
        """Take a submap out of the map."""
        old = self._drawn.pop(key, None)
        if old is not None:
            self._add(old, -1)

    def _same_place(self, a: Pose2, b: Pose2, cells: NDArray[np.generic], tolerance_m: float) -> bool:
        x, y = cells.shape[1] * self.resolution_m, cells.shape[0] * self.resolution_m
        corners = np.array([[0.0, 0.0], [x, y]])
        return bool(np.abs(a.transform(corners) - b.transform(corners)).max() < tolerance_m)

    def _draw(
        self, version: int, pose: Pose2, cells: NDArray[np.generic], touched: NDArray[np.int32] | None
    ) -> _Drawn:
        r = self.resolution_m
        h, w = cells.shape
        corners = pose.transform(np.array([[0.0, 0.0], [w * r, 0.0], [0.0, h * r], [w * r, h * r]]))
        left, low = floor(corners[:, 0].min() / r), floor(corners[:, 1].min() / r)
        right, high = ceil(corners[:, 0].max() / r), ceil(corners[:, 1].max() / r)
        drawing = self._drawing(cells, pose, low, left, (high - low, right - left))
        return _Drawn(version, pose, low, left, drawing, touched)

    def _drawing(
        self, cells: NDArray[np.generic], pose: Pose2, row: int, column: int, shape: tuple[int, int]
    ) -> NDArray[np.int16]:
        r, drawing = self.resolution_m, np.zeros(shape, np.int16)
        _resample(
            cells.astype(np.int16), drawing, column + 0.5, row + 0.5, pose.x / r, pose.y / r,
            cos(pose.theta), sin(pose.theta),
        )  # fmt: skip
        return drawing

    def _add(self, drawn: _Drawn, sign: int) -> None:
        row, column = drawn.row - self._row0, drawn.column - self._column0
        h, w = drawn.cells.shape
        self.cells[row : row + h, column : column + w] += sign * drawn.cells
        self.changes.note(row, column, row + h, column + w)

    def _cover(self, drawn: _Drawn) -> None:
        h, w = self.cells.shape
        bottom, left = drawn.row, drawn.column
        top, right = bottom + drawn.cells.shape[0], left + drawn.cells.shape[1]
        if h == 0:
            self._row0, self._column0 = bottom, left
        if (
            h
            and bottom >= self._row0
            and left >= self._column0
            and top <= self._row0 + h
            and right <= self._column0 + w
        ):
            return
        row0 = self._row0 if h and bottom >= self._row0 else bottom - _MARGIN_CELLS
        column0 = self._column0 if h and left >= self._column0 else left - _MARGIN_CELLS
        row1 = self._row0 + h if h and top <= self._row0 + h else top + _MARGIN_CELLS
        column1 = self._column0 + w if h and right <= self._column0 + w else right + _MARGIN_CELLS
        grown = np.zeros((row1 - row0, column1 - column0), np.int32)
        r, c = self._row0 - row0, self._column0 - column0
        grown[r : r + h, c : c + w] = self.cells
        self.cells, self._row0, self._column0 = grown, row0, column0


@njit(cache=True)
def _resample(
    cells: NDArray[np.int16],
    drawing: NDArray[np.int16],
    left: float,
    low: float,
    x: float,
    y: float,
    c: float,
    s: float,
) -> None:
    """Fill the drawing: for each of its cells the submap's cell under its centre. All lengths in cells."""
    for row in range(drawing.shape[0]):
        for column in range(drawing.shape[1]):
            dx, dy = left + column - x, low + row - y
            u = floor(c * dx + s * dy)
            v = floor(-s * dx + c * dy)
            if 0 <= v < cells.shape[0] and 0 <= u < cells.shape[1]:
                drawing[row, column] = cells[v, u]
