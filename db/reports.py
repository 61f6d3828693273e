"""What people reported from the field, each once: whoever sends one again is told what became of it."""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields
from typing import Any, Literal

from sqlalchemy import Connection, select

from db.engine import Database, upsert
from db.tables import reports

ReportKind = Literal["note", "victim", "mayday", "heard", "at"]


@dataclass(frozen=True, slots=True)
class ReportRecord:
    """A report: ``made_unix_s`` by the server's clock as far as it can be told.

    ``phone_unix_s`` is what the phone's clock said when it was made, and ``offset_s`` by how much the phone
    knew then that its clock was slow. ``outcome``: what became of it, in words.
    """

    report_id: str
    kind: ReportKind
    by: str
    made_unix_s: float
    received_unix_s: float
    phone_unix_s: float
    offset_s: float | None
    body: dict[str, Any]
    outcome: str


_COLUMNS = [reports.c[item.name] for item in fields(ReportRecord)]


class ReportStore:
    """Reports of a mission; on the disk once written."""

    def __init__(self, database: Database) -> None:
        self._database = database

    async def record(self, mission_id: str, record: ReportRecord) -> None:
        """Keep a report."""
        row = {"mission_id": mission_id, **asdict(record)}
        await self._database.write(lambda c: upsert(c, reports, [row]), durable=True)

    async def get(self, mission_id: str, report_id: str) -> ReportRecord | None:
        """Return a report; None where there is none of that id."""
        chosen = select(*_COLUMNS).where(reports.c.mission_id == mission_id, reports.c.report_id == report_id)

        def query(connection: Connection) -> ReportRecord | None:
            row = connection.execute(chosen).first()
            return None if row is None else ReportRecord(**row._mapping)

        return await self._database.read(query)

    async def latest(self, mission_id: str, limit: int, kind: str | None = None) -> list[ReportRecord]:
        """Return the latest reports, of one kind if told, the newest first."""
        chosen = select(*_COLUMNS).where(reports.c.mission_id == mission_id)
        if kind is not None:
            chosen = chosen.where(reports.c.kind == kind)
        chosen = chosen.order_by(reports.c.received_unix_s.desc(), reports.c.report_id).limit(limit)
        return await self._database.read(
            lambda connection: [ReportRecord(**row._mapping) for row in connection.execute(chosen)]
        )
