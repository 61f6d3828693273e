"""What robots of a team tell each other: where they are and go, and ground that the others have not seen yet.

Places are in the mission frame, in metres; ground is told in tiles of a lattice that all robots share. The
bytes are bounded and checked, whatever a radio makes of them.
"""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass
from functools import lru_cache
from math import isfinite
from typing import Any

from robots.se2 import Pose2

TILE_CELLS = 32  # to a side
LATTICE_CELL_M = 0.1
TILE_M = TILE_CELLS * LATTICE_CELL_M
TILE_BYTES = TILE_CELLS * TILE_CELLS // 4  # two bits a cell
MAX_TILES = 64  # in one message
MAX_BYTES = 32_768  # of one message
MAX_ROBOTS = 128  # whose ground it speaks of
MAX_TILE = 32_000  # row or column: 100 km from where the mission frame begins

_MAGIC = b"WTM\x01"  # with the version of the format
_MAX_RAW = 2 * MAX_TILES * (TILE_BYTES + 8) + MAX_ROBOTS * 600
_MAX_ID_BYTES = 255
_MAX_M = 1e6
_MAX_NUMBER = 2**31 - 1
_HEAD = struct.Struct("<BIdddd")  # flags, number, stamp, x, y, heading
_GOAL = struct.Struct("<dd")
_KNOWN = struct.Struct("<I")
_PATCH = struct.Struct("<BIIB")  # whose, since, until, tiles
_TILE = struct.Struct("<hhI")  # row, column, version
_STATION, _HAS_GOAL, _BUSY = 1, 2, 4


class TeamMessageError(ValueError):
    """The bytes are no message of this version; the text says why."""


@dataclass(frozen=True, slots=True)
class Tile:
    """A square of ground as one robot saw it.

    Its lower left corner is at (``column``, ``row``) * TILE_M in the mission frame. ``version`` rises with
    every tile that its robot finds changed. ``cells``: TILE_BYTES bytes, two bits for each cell, row by
    row: 0 unknown, 1 free, 2 occupied.
    """

    row: int
    column: int
    version: int
    cells: bytes


@dataclass(frozen=True, slots=True)
class Patch:
    """All tiles of one robot's ground that changed after version ``since``, up to ``until``."""

    origin: str
    since: int
    until: int
    tiles: tuple[Tile, ...]


@dataclass(frozen=True, slots=True)
class TeamMessage:
    """One message of a robot, or of a ``station`` that stands and relays.

    ``pose`` and ``goal_m`` (x, y) in the mission frame; ``stamp_s`` on the sender's clock; ``number`` rises
    with every message. ``busy``: it is not free to explore, as it was told something else or has to go back.
    ``known``: pairs of a robot and the version up to which the sender has its ground.
    """

    robot_id: str
    number: int
    stamp_s: float
    pose: Pose2
    goal_m: tuple[float, float] | None = None
    known: tuple[tuple[str, int], ...] = ()
    patches: tuple[Patch, ...] = ()
    station: bool = False
    busy: bool = False


def encode_message(message: TeamMessage) -> bytes:
    """Return the bytes of a message.

    Raises:
        TeamMessageError: it holds more than a message may hold, or a number that is none.
    """
    _check(message)
    flags = _STATION * message.station | _HAS_GOAL * (message.goal_m is not None) | _BUSY * message.busy
    pose = message.pose
    names = {name: place for place, (name, _) in enumerate(message.known)}
    parts = [
        _HEAD.pack(flags, message.number, message.stamp_s, pose.x, pose.y, pose.theta),
        _named(message.robot_id),
    ]
    if message.goal_m is not None:
        parts.append(_GOAL.pack(*message.goal_m))
    parts.append(bytes([len(message.known)]))
    parts += [_named(name) + _KNOWN.pack(version) for name, version in message.known]
    parts.append(bytes([len(message.patches)]))
    for patch in message.patches:
        parts.append(_PATCH.pack(names[patch.origin], patch.since, patch.until, len(patch.tiles)))
        parts += [_TILE.pack(tile.row, tile.column, tile.version) + tile.cells for tile in patch.tiles]
    body = zlib.compress(b"".join(parts), 1)
    return _MAGIC + zlib.crc32(body).to_bytes(4, "little") + body


