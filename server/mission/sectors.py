"""Sectors: who searches which part of the ground, how far they are, and in which operational period."""

from __future__ import annotations

import asyncio
import time
from dataclasses import asdict, replace
from typing import Any

from db.sectors import PeriodRecord, SectorRecord
from db.store import Store
from db.worksites import goes_on
from robots.exploration.area import holds
from server.board import Board
from server.errors import ApiError, unknown
from server.mission.events import Events
from server.mission.worksite_news import worksite_news

MAX_SECTORS = 500
_WORDS = {
    "unassigned": "free",
    "under_way": "under way",
    "searched": "searched",
    "second_look": "to be looked at again",
}


class Sectors:
    """The sectors by id, the oldest first, and the operational periods by number."""

    def __init__(self, store: Store, mission_id: str, board: Board, events: Events) -> None:
        self._store = store.sectors
        self._mission_id = mission_id
        self._board = board
        self._events = events
        self._sectors: dict[str, SectorRecord] = {}
        self._periods: list[PeriodRecord] = []
        self._changing = asyncio.Lock()

    async def restore(self) -> None:
        """Bring sectors and periods back from the database."""
        for sector in await self._store.sectors_of(self._mission_id):
            self._keep(sector)
        self._periods = await self._store.periods_of(self._mission_id)
        self._board.publish({f"period/{period.number}": asdict(period) for period in self._periods})

    def all(self) -> list[SectorRecord]:
        """Return every sector, the oldest first."""
        return list(self._sectors.values())

    def periods(self) -> list[PeriodRecord]:
        """Return every period, the first first."""
        return list(self._periods)

    def get(self, sector_id: str) -> SectorRecord:
        """Return a sector.

        Raises:
            ApiError: there is none of that id.
        """
        if sector_id not in self._sectors:
            raise unknown("sector", sector_id)
        return self._sectors[sector_id]

    def value(self, sector_id: str) -> dict[str, Any] | None:
        """Return a sector as it goes over the wire; None where there is none."""
        known = self._sectors.get(sector_id)
        return None if known is None else sector_value(known)

    async def put(self, sector: SectorRecord) -> SectorRecord:
        """Keep a sector and return it as it stands; the same words again change nothing.

        Raises:
            ApiError: there are too many, or visits to the worksite are left out.
        """
        async with self._changing:
            known = self._sectors.get(sector.sector_id)
            if known is not None and not goes_on(known.worksite, sector.worksite):
                text = (
                    "Somebody came to the worksite of whom you did not know. Look at it anew: "
                    "what was marked there is never erased."
                )
                raise ApiError(409, "visits_lost", text, "worksite")
            if known is None and len(self._sectors) >= MAX_SECTORS:
                raise ApiError(
                    409, "too_many_sectors", f"There are {MAX_SECTORS} sectors already; remove some."
                )
            running = self._periods[-1] if self._periods and self._periods[-1].ended_unix_s is None else None
            period = None if running is None else running.number
            if known is not None:
                if _work(known) == _work(sector):
                    period = known.period
                sector = replace(sector, created_unix_s=known.created_unix_s)
                same = replace(sector, period=period, by=known.by, changed_unix_s=known.changed_unix_s)
                if same == known:
                    return known
            sector = replace(sector, period=period)
            await self._store.record_sector(self._mission_id, sector)
            self._keep(sector)
        if known is None or _work(known) != _work(sector):
            await self._events.tell("sector", f"Sector {sector.name} is {_told(sector)}, says {sector.by}.")
        for text in worksite_news(None if known is None else known.worksite, sector.worksite):
            await self._events.tell("sector", f"{text}, says {sector.by}.")
        return sector

    async def put_back(self, value: dict[str, Any]) -> None:
        """Put a sector back as it was before a change."""
        sector = SectorRecord.of(value)
        await self._store.record_sector(self._mission_id, sector)
        self._keep(sector)

    async def remove(self, sector_id: str) -> None:
        """Take a sector off the map; it stays in the database, marked as deleted.

        Raises:
            ApiError: there is none of that id.
        """
        sector = self.get(sector_id)
        await self._store.record_sector(self._mission_id, sector, deleted=True)
        self._sectors.pop(sector_id, None)
        self._board.publish({f"sector/{sector_id}": None})

    async def begin_period(self, commander: str, objectives: str, by: str) -> PeriodRecord:
        """Begin the next operational period; the one before ends with that."""
        async with self._changing:
            now = time.time()
            before = [replace(p, ended_unix_s=now) for p in self._periods if p.ended_unix_s is None]
            period = PeriodRecord(len(self._periods) + 1, commander, objectives, now)
            await self._keep_periods([*before, period])
        text = f"Operational period {period.number} begins under {commander}, says {by}."
        await self._events.tell("period", text)
        return period

    async def end_period(self, by: str) -> PeriodRecord:
        """End the period that goes on.

        Raises:
            ApiError: none does.
        """
        async with self._changing:
            if not self._periods or self._periods[-1].ended_unix_s is not None:
                raise ApiError(409, "no_period", "No operational period goes on; begin one first.")
            period = replace(self._periods[-1], ended_unix_s=time.time())
            await self._keep_periods([period])
        await self._events.tell("period", f"Operational period {period.number} is over, says {by}.")
        return period

    async def _keep_periods(self, changed: list[PeriodRecord]) -> None:
        await self._store.record_periods(self._mission_id, changed)
        self._periods = sorted(
            {p.number: p for p in [*self._periods, *changed]}.values(), key=lambda p: p.number
        )
        self._board.publish({f"period/{period.number}": asdict(period) for period in changed})

    def _keep(self, sector: SectorRecord) -> None:
        self._sectors[sector.sector_id] = sector
        self._board.publish({f"sector/{sector.sector_id}": sector_value(sector)})


