"""What a tag's memory says: which ground round it has been covered, as a value that merges.

A window of 27 x 27 cells of 1 m, centred on the tag, rows to the north (x of the frame), columns to the west
(y): the frame of the writer's compass. A cell only grows: unknown < covered with an open frontier < covered
and closed. Merging takes the maximum, so it is commutative, associative and idempotent, and no order of
visits loses anything. 186 bytes: it fits a 2,048-bit tag beside its link.

Behind the window may stand maps of tags that robots left (``map_memory``), where the tag has the room.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from math import floor

import numpy as np
from numpy.typing import NDArray

from robots.planning.plan_grid import FREE, UNKNOWN, PlanGrid
from robots.tags.map_memory import WriterMap, merge_maps, pack_maps, unpack_maps

SIDE = 27
CELL_M = 1.0
UNSEEN, OPEN, CLOSED = 0, 1, 2
_VERSION, _WITH_MAPS = 1, 2
MAX_BYTES = 1 << 20
_BYTES = 1 + 2 + (SIDE * SIDE * 2 + 7) // 8
_KNOWN_SHARE = 0.5


class TagMemoryError(ValueError):
    """The bytes are no memory of this version, or they are damaged."""


@dataclass(frozen=True, slots=True, eq=False)
class TagMemory:
    """Coverage round a tag: ``cells`` uint8 (27, 27) of UNSEEN, OPEN, CLOSED; ``maps`` that robots left."""

    cells: NDArray[np.uint8]
    maps: tuple[WriterMap, ...] = ()

    @classmethod
    def empty(cls) -> TagMemory:
        """Return the memory of a new tag."""
        return cls(np.zeros((SIDE, SIDE), np.uint8))

    def merge(self, other: TagMemory) -> TagMemory:
        """Return all that both know."""
        return TagMemory(np.maximum(self.cells, other.cells), merge_maps(self.maps, other.maps))

    def __eq__(self, other: object) -> bool:
        same = isinstance(other, TagMemory) and bool((self.cells == other.cells).all())
        return same and isinstance(other, TagMemory) and self.maps == other.maps

    def __hash__(self) -> int:
        return hash((self.cells.tobytes(), self.maps))


def encode_memory(memory: TagMemory) -> bytes:
    """Return a memory's bytes: version, checksum, two bits a cell (186 in all), then the maps if any.

    Raises:
        ValueError: the maps are too large.
    """
    bits = np.unpackbits(memory.cells.reshape(-1, 1), axis=1)[:, 6:].ravel()
    body = np.packbits(bits).tobytes()
    if memory.maps:
        body += pack_maps(memory.maps)
    check = zlib.crc32(body) & 0xFFFF
    return bytes([_WITH_MAPS if memory.maps else _VERSION]) + check.to_bytes(2, "big") + body


def decode_memory(data: bytes) -> TagMemory:
    """Return the memory that ``encode_memory`` wrote; no bytes at all are an empty memory.

    Raises:
        TagMemoryError: too short or too long, of another version, or damaged.
    """
    if not data:
        return TagMemory.empty()
    fits = len(data) == _BYTES if data[0] == _VERSION else _BYTES < len(data) <= MAX_BYTES
    if data[0] not in (_VERSION, _WITH_MAPS) or not fits:
        raise TagMemoryError(
            f"a tag memory has {_BYTES} bytes and begins with {_VERSION}, or is longer, holds maps and begins"
            f" with {_WITH_MAPS}; this one has {len(data)}"
        )
    body = data[3:]
    if zlib.crc32(body) & 0xFFFF != int.from_bytes(data[1:3], "big"):
        raise TagMemoryError("the tag memory is damaged: its checksum does not fit; read it again")
    bits = np.unpackbits(np.frombuffer(body, np.uint8))[: SIDE * SIDE * 2].reshape(-1, 2)
    cells = (bits[:, 0] * 2 + bits[:, 1]).astype(np.uint8).reshape(SIDE, SIDE)
    if cells.max() > CLOSED:
        raise TagMemoryError("the tag memory is damaged: a cell has a state that does not exist")
    try:
        return TagMemory(cells, unpack_maps(body[_BYTES - 3 :]) if len(data) > _BYTES else ())
    except ValueError as error:
        raise TagMemoryError(f"the tag memory is damaged: {error}") from error


def merge_bytes(first: bytes, second: bytes) -> bytes:
    """Merge two encoded memories.

    Raises:
        TagMemoryError: one of them cannot be read.
    """
    return encode_memory(decode_memory(first).merge(decode_memory(second)))


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
