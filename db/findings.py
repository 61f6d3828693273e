"""What people act on: victims, annotations, events."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, fields
from typing import Any

from sqlalchemy import Connection, and_, delete, func, insert, select, update

from db import tables
from db.engine import Database, upsert
from db.records import AnnotationRecord, EventRecord
from db.tags import place_columns, place_of
from db.victim_records import SaidRecord, VictimRecord


class FindingStore:
    """Victims, annotations and events of a mission. Victims and annotations are on the disk once written."""

    def __init__(self, database: Database) -> None:
        self._database = database

    async def record_victims(self, mission_id: str, records: Sequence[VictimRecord]) -> None:
        """Keep what the team measured of victims; what people said about a known one stays."""
        rows = [_victim_row(mission_id, record) for record in records]
        await self._database.write(
            lambda c: upsert(c, tables.victims, rows, keep=("said", "by")), durable=True
        )

    async def record_said(self, mission_id: str, victim: VictimRecord) -> None:
        """Keep what people said about a victim."""
        said = {"said": victim.said.value(), "by": victim.said.by}
        chosen = and_(
            tables.victims.c.mission_id == mission_id, tables.victims.c.victim_id == victim.victim_id
        )
        await self._database.write(
            lambda c: c.execute(update(tables.victims).where(chosen).values(said)), durable=True
        )

    async def forget_victims(self, mission_id: str, victim_ids: Sequence[str]) -> None:
        """Drop victims that turned out to be others; those about whom a person has said something stay."""
        chosen = and_(
            tables.victims.c.mission_id == mission_id,
            tables.victims.c.victim_id.in_(victim_ids),
            tables.victims.c.by == "",
        )
        await self._database.write(lambda c: c.execute(delete(tables.victims).where(chosen)), durable=True)

    async def victims_of(self, mission_id: str) -> list[VictimRecord]:
        """Return the victims of a mission by id."""

        def query(connection: Connection) -> list[VictimRecord]:
            rows = connection.execute(
                select(tables.victims)
                .where(tables.victims.c.mission_id == mission_id)
                .order_by(tables.victims.c.victim_id)
            )
            return [_victim(row) for row in rows]

        return await self._database.read(query)

    async def record_annotation(
        self, mission_id: str, record: AnnotationRecord, *, deleted: bool = False
    ) -> None:
        """Keep an annotation as it is now, or that it was deleted."""
        row = {"mission_id": mission_id, **asdict(record), "deleted": deleted}
        await self._database.write(lambda c: upsert(c, tables.annotations, [row]), durable=True)

    async def annotations_of(self, mission_id: str) -> list[AnnotationRecord]:
        """Return the annotations of a mission that were not deleted, oldest first."""

        def query(connection: Connection) -> list[AnnotationRecord]:
            columns = [tables.annotations.c[item.name] for item in fields(AnnotationRecord)]
            rows = connection.execute(
                select(*columns)
                .where(tables.annotations.c.mission_id == mission_id, tables.annotations.c.deleted.is_(False))
                .order_by(tables.annotations.c.created_unix_s, tables.annotations.c.annotation_id)
            )
            return [AnnotationRecord.of(dict(row._mapping)) for row in rows]

        return await self._database.read(query)

    async def record_event(self, mission_id: str, event: EventRecord) -> EventRecord:
        """Add an event and return it with the id it was given."""
        row = {name: value for name, value in asdict(event).items() if name != "event_id"}

        def work(connection: Connection) -> int:
            result = connection.execute(insert(tables.events).values(mission_id=mission_id, **row))
            return int((result.inserted_primary_key or (0,))[0])

        return EventRecord(event_id=await self._database.write(work), **row)

    async def events_after(self, mission_id: str, event_id: int, limit: int) -> list[EventRecord]:
        """Return at most ``limit`` events with larger ids, oldest first."""
        query = select(tables.events).where(
            tables.events.c.mission_id == mission_id, tables.events.c.event_id > event_id
        )
        return await self._database.read(
            lambda c: _events(c, query.order_by(tables.events.c.event_id).limit(limit))
        )

    async def alarms_of(self, mission_id: str) -> dict[str, int]:
        """Return how many events of each kind were a warning or an alarm."""
        table = tables.events
        query = (
            select(table.c.kind, func.count())
            .where(table.c.mission_id == mission_id, table.c.severity != "info")
            .group_by(table.c.kind)
            .order_by(table.c.kind)
        )
        return await self._database.read(lambda c: {row[0]: row[1] for row in c.execute(query)})

    async def latest_events(self, mission_id: str, limit: int) -> list[EventRecord]:
        """Return the latest ``limit`` events, oldest first."""
        query = (
            select(tables.events)
            .where(tables.events.c.mission_id == mission_id)
            .order_by(tables.events.c.event_id.desc())
        )
        return (await self._database.read(lambda c: _events(c, query.limit(limit))))[::-1]


def _victim_row(mission_id: str, record: VictimRecord) -> dict[str, Any]:
    row = {item.name: getattr(record, item.name) for item in fields(record) if item.name != "place"}
    row |= {"robots": list(record.robots), "said": record.said.value(), "by": record.said.by}
    return {"mission_id": mission_id, **row, **place_columns(record.place)}


def _victim(row: Any) -> VictimRecord:
    values = {
        item.name: getattr(row, item.name)
        for item in fields(VictimRecord)
        if item.name not in ("place", "robots", "said")
    }
    said = SaidRecord.of(row.said)
    return VictimRecord(place=place_of(row), robots=tuple(row.robots), said=said, **values)


def _events(connection: Connection, query: Any) -> list[EventRecord]:
    columns = [item.name for item in fields(EventRecord)]
    return [
        EventRecord(**{name: getattr(row, name) for name in columns}) for row in connection.execute(query)
    ]
