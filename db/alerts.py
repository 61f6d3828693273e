"""Alerts and the order to evacuate, and who has taken note of them."""

from __future__ import annotations

from dataclasses import asdict, fields

from sqlalchemy import Connection, delete, select

from db.engine import Database, upsert
from db.records import AlertRecord, EvacuationRecord
from db.tables import alerts, evacuations


class AlertStore:
    """Alerts of a mission; on the disk once written."""

    def __init__(self, database: Database) -> None:
        self._database = database

    async def record_alert(self, mission_id: str, record: AlertRecord) -> None:
        """Keep an alert as it is now; a new one of the same id replaces an earlier one."""
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

    async def record_evacuation(self, mission_id: str, record: EvacuationRecord | None) -> None:
        """Keep the order to evacuate as it is now, None when it is over."""
        chosen = evacuations.c.mission_id == mission_id

        def work(connection: Connection) -> None:
            if record is None:
                connection.execute(delete(evacuations).where(chosen))
            else:
                upsert(connection, evacuations, [{"mission_id": mission_id, **asdict(record)}])

        await self._database.write(work, durable=True)

    async def evacuation_of(self, mission_id: str) -> EvacuationRecord | None:
        """Return the order that holds; None where there is none."""

        def query(connection: Connection) -> EvacuationRecord | None:
            row = connection.execute(
                select(evacuations).where(evacuations.c.mission_id == mission_id)
            ).first()
            if row is None:
                return None
            heard = tuple((str(name), float(unix_s)) for name, unix_s in row.acknowledged)
            return EvacuationRecord(row.by, row.since_unix_s, heard)

        return await self._database.read(query)