def sector_value(sector: SectorRecord) -> dict[str, Any]:
    """Return ``sector/ID`` of the board."""
    told = {**asdict(sector), "area_m": [list(c) for c in sector.area_m], "robots": list(sector.robots)}
    if sector.worksite is not None:
        for name in ("visits", "ratings", "clearances"):
            told["worksite"][name] = [asdict(each) for each in getattr(sector.worksite, name)]
    return {**told, "size_m2": round(abs(signed_m2(sector.area_m)), 1)}


def signed_m2(corners: tuple[tuple[float, float], ...]) -> float:
    """Return the area of a polygon, positive where its corners go round counter-clockwise (Gauss)."""
    sides = zip(corners, corners[1:] + corners[:1], strict=True)
    return 0.5 * sum(ax * by - bx * ay for (ax, ay), (bx, by) in sides)


def middle_of(corners: tuple[tuple[float, float], ...]) -> tuple[float, float]:
    """Return a point inside a polygon: its centroid, or the middle of its widest part at that height."""
    area = signed_m2(corners)
    sides = list(zip(corners, corners[1:] + corners[:1], strict=True))
    x = sum((ax + bx) * (ax * by - bx * ay) for (ax, ay), (bx, by) in sides) / (6.0 * area)
    y = sum((ay + by) * (ax * by - bx * ay) for (ax, ay), (bx, by) in sides) / (6.0 * area)
    if holds(corners, x, y):
        return x, y
    cuts = sorted(
        ax + (y - ay) / (by - ay) * (bx - ax) for (ax, ay), (bx, by) in sides if (ay > y) != (by > y)
    )
    left, right = max(zip(cuts[::2], cuts[1::2], strict=True), key=lambda cut: cut[1] - cut[0])
    return (left + right) / 2.0, y


def _work(sector: SectorRecord) -> tuple[object, ...]:
    return (sector.status, sector.robots, sector.team)


def _told(sector: SectorRecord) -> str:
    who = ", ".join([*sector.robots, *([sector.team] if sector.team else [])])
    return f"{_WORDS[sector.status]} ({who})" if who else _WORDS[sector.status]