@lru_cache(maxsize=256)  # everybody in reach hears the same bytes
def decode_message(data: bytes) -> TeamMessage:
    """Return the message of bytes that ``encode_message`` made.

    Raises:
        TeamMessageError: they are damaged, of another version, too long, or say what cannot be.
    """
    if len(data) > MAX_BYTES:
        raise TeamMessageError(f"it has {len(data)} bytes, more than {MAX_BYTES}")
    if data[:4] != _MAGIC:
        raise TeamMessageError("it is of another version, or no message at all")
    body = data[8:]
    if zlib.crc32(body).to_bytes(4, "little") != data[4:8]:
        raise TeamMessageError("it was damaged on the way")
    try:
        unpacker = zlib.decompressobj()
        raw = unpacker.decompress(body, _MAX_RAW)
        if not unpacker.eof or unpacker.unused_data:
            raise TeamMessageError("it is longer than a message may be")
        message = _Reader(raw).message()
    except (zlib.error, struct.error, IndexError, UnicodeDecodeError) as error:
        raise TeamMessageError("it is cut short or garbled") from error
    _check(message)
    return message


class _Reader:
    """Reads the parts of a message one after the other."""

    def __init__(self, raw: bytes) -> None:
        self._raw = raw
        self._at = 0

    def message(self) -> TeamMessage:
        flags, number, stamp_s, x, y, theta = self._unpack(_HEAD)
        robot_id = self._name()
        goal = self._unpack(_GOAL) if flags & _HAS_GOAL else None
        known = tuple((self._name(), self._unpack(_KNOWN)[0]) for _ in range(self._byte()))
        patches = tuple(self._patch(known) for _ in range(self._byte()))
        if self._at != len(self._raw):
            raise TeamMessageError("there is more in it than a message")
        if not all(map(isfinite, (x, y, theta))):
            raise TeamMessageError("its pose is not finite")
        pose = Pose2(x, y, theta)
        return TeamMessage(
            robot_id,
            number,
            stamp_s,
            pose,
            goal,
            known,
            patches,
            bool(flags & _STATION),
            bool(flags & _BUSY),
        )

    def _patch(self, known: tuple[tuple[str, int], ...]) -> Patch:
        place, since, until, count = self._unpack(_PATCH)
        tiles = []
        for _ in range(count):
            row, column, version = self._unpack(_TILE)
            tiles.append(Tile(row, column, version, self._take(TILE_BYTES)))
        return Patch(known[place][0], since, until, tuple(tiles))

    def _unpack(self, form: struct.Struct) -> tuple[Any, ...]:
        return form.unpack(self._take(form.size))

    def _byte(self) -> int:
        return self._take(1)[0]

    def _name(self) -> str:
        return self._take(self._byte()).decode()

    def _take(self, count: int) -> bytes:
        part = self._raw[self._at : self._at + count]
        if len(part) < count:
            raise IndexError
        self._at += count
        return part


def _named(name: str) -> bytes:
    data = name.encode()
    return bytes([len(data)]) + data


def _check(message: TeamMessage) -> None:
    """Refuse what a message may not hold; the same for those made here and those heard."""
    pose = message.pose
    places = (pose.x, pose.y, *(message.goal_m or ()))
    if not all(map(isfinite, (*places, pose.theta, message.stamp_s))):
        raise TeamMessageError("it holds a number that is not finite")
    if max(map(abs, places)) > _MAX_M:
        raise TeamMessageError("it speaks of a place that is too far away")
    names = [name for name, _ in message.known]
    if len(names) > MAX_ROBOTS or len(set(names)) < len(names):
        raise TeamMessageError("it names too many robots, or one of them twice")
    for name in (message.robot_id, *names):
        if not 0 < len(name.encode()) <= _MAX_ID_BYTES:
            raise TeamMessageError("it names a robot without a name, or with one that is too long")
    origins = [patch.origin for patch in message.patches]
    if len(set(origins)) < len(origins) or not set(origins) <= set(names):
        raise TeamMessageError("it tells of somebody's ground twice, or of a robot that it does not name")
    if sum(len(patch.tiles) for patch in message.patches) > MAX_TILES:
        raise TeamMessageError(f"it holds more than {MAX_TILES} tiles")
    numbers = [message.number, *(version for _, version in message.known)]
    for patch in message.patches:
        numbers += [patch.since, patch.until]
        for tile in patch.tiles:
            if len(tile.cells) != TILE_BYTES or not patch.since < tile.version <= patch.until:
                raise TeamMessageError("a tile in it is of another size or time than it says")
            if max(abs(tile.row), abs(tile.column)) > MAX_TILE:
                raise TeamMessageError("a tile in it is too far away")
    if not all(0 <= number <= _MAX_NUMBER for number in numbers):
        raise TeamMessageError("it holds a number that is out of range")
