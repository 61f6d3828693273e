"""What is known of the tags' memories: everything that was read or written, merged."""

from __future__ import annotations

import time
from collections.abc import Iterable
from typing import Any

import structlog

from db.errors import DatabaseError
from db.store import Store
from robots.tags.content import decode_memory, encode_memory, merge_bytes
from robots.tags.describe import describe, sentences
from robots.tags.memory import TagMemory, TagMemoryError
from robots.tags.record import is_sealed, seal, split
from robots.tags.sealed import open_memory
from robots.types import Observation, TagWrite
from server.mission.alerts import Alerts
from server.mission.chip_notes import ChipNotes
from server.mission.events import Events
from server.mission.told_victims import ToldVictims

log = structlog.get_logger()


class ForeignSealError(TagMemoryError):
    """A memory bears a seal that is not this mission's over this tag."""


class Memories:
    """Tag memories by tag id; ``key`` is the mission's, which seals them."""

    def __init__(
        self,
        store: Store,
        mission_id: str,
        key: bytes,
        events: Events,
        alerts: Alerts,
        chip_notes: ChipNotes,
        victims: ToldVictims,
    ) -> None:
        self._store = store
        self._mission_id = mission_id
        self._key = key
        self._events = events
        self._alerts = alerts
        self._chip_notes = chip_notes
        self._victims = victims
        self._told: dict[str, bytes] = {}  # memories that were not kept, by tag: what was told of already

    async def of(self, tag_id: str) -> bytes | None:
        """Return the record to write into a tag; None when nothing was ever read or written."""
        version, content = await self._store.tags.memory_of(self._mission_id, tag_id)
        return seal(content, version, tag_id, self._key) if version else None

    async def told(self, tag_id: str) -> tuple[dict[str, Any], list[str]] | None:
        """Return what a tag's memory says, as JSON holds it and in sentences; None where nothing is known."""
        version, content = await self._store.tags.memory_of(self._mission_id, tag_id)
        if not version:
            return None
        described = describe(decode_memory(content))
        return described, sentences(described)

    async def merge(self, tag_id: str, records: bytes, by: str) -> bytes:
        """Merge what a reader got from a tag into what is known of it; return the record of the result.

        Raises:
            TagMemoryError: the bytes are no memory, or without the mission's seal.
        """
        memory = self._believed(tag_id, records)
        await self._merge(tag_id, memory, by)
        await self._victims.hear(tag_id, memory.victims)
        return await self.of(tag_id) or b""

    async def keep_read(self, robot_id: str, observations: Iterable[Observation]) -> None:
        """Merge what a robot read; bytes that make no sense or are a stranger's are told of once."""
        read = {(s.tag_id, s.memory) for o in observations for s in o.tag_sightings if s.memory}
        for tag_id, records in sorted(read):
            try:
                await self._chip_notes.take(tag_id, records)
                whole = split(records)
                if not whole or any(is_sealed(record) for record in whole):
                    memory = self._believed(tag_id, records)
                    await self._merge(tag_id, memory, robot_id)
                    await self._victims.hear(tag_id, memory.victims)
            except ForeignSealError as error:
                text = f"Tag {tag_id} may be forged or a copy: {error}. Do not go by what it says."
                await self._alerts.raise_(
                    "tag",
                    f"{tag_id} seal",
                    text,
                    "warning",
                    event="tag_unreadable",
                    robot_id=robot_id,
                    tag_id=tag_id,
                )
            except TagMemoryError as error:
                if self._told.get(tag_id) != records:
                    self._told[tag_id] = records
                    text = f"{robot_id} read tag {tag_id}, but its memory does not count: {error}."
                    await self._events.tell("tag_unreadable", text, robot_id, "warning")
            except DatabaseError as error:  # the log has it
                log.error("a tag memory could not be saved", tag_id=tag_id, reason=str(error))

    async def keep_written(self, robot_id: str, writes: Iterable[TagWrite]) -> None:
        """Merge what an agent had written into tags."""
        for write in writes:
            try:
                await self._merge(write.tag_id, self._believed(write.tag_id, write.memory), robot_id)
            except (DatabaseError, TagMemoryError) as error:  # the tag has it
                log.error("a tag memory could not be saved", tag_id=write.tag_id, reason=str(error))

    def _believed(self, tag_id: str, records: bytes) -> TagMemory:
        if not records:
            raise TagMemoryError("there is nothing in it")
        says = open_memory(records, tag_id, self._key)
        if not says.trusted:
            raise ForeignSealError(
                "it bears another seal than this mission's, so it is a stranger's or forged"
            )
        return says.memory.uncut()  # here is room for all

    async def _merge(self, tag_id: str, memory: TagMemory, by: str) -> None:
        content = encode_memory(memory)
        await self._store.tags.merge_memory(
            self._mission_id, tag_id, content, merge_bytes, by=by, unix_s=time.time()
        )
