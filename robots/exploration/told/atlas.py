"""Which ground is covered, far beyond a small map: cells of half a metre, by what tags say and own eyes.

Drawn anew only where a tag said something new, or when a tag is believed elsewhere.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import floor

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robots.exploration.told.claims import KnownTag
from robots.exploration.told.survey import LATTICE_M, Survey, fine_cells
from robots.planning.plan_grid import FREE, OCCUPIED, UNKNOWN, PlanGrid
from robots.se2 import Array
from robots.tags.memory import CLOSED, OPEN, UNSEEN, TagMemory

Cells = NDArray[np.uint8]
Place = tuple[float, float]
Box = tuple[int, int, int, int]  # first row and column of the lattice, and those after the last
_MARGIN = 40  # cells by which it grows
_KNOWN_SHARE = 0.5
_EDGE_M = 0.24  # of the end of free ground, or of a wall
_MOVED_M = LATTICE_M / 2.0


class Atlas:
    """UNSEEN, OPEN, CLOSED on a lattice in the map frame, whose first cell is (row, column) ``corner``."""

    def __init__(self) -> None:
        self.corner = (0, 0)
        self.cells: Cells = np.zeros((0, 0), np.uint8)
        self._sure: NDArray[np.bool_] = np.zeros((0, 0), bool)
        self._told: Cells = np.zeros((0, 0), np.uint8)
        self._own: Cells = np.zeros((0, 0), np.uint8)
        self._drawn: dict[str, tuple[TagMemory, Place]] = {}
        self._looked_at: dict[str, KnownTag] = {}
        self._unsettled: Box | None = None

    def draw(self, tags: Sequence[KnownTag]) -> None:
        """Take in what tags say."""
        fresh = [tag for tag in tags if self._looked_at.get(tag.tag_id) is not tag]
        if any(self._has_moved(tag) for tag in fresh):
            fresh, self._drawn, self._told = list(tags), {}, np.zeros_like(self._told)
            self._note(*self.corner, *self._told.shape)
        for tag in fresh:
            self._looked_at[tag.tag_id] = tag
            known = self._drawn.get(tag.tag_id)
            if known is None or known[0] is not tag.memory:
                self._drawn[tag.tag_id] = tag.memory, tag.place_m
                self._draw(tag.memory, tag.place_m)

    def see(self, grid: PlanGrid) -> None:
        """Take in what the robot sees now.

        A cell is open where free ground ends in it, and covered when half of it is known or a wall is in it.
        """
        state, row, column = _seen(grid.cells, grid.origin, grid.cell_m)
        self._put("_own", state, row, column)

    def settle(self) -> None:
        """Put together what tags say and what the robot saw, where either has changed.

        A tag's cell is covered when half of it is, so at its border it may hide a door: covered ground that
        is told of counts against the robot's own eyes only where all round it is covered as well.
        """
        if self._unsettled is None:
            return
        top, left = self._unsettled[0] - self.corner[0], self._unsettled[1] - self.corner[1]
        bottom, right = self._unsettled[2] - self.corner[0], self._unsettled[3] - self.corner[1]
        _settle(self._told, self._own, self._sure, self.cells, top - 1, left - 1, bottom + 1, right + 1)
        self._unsettled = None

    def survey(self, points_m: Array, within_m: float) -> Survey:
        """Return it as strategies weigh it, so far round points (n, 2): unknown to the robot's own map."""
        reach = round(within_m / LATTICE_M) + 1
        at = np.floor(points_m[:, ::-1] / LATTICE_M).astype(np.int64) - self.corner
        (top, left), (bottom, right) = (
            np.clip(edge, 0, self.cells.shape).tolist()
            for edge in (at.min(axis=0) - reach, at.max(axis=0) + reach + 1)
        )
        cells = self.cells[top:bottom, left:right]
        origin_m = (self.corner[1] + left) * LATTICE_M, (self.corner[0] + top) * LATTICE_M
        return Survey(np.ones(cells.shape), cells, origin_m)

    def with_covered(self, grid: PlanGrid) -> NDArray[np.uint8]:
        """Return the cells of a grid, (h, w), with covered ground beyond its edge no longer unknown."""
        cells: NDArray[np.uint8] = _with_covered(
            grid.cells, grid.origin, grid.cell_m, self._sure, self.corner
        )
        return cells

    def open_places(self) -> Array:
        """Return the middles of the cells that are covered and open, (n, 2)."""
        rows, columns = np.nonzero(self.cells == OPEN)
        cells = np.column_stack([columns + self.corner[1], rows + self.corner[0]])
        places: Array = (cells.astype(np.float64) + 0.5) * LATTICE_M
        return places

    def _has_moved(self, tag: KnownTag) -> bool:
        known = self._drawn.get(tag.tag_id)
        return known is not None and max(np.abs(np.subtract(known[1], tag.place_m))) > _MOVED_M

    def _draw(self, memory: TagMemory, place: Place) -> None:
        fine = fine_cells(memory)
        half, (north, west) = memory.side / 2.0 * memory.cell_m, memory.shift_m
        row, column = (round((v - half) / LATTICE_M) for v in (place[1] + west, place[0] + north))
        self._put("_told", fine, row, column)

    def _put(self, name: str, cells: Cells, row: int, column: int) -> None:
        self._cover(row, column, *cells.shape)
        top, left = row - self.corner[0], column - self.corner[1]
        part = getattr(self, name)[top : top + cells.shape[0], left : left + cells.shape[1]]
        np.maximum(part, cells, out=part)
        self._note(row, column, *cells.shape)

    def _note(self, row: int, column: int, rows: int, columns: int) -> None:
        """Note that so many cells from (row, column) on have to be settled."""
        box = row, column, row + rows, column + columns
        known = self._unsettled or box
        self._unsettled = (
            min(known[0], box[0]), min(known[1], box[1]), max(known[2], box[2]), max(known[3], box[3])
        )  # fmt: skip

    def _cover(self, row: int, column: int, rows: int, columns: int) -> None:
        """Grow until so many cells from (row, column) on have room."""
        shape = self._told.shape
        if not self._told.size:
            self.corner = (row, column)
        before = [max(0, corner - first) for corner, first in zip(self.corner, (row, column), strict=True)]
        ends = (row + rows, column + columns)
        after = [
            max(0, end - corner - side) for end, corner, side in zip(ends, self.corner, shape, strict=True)
        ]
        if not any(before + after):
            return
        margins = [(a and a + _MARGIN, b and b + _MARGIN) for a, b in zip(before, after, strict=True)]
        self.corner = self.corner[0] - margins[0][0], self.corner[1] - margins[1][0]
        self._told, self._own = np.pad(self._told, margins), np.pad(self._own, margins)
        self._sure, self.cells = np.pad(self._sure, margins), np.pad(self.cells, margins)


