"""Active nodes: what they measured last."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, fields

from sqlalchemy import Connection, select

from db.engine import Database, upsert
from db.records import NodeRecord
from db.tables import node_readings


class NodeStore:
    """Nodes of a mission by tag id."""

    def __init__(self, database: Database) -> None:
        self._database = database

    async def record_readings(self, mission_id: str, records: Sequence[NodeRecord]) -> None:
        """Keep what nodes measured; the latest replaces the earlier."""
        rows = [{"mission_id": mission_id, **asdict(record)} for record in records]
        await self._database.write(lambda c: upsert(c, node_readings, rows))

    async def readings_of(self, mission_id: str) -> list[NodeRecord]:
        """Return the latest readings of a mission by tag id."""
        columns = [node_readings.c[item.name] for item in fields(NodeRecord)]

        def query(connection: Connection) -> list[NodeRecord]:
            chosen = select(*columns).where(node_readings.c.mission_id == mission_id)
            rows = connection.execute(chosen.order_by(node_readings.c.tag_id))
            return [NodeRecord(**row._mapping) for row in rows]

        return await self._database.read(query)
