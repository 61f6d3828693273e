"""Reading and writing tags through a reader: what any reader has to offer, and one that is simulated."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from robots.tags.chip import Chip, Layout, format_chip, read_chip
from robots.tags.record import Record, RecordError, content_bytes, newest, plan_writes, seal


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
class TagContent:
    """What a tag holds: link, our record (None where there is none that is whole), room for content."""

    link: str | None
    record: Record | None
    error: str | None  # why there is no record
    room_bytes: int


def read_tag(reader: TagReader, tag_id: str, key: bytes) -> TagContent:
    """Read a tag.

    Raises:
        ChipError: it was never formatted.
        TagGoneError: it left the field.
    """
    memory = reader.read()
    link, layout = read_chip(memory)
    room = content_bytes(reader.chip, layout)
    try:
        record, _ = newest(_payload(memory, layout), reader.chip, layout, tag_id, key)
    except RecordError as error:
        return TagContent(link, None, str(error), room)
    return TagContent(link, record, None, room)


def write_tag(reader: TagReader, tag_id: str, key: bytes, content: bytes) -> None:
    """Write content into a formatted tag, as the next revision.

    Raises:
        ChipError: it was never formatted.
        TagGoneError: it left the field: it holds the old content, the new or, if small, a damaged record.
        ValueError: the content is longer than the room for it.
    """
    memory = reader.read()
    _, layout = read_chip(memory)
    try:
        known, half = newest(_payload(memory, layout), reader.chip, layout, tag_id, key)
        revision, over = known.revision + 1, half
    except RecordError:
        revision, over = 0, None
    record = seal(content, revision, tag_id, key)
    for at, block in plan_writes(memory, reader.chip, layout, record, over):
        reader.write(at, block)


class SimulatedTag:
    """A chip in memory and a reader over it, from whose field it can be taken after some blocks."""

    def __init__(self, chip: Chip, link: str) -> None:
        self._chip = chip
        self._memory = bytearray(format_chip(chip, link)[0])
        self.blocks_left: int | None = None  # to be written before the tag is out of the field; None: stays
        self.blocks_written = 0

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
