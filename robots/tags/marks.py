"""What stands in a tag beside windows and maps: victims, notes of people, and who passed with which goal.

Each is a set that merges: of one victim and one passer the greatest entry counts, notes only add up. Of
victims and passers, whose entries have one length, a small chip keeps the greatest. Notes have any length:
the newest have room, and the number of the newest that had none is kept, for older ones to go wherever they
meet it; without it the order of visits would decide what stays.
Places are metres north and west of the tag.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TypeVar
from zlib import crc32

MAX_MARKS, MAX_NOTES = 255, 64
MAX_NAME, MAX_TEXT = 16, 120  # bytes
_VICTIM, _PASS = struct.Struct(">HhhBH"), struct.Struct(">HBBbb")
_NOTE = struct.Struct(">H")
_DM, _HALF_M = 0.1, 0.5
_GONE = struct.Struct(">HH")


class MarkError(ValueError):
    """The bytes are no marks, or a mark is longer than a tag takes."""


def key_of(name: str) -> int:
    """Return the 16 bits by which tags know a robot or a victim."""
    return crc32(name.encode()) & 0xFFFF


@dataclass(frozen=True, slots=True, order=True)
class VictimMark:
    """A victim: ``confidence`` 0..255; ``seen_min`` in minutes, for people to read: clocks may disagree."""

    confidence: int
    seen_min: int
    north_dm: int
    west_dm: int
    key: int


@dataclass(frozen=True, slots=True, order=True)
class Pass:
    """How often a robot passed here, and where it went then: ``goal`` in half metres, (0, 0) for nowhere.

    ``serial``: how often it changed its mind while it passed.
    """

    count: int
    serial: int
    north: int
    west: int
    key: int

    @property
    def goal_m(self) -> tuple[float, float] | None:
        """The goal in metres north and west of the tag."""
        return (self.north * _HALF_M, self.west * _HALF_M) if self.north or self.west else None


@dataclass(frozen=True, slots=True, order=True)
class Note:
    """A text somebody left; ``number`` one more than that of any note its writer found there."""

    number: int
    author: str
    text: str

    @property
    def order(self) -> tuple[int, int]:
        """What tells notes apart and which is newer, in four bytes."""
        return self.number, key_of(f"{self.author}\0{self.text}")


@dataclass(frozen=True, slots=True)
class Notes:
    """Notes, the newest first; all of an order up to ``gone`` had no room."""

    notes: tuple[Note, ...] = ()
    gone: tuple[int, int] | None = None

    def merge(self, other: Notes) -> Notes:
        """Return all notes of both that are newer than what either let go."""
        gone = max((each.gone for each in (self, other) if each.gone is not None), default=None)
        return Notes(_newest((*self.notes, *other.notes), gone), gone).fit(1 << 16)

    def fit(self, room_bytes: int) -> Notes:
        """Return the newest that have room."""
        gone, left = self.gone, room_bytes - 2 - _GONE.size
        for k, note in enumerate(self.notes):
            left -= _note_bytes(note)
            if left < 0 or k == MAX_NOTES:
                gone = note.order if gone is None else max(gone, note.order)
                break
        return Notes(_newest(self.notes, gone), gone)

    def cost(self, room_bytes: int) -> int:
        """Return the bytes to reserve: all the room once a note had none, which is never taken back."""
        if self.gone is not None:
            return room_bytes
        return 2 + _GONE.size + sum(map(_note_bytes, self.notes)) if self.notes else 0


Mark = TypeVar("Mark", VictimMark, Pass)


def goal_mark(robot_id: str, count: int, serial: int, north_m: float, west_m: float) -> Pass:
    """Return the entry of a robot that goes to a place relative to the tag."""
    north, west = (max(-127, min(127, round(value / _HALF_M))) for value in (north_m, west_m))
    return Pass(count, serial, north, west, key_of(robot_id))


def victim_mark(name: str, confidence: float, seen_s: float, north_m: float, west_m: float) -> VictimMark:
    """Return the entry of a victim at a place relative to the tag; ``confidence`` 0..1."""
    north, west = (max(-32767, min(32767, round(value / _DM))) for value in (north_m, west_m))
    share = round(255 * max(0.0, min(1.0, confidence)))
    return VictimMark(share, int(seen_s // 60) % 65536, north, west, key_of(name))


def note_of(author: str, text: str, notes: Notes) -> Note:
    """Return a new note for a tag that holds these; its author and text are cut to what a tag takes."""
    newest = [note.number for note in notes.notes] + ([notes.gone[0]] if notes.gone else [])
    return Note(min(max(newest, default=0) + 1, 65535), _cut(author, MAX_NAME), _cut(text, MAX_TEXT))


def merged_marks(*marks: Mark) -> tuple[Mark, ...]:
    """Return the greatest entry of each key, the greatest first, and no more than 255."""
    greatest: dict[int, Mark] = {}
    for each in marks:
        if each.key not in greatest or greatest[each.key] < each:
            greatest[each.key] = each
    return tuple(sorted(greatest.values(), reverse=True)[:MAX_MARKS])


def victims_in(room_bytes: int) -> int:
    """Return how many victims have room."""
    return (room_bytes - 1) // _VICTIM.size


def passes_in(room_bytes: int) -> int:
    """Return how many passers have room."""
    return (room_bytes - 1) // _PASS.size


def pack_victims(victims: Sequence[VictimMark]) -> bytes:
    """Return one byte for their number and nine for each."""
    return _packed(_VICTIM.pack(v.key, v.north_dm, v.west_dm, v.confidence, v.seen_min) for v in victims)


def pack_passes(passes: Sequence[Pass]) -> bytes:
    """Return one byte for their number and six for each."""
    return _packed(_PASS.pack(p.key, p.count, p.serial, p.north, p.west) for p in passes)


def pack_notes(notes: Notes) -> bytes:
    """Return the bytes of notes. Raises MarkError when a name or a text is too long."""
    parts = [bytes([len(notes.notes), notes.gone is not None]), _GONE.pack(*(notes.gone or (0, 0)))]
    for note in notes.notes:
        author, text = note.author.encode(), note.text.encode()
        if len(author) > MAX_NAME or len(text) > MAX_TEXT:
            raise MarkError(f"a note has at most {MAX_NAME} bytes of name and {MAX_TEXT} of text")
        parts += [_NOTE.pack(note.number), bytes([len(author)]), author, bytes([len(text)]), text]
    return b"".join(parts)


def unpack_victims(data: bytes) -> tuple[tuple[VictimMark, ...], int]:
    """Return victims and how many bytes they took. Raises MarkError when they are damaged."""
    found, end = _unpacked(data, _VICTIM)
    victims = tuple(VictimMark(confidence, seen, n, w, key) for key, n, w, confidence, seen in found)
    return _ordered(victims), end


def unpack_passes(data: bytes) -> tuple[tuple[Pass, ...], int]:
    """Return passers and how many bytes they took. Raises MarkError when they are damaged."""
    found, end = _unpacked(data, _PASS)
    return _ordered(tuple(Pass(count, serial, n, w, key) for key, count, serial, n, w in found)), end


def unpack_notes(data: bytes) -> tuple[Notes, int]:
    """Return notes and how many bytes they took. Raises MarkError when they are damaged."""
    try:
        (count, cut), at, notes = data[:2], 2 + _GONE.size, []
        gone = _GONE.unpack_from(data, 2) if cut == 1 else None
        for _ in range(count):
            (number,) = _NOTE.unpack_from(data, at)
            author, at = _text(data, at + _NOTE.size, MAX_NAME)
            text, at = _text(data, at, MAX_TEXT)
            notes.append(Note(number, author, text))
    except (ValueError, IndexError, struct.error) as error:
        raise MarkError("its notes are cut off or damaged") from error
    kept = _newest(tuple(notes), gone)
    if cut > 1 or count > MAX_NOTES or kept != tuple(notes):
        raise MarkError("its notes are damaged")
    return Notes(kept, gone), at


def _newest(notes: Iterable[Note], gone: tuple[int, int] | None) -> tuple[Note, ...]:
    greatest: dict[tuple[int, int], Note] = {}
    for note in notes:
        if gone is None or note.order > gone:
            greatest[note.order] = max(note, greatest.get(note.order, note))
    return tuple(greatest[order] for order in sorted(greatest, reverse=True))


def _note_bytes(note: Note) -> int:
    return _NOTE.size + 2 + len(note.author.encode()) + len(note.text.encode())


def _packed(entries: Iterable[bytes]) -> bytes:
    found = list(entries)
    return bytes([len(found)]) + b"".join(found)


def _unpacked(data: bytes, entry: struct.Struct) -> tuple[list[tuple[int, ...]], int]:
    end = 1 + (data[0] if data else 0) * entry.size
    if end == 1 or len(data) < end:
        raise MarkError("its marks are cut off")
    return list(entry.iter_unpack(data[1:end])), end


def _ordered(marks: tuple[Mark, ...]) -> tuple[Mark, ...]:
    if merged_marks(*marks) != marks:
        raise MarkError("its marks are out of order")
    return marks


def _text(data: bytes, at: int, most: int) -> tuple[str, int]:
    end = at + 1 + data[at]
    if end > len(data) or data[at] > most:
        raise MarkError("a text is cut off")
    return data[at + 1 : end].decode(), end


def _cut(text: str, size: int) -> str:
    return text.encode()[:size].decode("utf-8", "ignore")
