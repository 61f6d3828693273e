"""The bytes of a tag's memory: version, side of the window, five cells a byte, then the maps if any."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from robots.tags.map_memory import pack_maps, unpack_maps
from robots.tags.memory import SIDE, TagMemory, TagMemoryError, window_bytes

VERSION = 3
MAX_BYTES = 1 << 16
_PER_BYTE = 5  # cells of three states: 3**5 = 243
_WEIGHTS = 3 ** np.arange(_PER_BYTE)


def encode_memory(memory: TagMemory) -> bytes:
    """Return a memory's bytes.

    Raises:
        ValueError: the maps are too large.
    """
    cells = memory.cells.ravel()
    padded = np.zeros(window_bytes(memory.side) * _PER_BYTE, np.int64)
    padded[: len(cells)] = cells
    window = (padded.reshape(-1, _PER_BYTE) @ _WEIGHTS).astype(np.uint8).tobytes()
    return bytes([VERSION, memory.side]) + window + (pack_maps(memory.maps) if memory.maps else b"")


def decode_memory(data: bytes) -> TagMemory:
    """Return the memory that ``encode_memory`` wrote; no bytes at all are an empty memory.

    Raises:
        TagMemoryError: too short or too long, of another version, or damaged.
    """
    if not data:
        return TagMemory.empty()
    if data[0] != VERSION:
        raise TagMemoryError(f"a tag memory begins with {VERSION}, its version; this one with {data[0]}")
    if len(data) > MAX_BYTES:
        raise TagMemoryError(f"a tag memory has at most {MAX_BYTES} bytes; this one has {len(data)}")
    side = data[1] if len(data) > 1 else 0
    if side % 2 == 0 or side > SIDE:
        raise TagMemoryError(f"the tag memory is damaged: its window has {side} cells along a side")
    end = 2 + window_bytes(side)
    if len(data) < end:
        raise TagMemoryError(f"the tag memory is damaged: it ends after {len(data)} bytes of {end} or more")
    window = np.frombuffer(data[2:end], np.uint8)
    if (window > 242).any():
        raise TagMemoryError("the tag memory is damaged: a cell has a state that does not exist")
    digits = _digits()[window].ravel()
    if digits[side * side :].any():
        raise TagMemoryError("the tag memory is damaged: there are cells beyond its window")
    try:
        maps = unpack_maps(data[end:]) if len(data) > end else ()
    except ValueError as error:
        raise TagMemoryError(f"the tag memory is damaged: {error}") from error
    return TagMemory(digits[: side * side].reshape(side, side), maps)


def merge_bytes(first: bytes, second: bytes) -> bytes:
    """Merge two encoded memories.

    Raises:
        TagMemoryError: one of them cannot be read.
    """
    return encode_memory(decode_memory(first).merge(decode_memory(second)))


@lru_cache(maxsize=1)
def _digits() -> NDArray[np.uint8]:
    """The five cells of every byte, (243, 5)."""
    return (np.arange(243)[:, None] // _WEIGHTS % 3).astype(np.uint8)
