"""Victims: measured by robots, judged by people."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Iterable, Mapping, Set
from dataclasses import replace
from math import hypot, sqrt
from typing import Any

from db.records import PointRecord, TagRecord
from db.store import Store
from db.victim_records import SaidRecord, VictimRecord
from robots.team import TeamVictim
from server.board import Board
from server.errors import ApiError, unknown
from server.mission.alerts import Alerts
from server.mission.events import Events
from server.sharing import beside, victim_record, victim_value

_SEEN_M = 0.01


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

    async def say(self, victim_id: str, words: dict[str, Any], by: str) -> VictimRecord:
        """Keep what a person says about a victim: fields of ``SaidRecord``; those left out stay.

        Raises:
            ApiError: there is none of that id; or it is to be merged into itself or into one that is none.
        """
        async with self._changing:
            known = self.get(victim_id)
            self._check_merge(victim_id, words.get("merged_into"))
            words = {**words, **known.said.crossed_out(words)}
            said = replace(known.said, **words, by=by, changed_unix_s=time.time())
            victim = replace(known, said=said)
            await self._store.findings.record_said(self._mission_id, victim)
            self._keep([victim])
        await self._alerts.settle("victim", victim_id, by)
        await self._events.tell("victim_judged", f"Victim {victim_id} {_words(known.said, said)}, says {by}.")
        return victim

    async def add(self, victim: VictimRecord) -> None:
        """Add a victim that a person found; once it is there, adding it again changes nothing."""
        async with self._changing:
            if victim.victim_id in self._victims:
                return
            await self._store.findings.record_victims(self._mission_id, [victim])
            self._keep([victim])
        text = f"Victim {victim.victim_id} reported by {victim.said.by}. {victim.said.note}"
        await self._alerts.raise_(
            "victim", victim.victim_id, text, "alarm", event="victim_seen", victim_id=victim.victim_id
        )

    async def put_back(self, victim_id: str, said: dict[str, Any], by: str) -> None:
        """Put back what was said about a victim before; ``by`` takes a later word back.

        Raises:
            ApiError: there is none of that id.
        """
        async with self._changing:
            victim = replace(self.get(victim_id), said=SaidRecord.of(said))
            await self._store.findings.record_said(self._mission_id, victim)
            self._keep([victim])
        text = f"Victim {victim_id} is {victim.said.status} again: {by} took a change back."
        await self._events.tell("victim_judged", text)

    async def move(self, places: Mapping[str, PointRecord]) -> None:
        """Let victims that no robot has seen lie where their tags have come to lie."""
        async with self._changing:
            known = self._victims
            moved = [
                replace(known[name], place=place)
                for name, place in places.items()
                if name in known and _differs(known[name].place, place)
            ]
            if moved:
                await self._store.findings.record_victims(self._mission_id, moved)
                self._keep(moved)

    async def follow(self, tags: Mapping[str, TagRecord]) -> None:
        """Move what people reported with its tag; not with one that was carried off, or answers elsewhere."""
        at = {name: (victim, tags.get(victim.said.tag_id or "")) for name, victim in self._victims.items()}
        await self.move(
            {
                name: _at(tag)
                for name, (victim, tag) in at.items()
                if tag is not None and tag.state == "sound" and not victim.robots
            }
        )

    def _check_merge(self, victim_id: str, into: str | None) -> None:
        if into is None:
            return
        target = self._victims.get(into)
        if into == victim_id or target is None or target.said.merged_into is not None:
            message = f"Victim {victim_id} cannot be merged into {into!r}: name another victim that stands."
            raise ApiError(409, "cannot_merge", message, "merged_into")
        if any(victim.said.merged_into == victim_id for victim in self._victims.values()):
            message = (
                f"Others were merged into victim {victim_id}; split them off first, or merge the other way."
            )
            raise ApiError(409, "cannot_merge", message, "merged_into")

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
                if name not in now and not victim.said.by and not absent & set(victim.robots)
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


def _at(tag: TagRecord) -> PointRecord:
    place = tag.place
    return beside(place.x_m, place.y_m, (place.var_x, place.var_xy, place.var_y))


def _differs(place: PointRecord, other: PointRecord) -> bool:
    """Say whether a place has changed by what anybody would see."""
    apart = hypot(place.x_m - other.x_m, place.y_m - other.y_m)
    return apart > _SEEN_M or abs(sqrt(place.var_x + place.var_y) - sqrt(other.var_x + other.var_y)) > _SEEN_M


def _words(before: SaidRecord, after: SaidRecord) -> str:
    """Return what has changed, in words."""
    if after.merged_into != before.merged_into:
        return "stands for itself" if after.merged_into is None else f"is the same as {after.merged_into}"
    words = []
    if after.status != before.status:
        words.append(f"is {after.status}")
    if after.start.triage != before.start.triage:
        words.append(f"is triaged {after.start.triage}")
    if (after.live, after.dead) != (before.live, before.dead):
        words.append(f"has {after.live or 0} live and {after.dead or 0} dead")
    if after.team != before.team:
        words.append(f"goes to {after.team}" if after.team else "goes to no team")
    if after.place_m != before.place_m:
        words.append("was moved on the plan")
    if after.note != before.note:
        words.append("has a new note")
    return ", ".join(words) or f"is {after.status}"