@njit(cache=True)
def _seen(cells: Cells, origin: Place, cell_m: float) -> tuple[Cells, int, int]:
    """Return the states of the lattice as a grid shows it, and the row and column at which they begin."""
    rows, columns = cells.shape
    row0, column0 = _lattice(origin[1], 0, cell_m), _lattice(origin[0], 0, cell_m)
    shape = (
        _lattice(origin[1], rows - 1, cell_m) - row0 + 1,
        _lattice(origin[0], columns - 1, cell_m) - column0 + 1,
    )
    known, walls, ends = np.zeros(shape, np.int64), np.zeros(shape, np.int64), np.zeros(shape, np.int64)
    for r in range(rows):
        y = _lattice(origin[1], r, cell_m) - row0
        for c in range(columns):
            if cells[r, c] == UNKNOWN:
                continue
            x = _lattice(origin[0], c, cell_m) - column0
            known[y, x] += 1
            walls[y, x] += cells[r, c] == OCCUPIED
            if cells[r, c] == FREE and 0 < r < rows - 1 and 0 < c < columns - 1:
                ends[y, x] += (
                    cells[r - 1, c] == UNKNOWN or cells[r + 1, c] == UNKNOWN
                    or cells[r, c - 1] == UNKNOWN or cells[r, c + 1] == UNKNOWN
                )  # fmt: skip
    states = np.full(shape, UNSEEN, np.uint8)
    full = (LATTICE_M / cell_m) ** 2
    for y in range(shape[0]):
        for x in range(shape[1]):
            if ends[y, x] * cell_m >= _EDGE_M:
                states[y, x] = OPEN
            elif known[y, x] >= _KNOWN_SHARE * full or walls[y, x] * cell_m >= _EDGE_M:
                states[y, x] = CLOSED
    return states, row0, column0


@njit(cache=True)
def _lattice(origin: float, cell: int, cell_m: float) -> int:
    """Return the row or column of the lattice in which the middle of a grid's cell lies."""
    return floor((origin + (cell + 0.5) * cell_m) / LATTICE_M)


@njit(cache=True)
def _settle(
    told: Cells,
    own: Cells,
    sure: NDArray[np.bool_],
    cells: Cells,
    top: int,
    left: int,
    bottom: int,
    right: int,
) -> None:
    rows, columns = told.shape
    for r in range(max(0, top), min(rows, bottom)):
        for c in range(max(0, left), min(columns, right)):
            sure[r, c] = own[r, c] == CLOSED
            if told[r, c] == CLOSED and not sure[r, c] and 0 < r < rows - 1 and 0 < c < columns - 1:
                round_it = True
                for v in range(r - 1, r + 2):
                    for u in range(c - 1, c + 2):
                        round_it &= told[v, u] == CLOSED or own[v, u] == CLOSED
                sure[r, c] = round_it
            if own[r, c] == UNSEEN:
                cells[r, c] = told[r, c]
            else:
                cells[r, c] = CLOSED if sure[r, c] else OPEN


@njit(cache=True)
def _with_covered(
    cells: Cells, origin: Place, cell_m: float, sure: NDArray[np.bool_], corner: tuple[int, int]
) -> Cells:
    covered = cells.copy()
    for r in range(cells.shape[0]):
        row = _lattice(origin[1], r, cell_m) - corner[0]
        if not 0 <= row < sure.shape[0]:
            continue
        for c in range(cells.shape[1]):
            column = _lattice(origin[0], c, cell_m) - corner[1]
            if cells[r, c] == UNKNOWN and 0 <= column < sure.shape[1] and sure[row, column]:
                covered[r, c] = OCCUPIED
    return covered
