"""Which ground is covered, far beyond a small map: cells of half a metre, by what tags say and own eyes.

Drawn anew only where a tag said something new, or when a tag is believed elsewhere.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from robots.exploration.told.claims import KnownTag
from robots.exploration.told.survey import LATTICE_M, Survey
from robots.planning.plan_grid import FREE, OCCUPIED, UNKNOWN, PlanGrid
from robots.se2 import Array
from robots.tags.memory import CELL_M, CLOSED, OPEN, UNSEEN, TagMemory

Cells = NDArray[np.uint8]
Index = NDArray[np.int64]
Place = tuple[float, float]
_PER_CELL = round(CELL_M / LATTICE_M)
_ROUND = np.ones((3, 3), bool)
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

    def draw(self, tags: Sequence[KnownTag]) -> None:
        """Take in what tags say."""
        if any(self._has_moved(tag) for tag in tags):
            self._drawn, self._told = {}, np.zeros_like(self._told)
        for tag in tags:
            known = self._drawn.get(tag.tag_id)
            if known is None or known[0] is not tag.memory:
                self._drawn[tag.tag_id] = tag.memory, tag.place_m
                self._draw(tag.memory, tag.place_m)

    def see(self, grid: PlanGrid) -> None:
        """Take in what the robot sees now.

        A cell is open where free ground ends in it, and covered when half of it is known or a wall is in it.
        """
        known, free = grid.cells != UNKNOWN, grid.cells == FREE
        edge = np.zeros_like(known)
        edge[1:-1, 1:-1] = free[1:-1, 1:-1] & ~(
            known[:-2, 1:-1] & known[2:, 1:-1] & known[1:-1, :-2] & known[1:-1, 2:]
        )
        rows, columns = (
            np.floor((start + (np.arange(count) + 0.5) * grid.cell_m) / LATTICE_M).astype(np.int64)
            for start, count in zip(grid.origin[::-1], known.shape, strict=True)
        )
        full = (LATTICE_M / grid.cell_m) ** 2
        covered = _gathered(known, rows, columns) >= _KNOWN_SHARE * full
        covered |= _gathered(grid.cells == OCCUPIED, rows, columns) * grid.cell_m >= _EDGE_M
        ends = _gathered(edge, rows, columns) * grid.cell_m >= _EDGE_M
        state = np.where(ends, OPEN, np.where(covered, CLOSED, UNSEEN))
        self._put("_own", state.astype(np.uint8), int(rows[0]), int(columns[0]))

    def settle(self) -> None:
        """Put together what tags say and what the robot saw.

        A tag's cell is covered when half of it is, so at its border it may hide a door: covered ground that
        is told of counts against the robot's own eyes only where all round it is covered as well.
        """
        told = self._told == CLOSED
        self._sure = (self._own == CLOSED) | (
            told & ndimage.binary_erosion(told | (self._own == CLOSED), _ROUND)
        )
        own_word = np.where(self._sure, CLOSED, OPEN)
        self.cells = np.where(self._own == UNSEEN, self._told, own_word).astype(np.uint8)

    def survey(self) -> Survey:
        """Return it as strategies weigh it: unknown to the robot's own map all over."""
        cells = self.cells
        return Survey(np.ones(cells.shape), cells, (self.corner[1] * LATTICE_M, self.corner[0] * LATTICE_M))

    def closed_at(self, x: Array, y: Array) -> NDArray[np.bool_]:
        """Say of a lattice of points, columns at x (w,) and rows at y (h,), which are covered and closed."""
        row = np.floor(y / LATTICE_M).astype(np.int64) - self.corner[0]
        column = np.floor(x / LATTICE_M).astype(np.int64) - self.corner[1]
        sure = np.pad(self._sure, 1)
        row, column = np.clip(row + 1, 0, len(sure) - 1), np.clip(column + 1, 0, sure.shape[1] - 1)
        closed: NDArray[np.bool_] = sure[np.ix_(row, column)]
        return closed

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
        fine = np.repeat(np.repeat(memory.cells.T, _PER_CELL, axis=0), _PER_CELL, axis=1)  # rows along y
        half, (north, west) = memory.side / 2.0 * CELL_M, memory.shift_m
        row, column = (round((v - half) / LATTICE_M) for v in (place[1] + west, place[0] + north))
        self._put("_told", fine, row, column)

    def _put(self, name: str, cells: Cells, row: int, column: int) -> None:
        self._cover(row, column, *cells.shape)
        top, left = row - self.corner[0], column - self.corner[1]
        part = getattr(self, name)[top : top + cells.shape[0], left : left + cells.shape[1]]
        np.maximum(part, cells, out=part)

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


def _gathered(mask: NDArray[np.bool_], rows: Index, columns: Index) -> Index:
    """Return how many cells of a mask fall into each cell of the lattice; its rows and columns are given."""
    sums = np.zeros((rows[-1] - rows[0] + 1, columns[-1] - columns[0] + 1), np.int64)
    np.add.at(sums, np.ix_(rows - rows[0], columns - columns[0]), mask)
    return sums
