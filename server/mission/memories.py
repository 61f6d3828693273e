"""What is known of the tags' memories: everything that was read or written, merged."""

from __future__ import annotations

import time
from collections.abc import Iterable

import structlog

from db.errors import DatabaseError
from db.store import Store
from robots.tags.memory import TagMemoryError, decode_memory, merge_bytes
from robots.types import Observation, TagWrite
from server.mission.events import Events

log = structlog.get_logger()


class Memories:
    """Tag memories by tag id."""

    def __init__(self, store: Store, mission_id: str, events: Events) -> None:
        self._store = store
        self._mission_id = mission_id
        self._events = events
        self._unreadable: dict[str, bytes] = {}  # what was told of already, by tag

    async def of(self, tag_id: str) -> bytes | None:
        """Return the bytes of a tag's memory, None when nothing was ever read or written."""
        return await self._store.tags.memory_of(self._mission_id, tag_id)

    async def merge(self, tag_id: str, memory: bytes, by: str) -> bytes:
        """Merge bytes into what is known of a tag's memory and return the result.

        Raises:
            TagMemoryError: the bytes are no memory.
        """
        decode_memory(memory)
        return await self._store.tags.merge_memory(
            self._mission_id, tag_id, memory, merge_bytes, by=by, unix_s=time.time()
        )

    async def keep_read(self, robot_id: str, observations: Iterable[Observation]) -> None:
        """Merge what a robot read; bytes that make no sense are told of once."""
        read = {(s.tag_id, s.memory) for o in observations for s in o.tag_sightings if s.memory}
        for tag_id, memory in sorted(read):
            try:
                await self.merge(tag_id, memory, robot_id)
            except TagMemoryError as error:
                if self._unreadable.get(tag_id) != memory:
                    self._unreadable[tag_id] = memory
                    text = f"{robot_id} read tag {tag_id}, but its memory makes no sense: {error}."
                    await self._events.tell("tag_unreadable", text, robot_id, "warning")
            except DatabaseError as error:  # the log has it
                log.error("a tag memory could not be saved", tag_id=tag_id, reason=str(error))

    async def keep_written(self, robot_id: str, writes: Iterable[TagWrite]) -> None:
        """Merge what an agent had written into tags."""
        for write in writes:
            try:
                await self.merge(write.tag_id, write.memory, robot_id)
            except DatabaseError as error:  # the tag has it
                log.error("a tag memory could not be saved", tag_id=write.tag_id, reason=str(error))
