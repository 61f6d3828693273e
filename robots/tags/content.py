"""The bytes of a tag's memory: one that says which kinds follow, then each kind, its own length known."""

from __future__ import annotations

from robots.tags.map_memory import pack_maps, unpack_maps
from robots.tags.marks import (
    Notes,
    Pass,
    VictimMark,
    pack_notes,
    pack_passes,
    pack_victims,
    unpack_notes,
    unpack_passes,
    unpack_victims,
)
from robots.tags.memory import CELLS_M, CENTRED, REACH, VISITED_REACH, TagMemory, TagMemoryError
from robots.tags.window import Cells, no_cells, pack, unpack

VERSION = 0x40  # the two high bits; the others say which kinds follow
MAX_BYTES = 1 << 16
_SIZES_FROM = 2 * (REACH + 1) + 2  # a window's first byte below it: cells of 1 m
_KINDS = 0x3F
_VICTIMS, _NOTES, _PASSES, _VISITED, _COVERAGE, _MAPS = (1 << k for k in range(6))


def encode_memory(memory: TagMemory) -> bytes:
    """Return a memory's bytes.

    Raises:
        ValueError: a map, a name or a text is too large.
    """
    kinds = {
        _VICTIMS: pack_victims(memory.victims) if memory.victims else b"",
        _NOTES: pack_notes(memory.notes) if memory.notes != Notes() else b"",
        _PASSES: pack_passes(memory.passes) if memory.passes else b"",
        _VISITED: _pack_window(memory.visited, memory.visited_reach) if memory.has_visited else b"",
        _COVERAGE: (
            bytes([memory.phase & 0xFF]) + _pack_window(memory.cells, memory.reach, memory.phase >> 8)
            if memory.has_coverage
            else b""
        ),
        _MAPS: pack_maps(memory.maps) if memory.maps else b"",
    }
    return bytes([VERSION | sum(kind for kind, data in kinds.items() if data)]) + b"".join(kinds.values())


def decode_memory(data: bytes) -> TagMemory:
    """Return the memory that ``encode_memory`` wrote; no bytes at all are an empty memory.

    Raises:
        TagMemoryError: too short or too long, of another version, or damaged.
    """
    if not data:
        return TagMemory.empty()
    if data[0] & ~_KINDS != VERSION:
        raise TagMemoryError(f"a tag memory of this version begins with 64 to 127; this one with {data[0]}")
    if len(data) > MAX_BYTES:
        raise TagMemoryError(f"a tag memory has at most {MAX_BYTES} bytes; this one has {len(data)}")
    try:
        return _decoded(data)
    except (ValueError, IndexError) as error:
        raise TagMemoryError(f"the tag memory is damaged: {error}") from error


def merge_bytes(first: bytes, second: bytes) -> bytes:
    """Merge two encoded memories.

    Raises:
        TagMemoryError: one of them cannot be read.
    """
    return encode_memory(decode_memory(first).merge(decode_memory(second)))


def _decoded(data: bytes) -> TagMemory:
    kinds, at = data[0] & _KINDS, 1
    victims: tuple[VictimMark, ...] = ()
    notes, passes = Notes(), tuple[Pass, ...]()
    visited, visited_reach, cells, phase, reach = no_cells(), VISITED_REACH, no_cells(), CENTRED, REACH
    if kinds & _VICTIMS:
        victims, used = unpack_victims(data[at:])
        at += used
    if kinds & _NOTES:
        notes, used = unpack_notes(data[at:])
        at += used
    if kinds & _PASSES:
        passes, used = unpack_passes(data[at:])
        at += used
    if kinds & _VISITED:
        visited, visited_reach, _, at = _unpack_window(data, at, VISITED_REACH, 1)
    if kinds & _COVERAGE:
        place = _byte(data, at)
        cells, reach, size, at = _unpack_window(data, at + 1, REACH, len(CELLS_M))
        phase = place | size << 8
    maps = unpack_maps(data[at:]) if kinds & _MAPS else ()
    if not kinds & _MAPS and at != len(data):
        raise ValueError(f"it has {len(data) - at} bytes too many")
    return TagMemory(cells, maps, victims, notes, passes, visited, phase, reach, visited_reach)


def _pack_window(cells: Cells, reach: int, size: int = 0) -> bytes:
    """Return the reach it was cut to, one more where cells follow (0 where none had room), and their size."""
    return bytes([2 * (reach + 1) + bool(cells.any()) + size * _SIZES_FROM]) + (
        pack(cells, reach) if cells.any() else b""
    )


def _unpack_window(data: bytes, at: int, most: int, sizes: int) -> tuple[Cells, int, int, int]:
    """Return the cells, the reach, the number of their size, and where the window ends."""
    size, told = divmod(_byte(data, at), _SIZES_FROM)
    if size >= sizes:
        raise ValueError(f"its cells have a size {size} that does not exist")
    further, holds = divmod(told, 2)
    reach = further - 1
    if reach > most or (reach == most and not holds) or (reach < 0 and holds):
        raise ValueError(f"its window reaches {reach} cells")
    if not holds:
        return no_cells(), reach, size, at + 1
    cells, used = unpack(data[at + 1 :], reach)
    return cells, reach, size, at + 1 + used


def _byte(data: bytes, at: int) -> int:
    if at >= len(data):
        raise ValueError(f"it ends after {len(data)} bytes")
    return data[at]
