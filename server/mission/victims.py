"""Victims: measured by robots, judged by people."""

from __future__ import annotations

import asyncio
from collections.abc import Iterable, Set
from dataclasses import replace
from typing import Any

from db.records import VictimRecord, VictimStatus
from db.store import Store
from robots.team import TeamVictim
from server.board import Board
from server.errors import unknown
from server.mission.alerts import Alerts
from server.mission.events import Events
from server.sharing import victim_record, victim_value


def judgement(victim: VictimRecord) -> dict[str, Any]:
    """Return what people have said about a victim."""
    return {"status": victim.status, "note": victim.note, "by": victim.by}


class Victims:
    """The victims by id."""

    def __init__(self, store: Store, mission_id: str, board: Board, events: Events, alerts: Alerts) -> None:
        self._store = store
        self._mission_id = mission_id
        self._board = board
        self._events = events
        self._alerts = alerts
        self._victims: dict[str, VictimRecord] = {}
        self._changing = asyncio.Lock()  # what a person says must not be lost to a map that comes meanwhile

    async def restore(self) -> None:
        """Bring the victims back from the database."""
        self._keep(await self._store.findings.victims_of(self._mission_id))

    def all(self) -> list[VictimRecord]:
        """Return every victim."""
        return list(self._victims.values())

    def get(self, victim_id: str) -> VictimRecord:
        """Return a victim.

        Raises:
            ApiError: there is none of that id.
        """
        if victim_id not in self._victims:
            raise unknown("victim", victim_id)
        return self._victims[victim_id]

    async def judge(self, victim_id: str, status: VictimStatus, note: str | None, by: str) -> VictimRecord:
        """Keep what a person says about a victim; a note of None keeps the earlier one.

        Raises:
            ApiError: there is none of that id.
        """
        async with self._changing:
            known = self.get(victim_id)
            victim = replace(known, status=status, note=known.note if note is None else note, by=by)
            await self._store.findings.record_status(self._mission_id, victim)
            self._keep([victim])
        await self._alerts.settle("victim", victim_id, by)
        await self._events.tell("victim_judged", f"Victim {victim_id} is {status}, says {by}.")
        return victim

    async def put_back(self, victim_id: str, said: dict[str, Any], by: str) -> None:
        """Put back what was said about a victim before; ``by`` takes a later word back.

        Raises:
            ApiError: there is none of that id.
        """
        async with self._changing:
            victim = replace(self.get(victim_id), **said)
            await self._store.findings.record_status(self._mission_id, victim)
            self._keep([victim])
        text = f"Victim {victim_id} is {victim.status} again: {by} took a change back."
        await self._events.tell("victim_judged", text)

    async def take(self, found: Iterable[TeamVictim], absent: Set[str]) -> None:
        """Take over the victims of a new team map.

        Those that turned out to be others go, unless a person has judged them or a robot that saw them is
        ``absent``: its agent is being brought back and has not said anything yet.
        """
        async with self._changing:
            known = self._victims
            now = {v.victim_id: victim_record(v, known.get(v.victim_id)) for v in found}
            gone = sorted(
                name
                for name, victim in known.items()
                if name not in now and not victim.by and not absent & set(victim.robots)
            )
            changed = [victim for name, victim in now.items() if known.get(name) != victim]
            new = [victim for victim in changed if victim.victim_id not in known]
            if changed:
                await self._store.findings.record_victims(self._mission_id, changed)
            if gone:
                await self._store.findings.forget_victims(self._mission_id, gone)
            self._keep(changed)
            for name in gone:
                del self._victims[name]
            self._board.publish({f"victim/{name}": None for name in gone})
        for victim in new:
            robots = ", ".join(victim.robots)
            text = f"Victim {victim.victim_id} seen by {robots}, {victim.confidence:.0%} sure."
            await self._alerts.raise_(
                "victim", victim.victim_id, text, "alarm", event="victim_seen",
                robot_id=victim.robots[0], victim_id=victim.victim_id,
            )  # fmt: skip
        for name in gone:
            await self._alerts.settle("victim", name, "the team map")

    def _keep(self, victims: Iterable[VictimRecord]) -> None:
        for victim in victims:
            self._victims[victim.victim_id] = victim
            self._board.publish({f"victim/{victim.victim_id}": victim_value(victim)})
