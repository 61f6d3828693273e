"""Messages between the server and its worker processes: a kind and a few byte strings in one frame.

Frame: u32 length of the rest, u8 kind, u16 number of parts, u32 length of each part, the parts.
Little-endian.
"""

from __future__ import annotations

import socket
import struct
from collections.abc import Sequence
from enum import IntEnum

_LENGTH = struct.Struct("<I")
_HEAD = struct.Struct("<BH")


class Kind(IntEnum):
    """What a frame asks for or answers."""

    BEGIN = 1
    RESTORE = 2
    HANDLE = 3
    SNAPSHOT = 4
    REPORT = 5
    ADD_ROBOT = 6
    PUT = 7
    SOLVE = 8
    DONE = 20
    FAILED = 21


Frame = tuple[Kind, list[bytes]]


def pack(kind: Kind, parts: Sequence[bytes] = ()) -> bytes:
    """Return the bytes of a frame."""
    lengths = struct.pack(f"<{len(parts)}I", *map(len, parts))
    rest = b"".join((_HEAD.pack(kind, len(parts)), lengths, *parts))
    return _LENGTH.pack(len(rest)) + rest


def take(buffer: bytearray) -> Frame | None:
    """Remove the first whole frame from the buffer and return it, None while it is incomplete."""
    if len(buffer) < _LENGTH.size:
        return None
    (length,) = _LENGTH.unpack_from(buffer)
    end = _LENGTH.size + length
    if len(buffer) < end:
        return None
    frame = _unpack(bytes(memoryview(buffer)[_LENGTH.size : end]))
    del buffer[:end]
    return frame


def receive(connection: socket.socket) -> Frame | None:
    """Wait for a frame on a blocking socket; None when the other side is gone."""
    head = _receive_exactly(connection, _LENGTH.size)
    if head is None:
        return None
    rest = _receive_exactly(connection, _LENGTH.unpack(head)[0])
    return None if rest is None else _unpack(rest)


def _unpack(rest: bytes) -> Frame:
    kind, count = _HEAD.unpack_from(rest)
    lengths = struct.unpack_from(f"<{count}I", rest, _HEAD.size)
    parts, start = [], _HEAD.size + 4 * count
    for length in lengths:
        parts.append(rest[start : start + length])
        start += length
    return Kind(kind), parts


def _receive_exactly(connection: socket.socket, count: int) -> bytes | None:
    data = bytearray(count)
    view = memoryview(data)
    while view:
        read = connection.recv_into(view)
        if read == 0:
            return None
        view = view[read:]
    return bytes(data)
