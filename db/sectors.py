"""Sectors to be searched, and the operational periods they are searched in."""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields
from typing import Any, Literal

from sqlalchemy import Connection, select

from db.engine import Database, upsert
from db.mission_tables import periods, sectors
from db.worksites import WorksiteRecord

SectorStatus = Literal["unassigned", "under_way", "searched", "second_look"]


@dataclass(frozen=True, slots=True)
class SectorRecord:
    """A part of the ground that somebody searches: robots, or a ``team`` of people.

    ``area_m``: its corners in the world frame; ``period``: the number of the operational period in which it
    was assigned or judged last, None while there was none; ``worksite``: what is marked at its front, None
    where nothing is.
    """

    sector_id: str
    name: str
    area_m: tuple[tuple[float, float], ...]
    status: SectorStatus
    robots: tuple[str, ...]
    team: str
    note: str
    period: int | None
    by: str
    created_unix_s: float
    changed_unix_s: float
    worksite: WorksiteRecord | None = None

    @classmethod
    def of(cls, value: dict[str, Any]) -> SectorRecord:
        """Return it of its plain values, as they are stored and go over the wire."""
        area = tuple((float(x), float(y)) for x, y in value["area_m"])
        told = {item.name: value[item.name] for item in fields(cls)}
        worksite = value["worksite"] and WorksiteRecord.of(value["worksite"])
        return cls(**{**told, "area_m": area, "robots": tuple(value["robots"]), "worksite": worksite})


@dataclass(frozen=True, slots=True)
class PeriodRecord:
    """An operational period: who commands, what for, from when until when (None: it goes on)."""

    number: int
    commander: str
    objectives: str
    begun_unix_s: float
    ended_unix_s: float | None = None


class SectorStore:
    """Sectors and periods of a mission; on the disk once written."""

    def __init__(self, database: Database) -> None:
        self._database = database

    async def record_sector(self, mission_id: str, record: SectorRecord, *, deleted: bool = False) -> None:
        """Keep a sector as it is now, or that it was taken off the map."""
        row = {"mission_id": mission_id, **asdict(record), "deleted": deleted}
        await self._database.write(lambda c: upsert(c, sectors, [row]), durable=True)

    async def sectors_of(self, mission_id: str) -> list[SectorRecord]:
        """Return the sectors of a mission that are on the map, the oldest first."""
        columns = [sectors.c[item.name] for item in fields(SectorRecord)]

        def query(connection: Connection) -> list[SectorRecord]:
            chosen = select(*columns).where(sectors.c.mission_id == mission_id, sectors.c.deleted.is_(False))
            rows = connection.execute(chosen.order_by(sectors.c.created_unix_s, sectors.c.sector_id))
            return [SectorRecord.of(dict(row._mapping)) for row in rows]

        return await self._database.read(query)

    async def record_periods(self, mission_id: str, records: list[PeriodRecord]) -> None:
        """Keep periods as they are now, all or none."""
        rows = [{"mission_id": mission_id, **asdict(record)} for record in records]
        await self._database.write(lambda c: upsert(c, periods, rows), durable=True)

    async def periods_of(self, mission_id: str) -> list[PeriodRecord]:
        """Return the periods of a mission, the first first."""
        columns = [periods.c[item.name] for item in fields(PeriodRecord)]

        def query(connection: Connection) -> list[PeriodRecord]:
            chosen = select(*columns).where(periods.c.mission_id == mission_id)
            return [
                PeriodRecord(**row._mapping) for row in connection.execute(chosen.order_by(periods.c.number))
            ]

        return await self._database.read(query)
