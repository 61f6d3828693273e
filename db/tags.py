"""Tags: where the team map places them, and every version of their memory."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from sqlalchemy import Connection, insert, select

from db.engine import Database, upsert
from db.records import PointRecord, TagRecord
from db.tables import tag_memories, tags

Merge = Callable[[bytes, bytes], bytes]


class TagStore:
    """Tags of a mission by id."""

    def __init__(self, database: Database) -> None:
        self._database = database

    async def record_tags(self, mission_id: str, records: Sequence[TagRecord]) -> None:
        """Keep where tags are; the latest replaces the earlier."""
        rows = [
            {
                "mission_id": mission_id,
                "tag_id": record.tag_id,
                **place_columns(record.place),
                "sightings": record.sightings,
                "robots": list(record.robots),
                "state": record.state,
                "notice": record.notice,
            }
            for record in records
        ]
        await self._database.write(lambda c: upsert(c, tags, rows))

    async def tags_of(self, mission_id: str) -> list[TagRecord]:
        """Return the tags of a mission by id."""

        def query(connection: Connection) -> list[TagRecord]:
            rows = connection.execute(
                select(tags).where(tags.c.mission_id == mission_id).order_by(tags.c.tag_id)
            )
            return [
                TagRecord(r.tag_id, place_of(r), r.sightings, tuple(r.robots), r.state, r.notice)
                for r in rows
            ]

        return await self._database.read(query)

    async def merge_memory(
        self, mission_id: str, tag_id: str, memory: bytes, merge: Merge, *, by: str, unix_s: float
    ) -> bytes:
        """Merge bytes into a tag's memory and return the result; a new version is kept when it differs."""

        def work(connection: Connection) -> bytes:
            version, known = _latest(connection, mission_id, tag_id)
            merged = memory if version == 0 else merge(known, memory)
            if version == 0 or merged != known:
                connection.execute(
                    insert(tag_memories).values(
                        mission_id=mission_id,
                        tag_id=tag_id,
                        version=version + 1,
                        memory=merged,
                        written_unix_s=unix_s,
                        by=by,
                    )
                )
            return merged

        return await self._database.write(work)

    async def memory_of(self, mission_id: str, tag_id: str) -> tuple[int, bytes]:
        """Return version and memory of a tag as it was last merged; version 0 where nothing is known."""
        return await self._database.read(lambda c: _latest(c, mission_id, tag_id))


def place_columns(place: PointRecord) -> dict[str, float]:
    """Return the columns of a place."""
    return {name: getattr(place, name) for name in ("x_m", "y_m", "var_x", "var_xy", "var_y")}


def place_of(row: object) -> PointRecord:
    """Return the place in a row that has its columns."""
    return PointRecord(*(getattr(row, name) for name in ("x_m", "y_m", "var_x", "var_xy", "var_y")))


def _latest(connection: Connection, mission_id: str, tag_id: str) -> tuple[int, bytes]:
    row = connection.execute(
        select(tag_memories.c.version, tag_memories.c.memory)
        .where(tag_memories.c.mission_id == mission_id, tag_memories.c.tag_id == tag_id)
        .order_by(tag_memories.c.version.desc())
        .limit(1)
    ).first()
    return (row.version, row.memory) if row else (0, b"")
