"""Reading and writing tags through a reader: what any reader has to offer, and one that is simulated."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from robots.tags.chip import Chip, Layout, format_chip, read_chip
from robots.tags.record import all_records, content_bytes, halves, plan_writes


class TagGoneError(OSError):
    """The tag left the reader's field."""


class TagReader(Protocol):
    """A reader with one tag in its field."""

    @property
    def chip(self) -> Chip:
        """The kind of chip."""

    def read(self) -> bytes:
        """Return the whole user memory.

        Raises:
            TagGoneError: the tag left the field.
        """

    def write(self, at: int, block: bytes) -> None:
        """Write one block of the chip from byte ``at`` on.

        Raises:
            TagGoneError: the tag left the field; the block was written whole or not at all.
        """


@dataclass(frozen=True, slots=True)
class TagImage:
    """What a tag holds: its link, our records, the newest first, and how much content there is room for.

    ``damaged``: there is something where the newest record should be, but no record is whole.
    """

    link: str | None
    records: tuple[bytes, ...]
    room_bytes: int
    damaged: bool


def read_tag(reader: TagReader) -> TagImage:
    """Read a tag.

    Raises:
        ChipError: it was never formatted.
        TagGoneError: it left the field.
    """
    memory = reader.read()
    link, layout = read_chip(memory)
    payload = _payload(memory, layout)
    records = all_records(payload, reader.chip, layout)
    room = content_bytes(reader.chip, layout)
    return TagImage(link, records, room, not records and any(payload))


def write_tag(reader: TagReader, record: bytes) -> None:
    """Write a record into a formatted tag, over the older of its records where it has room for two.

    Raises:
        ChipError: it was never formatted.
        TagGoneError: it left the field: it holds the old record, the new or, if small, a damaged one.
        ValueError: the record is longer than the room for it.
    """
    memory = reader.read()
    _, layout = read_chip(memory)
    found = halves(_payload(memory, layout), reader.chip, layout)
    for at, block in plan_writes(memory, reader.chip, layout, record, found[0][0] if found else None):
        reader.write(at, block)


class SimulatedTag:
    """A chip in memory and a reader over it, from whose field it can be taken after some blocks."""

    def __init__(self, chip: Chip, memory: bytes) -> None:
        self._chip = chip
        self._memory = bytearray(memory)
        self.blocks_left: int | None = None  # to be written before the tag is out of the field; None: stays
        self.blocks_written = 0

    @classmethod
    def formatted(cls, chip: Chip, link: str) -> SimulatedTag:
        """Return a tag with a link and no record yet. Raises ChipError when the link leaves no room."""
        return cls(chip, format_chip(chip, link)[0])

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, SimulatedTag):
            return NotImplemented
        return self._chip == other._chip and self._memory == other._memory

    __hash__ = None  # type: ignore[assignment]  # it changes

    @property
    def chip(self) -> Chip:
        """The kind of chip."""
        return self._chip

    def read(self) -> bytes:
        """Return the whole user memory."""
        return bytes(self._memory)

    def write(self, at: int, block: bytes) -> None:
        """Write one block.

        Raises:
            TagGoneError: as many blocks were written as the test allowed.
            ValueError: no block begins there, or it is of another length.
        """
        size = self._chip.block_bytes
        if at % size or len(block) != size or at + size > len(self._memory):
            raise ValueError(f"{len(block)} bytes at {at} are no block of this chip")
        if self.blocks_left is not None:
            if self.blocks_left == 0:
                raise TagGoneError("the tag left the reader's field; hold it still and write again")
            self.blocks_left -= 1
        self._memory[at : at + size] = block
        self.blocks_written += 1


def _payload(memory: bytes, layout: Layout) -> bytes:
    return memory[layout.start : layout.start + layout.size]
