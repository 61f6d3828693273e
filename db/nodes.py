"""Active nodes: what they measured last, and the alerts about them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, fields

from sqlalchemy import Connection, select

from db.engine import Database, upsert
from db.records import AlertRecord, NodeRecord
from db.tables import alerts, node_readings


class NodeStore:
    """Nodes of a mission by tag id. Alerts are on the disk once written."""

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

    async def record_alert(self, mission_id: str, record: AlertRecord) -> None:
        """Keep an alert as it is now; a new one of the same node and kind replaces an earlier one."""
        row = {"mission_id": mission_id, **asdict(record)}
        await self._database.write(lambda c: upsert(c, alerts, [row]), durable=True)

    async def alerts_of(self, mission_id: str) -> list[AlertRecord]:
        """Return the alerts of a mission, the earliest first."""
        columns = [alerts.c[item.name] for item in fields(AlertRecord)]

        def query(connection: Connection) -> list[AlertRecord]:
            chosen = select(*columns).where(alerts.c.mission_id == mission_id)
            rows = connection.execute(chosen.order_by(alerts.c.raised_unix_s, alerts.c.alert_id))
            return [AlertRecord(**row._mapping) for row in rows]

        return await self._database.read(query)
