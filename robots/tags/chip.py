"""The chips of tags: how many bytes each keeps, and how a link and our record share them.

A chip's user memory begins with a capability container where its type keeps it there, then one NDEF message
in a TLV: first a URI record, which any phone opens on touch, then ours, an external record of type
``u.io:t``. Both have a fixed length once the chip is formatted, so a write changes bytes of our record alone.
Sources: NFC Forum Type 2 and Type 5 Tag, NDEF; NXP and ST data sheets for the capacities.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

RECORD_TYPE = b"u.io:t"
_URI, _EXTERNAL = 0x01, 0x04  # type name formats: well known, external
_BEGIN, _END, _SHORT, _TNF = 0x80, 0x40, 0x10, 0x07
_NDEF_TLV, _NULL_TLV, _TERMINATOR = 0x03, 0x00, 0xFE
_PREFIXES = ("", "http://www.", "https://www.", "http://", "https://")  # NFC Forum URI record, table 3


class ChipError(ValueError):
    """A chip is too small for what it is to hold, or its bytes are no formatted chip."""


@dataclass(frozen=True, slots=True)
class Chip:
    """A kind of chip: ``user_bytes`` of memory; blocks of ``block_bytes`` are written whole or not at all."""

    name: str
    bits: int
    kind: Literal["type 2", "type 5"]
    block_bytes: int = 4

    @property
    def user_bytes(self) -> int:
        """Bytes that can be written."""
        return self.bits // 8

    @property
    def container(self) -> bytes:
        """The capability container at the beginning of the user memory; type 2 keeps it elsewhere."""
        if self.kind == "type 2":
            return b""
        eighths = (self.user_bytes - 4) // 8
        if eighths <= 0xFF:
            return bytes([0xE1, 0x40, eighths, 0x00])
        eighths = (self.user_bytes - 8) // 8
        return bytes([0xE2, 0x40, 0x00, 0x01, 0x00, 0x00]) + eighths.to_bytes(2, "big")

    @property
    def ndef_bytes(self) -> int:
        """Bytes for TLVs: a type 5 container counts them in eights."""
        room = self.user_bytes - len(self.container)
        return room if self.kind == "type 2" else room // 8 * 8


CHIPS = {
    chip.bits: chip
    for chip in (
        Chip("512 bit", 512, "type 5"),
        Chip("ICODE SLIX", 896, "type 5"),
        Chip("NTAG213", 1152, "type 2"),
        Chip("2,048 bit", 2048, "type 5"),
        Chip("NTAG215", 4032, "type 2"),
        Chip("NTAG216", 7104, "type 2"),
        Chip("8 kbit", 8192, "type 5"),
        Chip("ST25DV64K", 65536, "type 5"),
    )
}


def chip_of(bits: int) -> Chip:
    """Return the chip of a capacity in bits.

    Raises:
        ChipError: there is none.
    """
    if bits not in CHIPS:
        raise ChipError(f"no chip has {bits} bits; known are {', '.join(map(str, CHIPS))}")
    return CHIPS[bits]


@dataclass(frozen=True, slots=True)
class Layout:
    """Where our record's payload lies in a formatted chip: ``size`` bytes from ``start`` on."""

    start: int
    size: int


def format_chip(chip: Chip, link: str) -> tuple[bytes, Layout]:
    """Return the bytes of a chip with a link and an empty record, and where the record's payload lies.

    Raises:
        ChipError: the link leaves no room, or is not ASCII.
    """
    uri = _uri_record(link)
    for overhead in (2, 4):  # of the message's TLV: one length byte, or three
        message = chip.ndef_bytes - overhead - 1  # the terminator
        if (message <= 0xFE) == (overhead == 2):
            break
    else:
        message, overhead = 0xFE, 2  # between the two: a byte or two stay unused
    for head in (3, 6):  # of our record: one byte for the length of its payload, or four
        size = message - len(uri) - head - len(RECORD_TYPE)
        if (size <= 0xFF) == (head == 3):
            break
    else:
        size, head = 0xFF, 3
        message = len(uri) + head + len(RECORD_TYPE) + size
    if size < 1:
        raise ChipError(f"the link {link} leaves no room in {chip.bits} bits; make it shorter")
    flags = _END | _EXTERNAL | (_SHORT if head == 3 else 0)
    length = bytes([size]) if head == 3 else size.to_bytes(4, "big")
    record = bytes([flags, len(RECORD_TYPE)]) + length + RECORD_TYPE
    tlv = bytes([_NDEF_TLV]) + (bytes([message]) if overhead == 2 else b"\xff" + message.to_bytes(2, "big"))
    before = chip.container + tlv + uri + record
    data = before + bytes(size) + bytes([_TERMINATOR])
    return data.ljust(chip.user_bytes, b"\0"), Layout(len(before), size)


def read_chip(data: bytes) -> tuple[str | None, Layout]:
    """Return the link of a formatted chip, None where it has none, and where our record's payload lies.

    ``data`` may come from any tag.

    Raises:
        ChipError: there is no NDEF message with our record in it.
    """
    link, at, end = None, *_message(data)
    while at < end:
        flags = _byte(data, at)
        type_length = _byte(data, at + 1)
        head = 3 if flags & _SHORT else 6
        size = int.from_bytes(data[at + 2 : at + head], "big")
        if flags & 0x08:  # an id's length follows
            head, id_length = head + 1, _byte(data, at + head)
        else:
            id_length = 0
        name = data[at + head : at + head + type_length]
        start = at + head + type_length + id_length
        if start + size > end:
            raise ChipError("the tag is damaged: a record runs beyond its message")
        if flags & _TNF == _URI and name == b"U" and link is None:
            link = _link(data[start : start + size])
        if flags & _TNF == _EXTERNAL and name == RECORD_TYPE:
            return link, Layout(start, size)
        at = start + size
        if flags & _END:
            break
    raise ChipError("the tag holds no record of ours: it has to be formatted first")


def _message(data: bytes) -> tuple[int, int]:
    """Return where the NDEF message begins and ends."""
    at = {0xE1: 4, 0xE2: 8}.get(_byte(data, 0), 0)
    while True:
        kind = _byte(data, at)
        if kind == _NULL_TLV:
            at += 1
            continue
        if kind == _TERMINATOR:
            raise ChipError("the tag is empty: it has to be formatted first")
        length, at = _byte(data, at + 1), at + 2
        if length == 0xFF:
            length, at = int.from_bytes(data[at : at + 2], "big"), at + 2
        if at + length > len(data):
            raise ChipError("the tag is damaged: its message runs beyond its end")
        if kind == _NDEF_TLV:
            return at, at + length
        at += length


def _uri_record(link: str) -> bytes:
    code = max(
        (k for k, prefix in enumerate(_PREFIXES) if link.startswith(prefix)), key=lambda k: len(_PREFIXES[k])
    )
    try:
        rest = link[len(_PREFIXES[code]) :].encode("ascii")
    except UnicodeEncodeError as error:
        raise ChipError(f"the link {link} has to be ASCII") from error
    if len(rest) > 0xFE:
        raise ChipError("the link is longer than 254 bytes; make it shorter")
    return bytes([_BEGIN | _SHORT | _URI, 1, len(rest) + 1]) + b"U" + bytes([code]) + rest


def _link(payload: bytes) -> str | None:
    if not payload or payload[0] >= len(_PREFIXES):
        return None
    return _PREFIXES[payload[0]] + payload[1:].decode("ascii", "replace")


def _byte(data: bytes, at: int) -> int:
    if at >= len(data):
        raise ChipError("the tag is damaged or empty: its bytes end too early")
    return data[at]
