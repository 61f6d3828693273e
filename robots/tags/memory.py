"""What a tag's memory says: which ground round it has been covered, as a value that merges.

A window of cells of 1 m, centred on the tag, rows to the north (x of the frame), columns to the west (y):
the frame of the writer's compass. A cell only grows: unknown < covered with an open frontier < covered and
closed. Merging takes the maximum, so it is commutative, associative and idempotent, and no order of visits
loses anything. Beside the window may stand maps of tags that robots left (``map_memory``), where the tag has
the room.

What a chip has no room for is let go by rules that look at sizes, never at what the cells say: the window's
outer rings, and all but the newest beliefs. So the laws hold on small chips too: fitting before or after a
merge comes to the same.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import floor

import numpy as np
from numpy.typing import NDArray

from robots.planning.plan_grid import FREE, UNKNOWN, PlanGrid
from robots.tags.map_memory import WriterMap, fit_maps, least_room, merge_maps

SIDE = 31  # cells, the largest window; all windows have an odd side
CELL_M = 1.0
UNSEEN, OPEN, CLOSED = 0, 1, 2
_KNOWN_SHARE = 0.5
_HEAD = 2  # bytes before the window


class TagMemoryError(ValueError):
    """The bytes are no memory of this version, or they are damaged."""


@dataclass(frozen=True, slots=True, eq=False)
class TagMemory:
    """Coverage round a tag: ``cells`` uint8 (s, s), s odd, of UNSEEN, OPEN, CLOSED; ``maps`` robots left."""

    cells: NDArray[np.uint8]
    maps: tuple[WriterMap, ...] = ()

    @classmethod
    def empty(cls) -> TagMemory:
        """Return the memory of a new tag."""
        return cls(np.zeros((1, 1), np.uint8))

    @property
    def side(self) -> int:
        """Cells along the window."""
        return len(self.cells)

    def merge(self, other: TagMemory) -> TagMemory:
        """Return all that both know."""
        side = max(self.side, other.side)
        cells = np.maximum(resized(self.cells, side), resized(other.cells, side))
        return TagMemory(cells, merge_maps(self.maps, other.maps))

    def fit(self, room_bytes: int) -> TagMemory:
        """Return as much of it as has room in so many bytes of content."""
        side = min(self.side, side_for(room_bytes))
        left = room_bytes - _HEAD - window_bytes(min(SIDE, side_for(room_bytes)))
        return TagMemory(resized(self.cells, side), fit_maps(self.maps, left))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, TagMemory):
            return NotImplemented
        return np.array_equal(_trimmed(self.cells), _trimmed(other.cells)) and self.maps == other.maps

    def __hash__(self) -> int:
        return hash((_trimmed(self.cells).tobytes(), self.maps))


def window_bytes(side: int) -> int:
    """Return the bytes of a window: five cells of three states in each."""
    return -(-side * side // 5)


def side_for(room_bytes: int) -> int:
    """Return the side of the largest window in so many bytes of content; 1 at least, ``SIDE`` at most."""
    fitting = [side for side in range(1, SIDE + 1, 2) if _HEAD + window_bytes(side) <= room_bytes]
    return max(fitting, default=1)


def room_for_maps() -> int:
    """Return the bytes of content from which on a map has room beside the largest window."""
    return _HEAD + window_bytes(SIDE) + least_room()


def resized(cells: NDArray[np.uint8], side: int) -> NDArray[np.uint8]:
    """Return a window with rings of UNSEEN put round it, or rings taken off."""
    more = (side - len(cells)) // 2
    if more >= 0:
        return np.pad(cells, more)
    return cells[-more:more, -more:more]


def _trimmed(cells: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return the window without outer rings that say nothing."""
    middle = len(cells) // 2
    rows, columns = np.nonzero(cells)
    reach = max(np.abs(rows - middle).max(initial=0), np.abs(columns - middle).max(initial=0))
    return resized(cells, 2 * int(reach) + 1)


def observed_memory(grid: PlanGrid, tag_x: float, tag_y: float) -> TagMemory:
    """Return what a robot's plan grid (map frame, x north) knows round a tag at (x, y)."""
    memory = np.zeros((SIDE, SIDE), np.uint8)
    known = grid.cells != UNKNOWN
    edge = np.zeros_like(known)
    free = grid.cells == FREE
    edge[1:-1, 1:-1] = free[1:-1, 1:-1] & ~(
        known[:-2, 1:-1] & known[2:, 1:-1] & known[1:-1, :-2] & known[1:-1, 2:]
    )
    for i in range(SIDE):  # to the north: x
        for j in range(SIDE):  # to the west: y
            x0, y0 = tag_x + (i - SIDE / 2) * CELL_M, tag_y + (j - SIDE / 2) * CELL_M
            low, left = grid.cell_of(x0, y0)
            high, right = low + floor(CELL_M / grid.cell_m), left + floor(CELL_M / grid.cell_m)
            if low < 0 or left < 0 or high > known.shape[0] or right > known.shape[1]:
                continue
            block = known[low:high, left:right]
            if block.mean() >= _KNOWN_SHARE:
                memory[i, j] = OPEN if edge[low:high, left:right].any() else CLOSED
    return TagMemory(memory)
