"""Maps that robots leave in tags: M_k <- M_k + <j, b_j, Sigma_b_j, R> (Sun 2009 eq. 10).

A map belongs to its writer R and is written whole: positions in R's own map frame, from R's own measurements
alone. The newest of each writer stays, so merging is commutative, associative and idempotent, and reading one
memory again, or in a tag that took it from a third robot, brings nothing new to be counted twice.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from math import isfinite

MAX_WRITERS, MAX_BELIEFS = 100, 2000
_LONGEST_NAME = 16  # bytes; beliefs and writers with longer names find no room in a tag
_WRITER, _BELIEF, _FRAME = struct.Struct(">IH"), struct.Struct(">5f"), struct.Struct(">6f")
_HAS_FRAME = 0x8000  # in the number of beliefs
_HEAD, _SLOT = 1 + _LONGEST_NAME + _WRITER.size, 1 + _LONGEST_NAME + _BELIEF.size  # bytes at most


@dataclass(frozen=True, slots=True)
class TagBelief:
    """Where a robot believes a tag: metres and square metres, in its map frame."""

    tag_id: str
    x_m: float
    y_m: float
    variance_x: float
    covariance_xy: float
    variance_y: float


@dataclass(frozen=True, slots=True)
class WriterMap:
    """The tags one robot has mapped; a later map of the same robot has a greater ``revision``.

    ``frame``, where told: the covariance (xx, xy, xt, yy, yt, tt) of how the whole map lies in the frame of
    the robots' known starts, in m2, m rad and rad2; the beliefs' covariances are then those within the map.
    """

    writer: str
    revision: int
    beliefs: tuple[TagBelief, ...]
    frame: tuple[float, ...] = ()


def merge_maps(first: tuple[WriterMap, ...], second: tuple[WriterMap, ...]) -> tuple[WriterMap, ...]:
    """Return the newest map of each writer, in the order of their names; the first 100 of more."""
    newest: dict[str, WriterMap] = {}
    for each in (*first, *second):
        known = newest.get(each.writer)
        if known is None or _age(each) > _age(known):
            newest[each.writer] = each
    return tuple(newest[writer] for writer in sorted(newest)[:MAX_WRITERS])


def fit_maps(maps: tuple[WriterMap, ...], room_bytes: int) -> tuple[WriterMap, ...]:
    """Return as much of the maps as has room: the same number of beliefs of each writer, the first ones.

    How maps lie in a common frame finds no room. Places are counted, not bytes, and the more writers there
    are, the fewer beliefs each has: so fitting before a merge and after it comes to the same.
    """
    fitting = [each for each in maps if len(each.writer.encode()) <= _LONGEST_NAME]
    fitting = fitting[: max(0, room_bytes - 1) // (_HEAD + _SLOT)]
    if not fitting:
        return ()
    count = ((room_bytes - 1) // len(fitting) - _HEAD) // _SLOT
    return tuple(
        WriterMap(
            each.writer,
            each.revision,
            _with_short_names(each.beliefs)[:count],
        )
        for each in fitting
    )


def least_room() -> int:
    """Return the bytes in which a map with one tag has room."""
    return 1 + _HEAD + _SLOT


def pack_maps(maps: tuple[WriterMap, ...]) -> bytes:
    """Return the maps as bytes: 20 and its id for each tag.

    Raises:
        ValueError: a map is too large or a number is not finite.
    """
    if len(maps) > MAX_WRITERS or any(len(each.beliefs) > MAX_BELIEFS for each in maps):
        raise ValueError(f"a memory holds maps of {MAX_WRITERS} robots with {MAX_BELIEFS} tags each")
    parts = [bytes([len(maps)])]
    for each in maps:
        count = len(each.beliefs) | (_HAS_FRAME if each.frame else 0)
        parts += [_packed(each.writer), _WRITER.pack(each.revision, count)]
        if each.frame:
            if len(each.frame) != 6 or not all(map(isfinite, each.frame)):
                raise ValueError(f"the frame of the map of {each.writer} is not six finite numbers")
            parts.append(_FRAME.pack(*each.frame))
        for belief in each.beliefs:
            numbers = _numbers(belief)
            if not all(map(isfinite, numbers)):
                raise ValueError(f"the place of tag {belief.tag_id} is not finite")
            parts.append(_bytes(belief))
    return b"".join(parts)


def unpack_maps(data: bytes) -> tuple[WriterMap, ...]:
    """Return the maps that ``pack_maps`` wrote.

    Raises:
        ValueError: the bytes are something else, or a number in them is not finite.
    """
    try:
        return _unpack(data)
    except (struct.error, IndexError, UnicodeDecodeError) as error:
        raise ValueError("the maps in it are cut off or damaged") from error


def _unpack(data: bytes) -> tuple[WriterMap, ...]:
    at, maps = 1, []
    for _ in range(data[0]):
        writer, at = _unpacked(data, at)
        revision, count = _WRITER.unpack_from(data, at)
        at += _WRITER.size
        frame: tuple[float, ...] = ()
        if count & _HAS_FRAME:
            count ^= _HAS_FRAME
            frame = _FRAME.unpack_from(data, at)
            at += _FRAME.size
            if not all(map(isfinite, frame)):
                raise ValueError("the frame of a map in it is not finite")
        if count > MAX_BELIEFS:
            raise ValueError(f"a map in it has {count} tags, more than {MAX_BELIEFS}")
        beliefs = []
        for _ in range(count):
            tag_id, at = _unpacked(data, at)
            numbers = _BELIEF.unpack_from(data, at)
            at += _BELIEF.size
            if not all(map(isfinite, numbers)):
                raise ValueError("a place in it is not finite")
            beliefs.append(TagBelief(tag_id, *numbers))
        maps.append(WriterMap(writer, revision, tuple(beliefs), frame))
    if at != len(data) or len({each.writer for each in maps}) != len(maps) or len(maps) > MAX_WRITERS:
        raise ValueError("the maps in it are cut off or damaged")
    return merge_maps(tuple(maps), ())


def _numbers(belief: TagBelief) -> tuple[float, ...]:
    return (belief.x_m, belief.y_m, belief.variance_x, belief.covariance_xy, belief.variance_y)


def _age(each: WriterMap) -> tuple[int, list[bytes], list[bytes], tuple[float, ...]]:
    """Return what is greater for a later map.

    Two of one revision are told apart alike everywhere, and by what fits first, first.
    """
    short = _with_short_names(each.beliefs)
    return each.revision, [_bytes(b) for b in short], [_bytes(b) for b in each.beliefs], each.frame


def _bytes(belief: TagBelief) -> bytes:
    return _packed(belief.tag_id) + _BELIEF.pack(*_numbers(belief))


def _with_short_names(beliefs: tuple[TagBelief, ...]) -> tuple[TagBelief, ...]:
    return tuple(belief for belief in beliefs if len(belief.tag_id.encode()) <= _LONGEST_NAME)


def _packed(text: str) -> bytes:
    data = text.encode()
    if len(data) > 255:
        raise ValueError(f"the name {text[:20]}... is longer than 255 bytes")
    return bytes([len(data)]) + data


def _unpacked(data: bytes, at: int) -> tuple[str, int]:
    end = at + 1 + data[at]
    if end > len(data):
        raise IndexError
    return data[at + 1 : end].decode(), end
