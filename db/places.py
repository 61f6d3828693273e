"""Where missions lie: their georeference, and the map that was there before them."""

from __future__ import annotations

from dataclasses import asdict, fields
from typing import Any, TypeVar

from sqlalchemy import Connection, Row, Table, delete, select

from db.engine import Database, insert_missing, upsert
from db.mission_records import BaseMapRecord, GeoreferenceRecord
from db.mission_tables import base_maps, georeferences, past_base_maps

_KEPT = 8  # base maps of a mission that were replaced or taken away; each may be megabytes

R = TypeVar("R", GeoreferenceRecord, BaseMapRecord)


class PlaceStore:
    """At most one georeference and one base map of a mission; on the disk once written."""

    def __init__(self, database: Database) -> None:
        self._database = database

    async def record_georeference(self, mission_id: str, record: GeoreferenceRecord | None) -> None:
        """Keep a georeference in the place of the one before; None: there is none any more."""
        await self._record(georeferences, mission_id, record)

    async def georeference_of(self, mission_id: str) -> GeoreferenceRecord | None:
        """Return the georeference of a mission; None where it has none."""
        row = await self._row(georeferences, mission_id, GeoreferenceRecord)
        return None if row is None else GeoreferenceRecord.of(dict(row._mapping))

    async def record_base_map(
        self, mission_id: str, record: BaseMapRecord | None, *, keep_past: bool = True
    ) -> None:
        """Keep a base map in the place of the one before, which goes to the past ones; None: no more."""

        def work(connection: Connection) -> None:
            now = connection.execute(select(base_maps).where(base_maps.c.mission_id == mission_id)).first()
            if now is not None and keep_past:
                insert_missing(connection, past_base_maps, [dict(now._mapping)])
            _set(connection, base_maps, mission_id, record)
            of_mission = past_base_maps.c.mission_id == mission_id
            times = select(past_base_maps.c.changed_unix_s).where(of_mission)
            kept = times.order_by(past_base_maps.c.changed_unix_s.desc()).limit(_KEPT)
            old = of_mission & past_base_maps.c.changed_unix_s.not_in(kept)
            connection.execute(delete(past_base_maps).where(old))

        await self._database.write(work, durable=True)

    async def past_base_map(self, mission_id: str, changed_unix_s: float) -> BaseMapRecord | None:
        """Return the base map that was laid at a moment and is there no more; None: it is not kept."""
        columns = [past_base_maps.c[item.name] for item in fields(BaseMapRecord)]
        chosen = (past_base_maps.c.mission_id == mission_id) & (
            past_base_maps.c.changed_unix_s == changed_unix_s
        )
        row = await self._database.read(lambda c: c.execute(select(*columns).where(chosen)).first())
        return None if row is None else BaseMapRecord(**row._mapping)

    async def base_map_of(self, mission_id: str) -> BaseMapRecord | None:
        """Return the base map of a mission; None where it has none."""
        row = await self._row(base_maps, mission_id, BaseMapRecord)
        return None if row is None else BaseMapRecord(**row._mapping)

    async def _record(self, table: Table, mission_id: str, record: R | None) -> None:
        await self._database.write(lambda c: _set(c, table, mission_id, record), durable=True)

    async def _row(self, table: Table, mission_id: str, kind: type[R]) -> Row[Any] | None:
        columns = [table.c[item.name] for item in fields(kind)]
        query = select(*columns).where(table.c.mission_id == mission_id)
        return await self._database.read(lambda c: c.execute(query).first())


def _set(connection: Connection, table: Table, mission_id: str, record: R | None) -> None:
    if record is None:
        connection.execute(delete(table).where(table.c.mission_id == mission_id))
    else:
        upsert(connection, table, [{"mission_id": mission_id, **asdict(record)}])
