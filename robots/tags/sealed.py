"""A tag's memory under the mission's seal, as it goes to and from a reader."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache, reduce

from robots.tags.content import decode_memory, encode_memory
from robots.tags.marks import Note
from robots.tags.memory import TagMemory, TagMemoryError
from robots.tags.record import OVERHEAD, is_newer, revision_of, seal, split, unseal


@dataclass(frozen=True, slots=True)
class TagSays:
    """The newest memory in a tag and the revision after all it holds.

    ``trusted``: the mission's seal is on it; what a stranger wrote is for people to look at.
    """

    memory: TagMemory
    next_revision: int
    trusted: bool


NOTHING = TagSays(TagMemory.empty(), 0, True)
_REMEMBERED = 256  # a tag is asked about several times for one reading, and says the same for long


@lru_cache(maxsize=_REMEMBERED)
def open_memory(data: bytes, tag_id: str, key: bytes) -> TagSays:
    """Return what a reader got from a tag: records one after the other; no bytes are an empty memory.

    A record of the mission counts before a stranger's, however new that is.

    Raises:
        TagMemoryError: no record is whole, or the newest holds no memory.
    """
    if not data:
        return NOTHING
    records = split(data)
    if not records:
        raise TagMemoryError("the tag's memory is damaged or half written; read it again")
    believed = [record for record in records if unseal(record, tag_id, key).trusted]
    content = unseal(_newest(believed or records), tag_id, key).content
    return TagSays(decode_memory(content), revision_of(_newest(records)) + 1, bool(believed))


def unsealed_notes(data: bytes, tag_id: str, key: bytes) -> tuple[Note, ...]:
    """Return the notes in records without the mission's seal, as phones leave them: for people to read."""
    found: dict[Note, None] = {}
    for record in split(data):
        said = unseal(record, tag_id, key)
        if not said.trusted:
            with suppress(TagMemoryError):
                found |= dict.fromkeys(decode_memory(said.content).notes.notes)
    return tuple(found)


def close_memory(memory: TagMemory, revision: int, tag_id: str, key: bytes, room_bytes: int) -> bytes:
    """Return the record to write into a tag with room for so many bytes of content."""
    return seal(encode_memory(memory.fit(room_bytes)), revision, tag_id, key)


def _newest(records: Sequence[bytes]) -> bytes:
    return reduce(lambda a, b: b if is_newer(revision_of(b), revision_of(a)) else a, records)


def room_in(bits: int) -> int:
    """Return the bytes of content of a tag that holds a record and nothing else."""
    return max(0, bits // 8 - OVERHEAD)
