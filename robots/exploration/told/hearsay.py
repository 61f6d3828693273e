"""What tags said, to be told again in others: news goes back to the entrance with whoever drives there.

A tag knows what its writers knew while it was in reach; what they saw later stands in tags farther on. Told
again by those who read it, it meets robots that have not gone there yet. Only where tags lie exactly where
they are believed to: errors of their places would add up from tag to tag until all seems covered.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from robots.exploration.told.claims import KnownTag
from robots.tags.memory import REACH, TagMemory, cell_of, shift_of
from robots.tags.window import trimmed

Place = tuple[float, float]
_MARGIN = 40  # cells by which it grows


class Hearsay:
    """The cells of all tags read, on the lattice of the first of them, in the map frame."""

    def __init__(self) -> None:
        self._corner: Place | None = None  # middle of cell (0, 0)
        self._cell_m = 0.0
        self._cells: NDArray[np.uint8] = np.zeros((0, 0), np.uint8)  # rows along x, as in windows
        self._drawn: dict[str, TagMemory] = {}

    def draw(self, tags: Sequence[KnownTag]) -> None:
        """Take in what tags say that said less before."""
        for tag in tags:
            if self._drawn.get(tag.tag_id) is not tag.memory and tag.memory.cells.any():
                self._drawn[tag.tag_id] = tag.memory
                self._cell_m = self._cell_m or tag.memory.cell_m
                if tag.memory.cell_m != self._cell_m:
                    continue  # cells of another size are told again by those who began with them
                part = self._window(tag.place_m, tag.memory.phase, tag.memory.side // 2)
                np.maximum(part, tag.memory.cells, out=part)

    def about(self, place: Place, phase: int) -> TagMemory:
        """Return what others said of the ground round a tag at a place, to be told on its lattice."""
        if self._corner is None or cell_of(phase) != self._cell_m:
            return TagMemory.empty()
        cells = self._window(place, phase, REACH)
        return TagMemory(trimmed(cells.copy()), phase=phase) if cells.any() else TagMemory.empty()

    def _window(self, place: Place, phase: int, reach: int) -> NDArray[np.uint8]:
        """Return the cells round a tag, to be read or written; another one is off by up to half a cell."""
        middle = tuple(at + shift for at, shift in zip(place, shift_of(phase), strict=True))
        self._corner = self._corner or (middle[0], middle[1])
        first = [
            round((at - corner) / self._cell_m) - reach
            for at, corner in zip(middle, self._corner, strict=True)
        ]
        side = 2 * reach + 1
        margins = [
            (max(0, -at) and _MARGIN - at, max(0, at + side - length) and at + side - length + _MARGIN)
            for at, length in zip(first, self._cells.shape, strict=True)
        ]
        if any(any(margin) for margin in margins):
            self._cells = np.pad(self._cells, margins)
            self._corner = (
                self._corner[0] - margins[0][0] * self._cell_m,
                self._corner[1] - margins[1][0] * self._cell_m,
            )
            first = [at + margin[0] for at, margin in zip(first, margins, strict=True)]
        return self._cells[first[0] : first[0] + side, first[1] : first[1] + side]
