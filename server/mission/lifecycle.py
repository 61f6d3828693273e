"""The states of a mission: which follows which, what each refuses, and who has put it there."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Mapping
from dataclasses import dataclass, replace

from db.records import MissionRecord, MissionState
from db.store import Store
from server.errors import ApiError
from server.mission.events import Events
from server.mission.roster import Roster


@dataclass(frozen=True, slots=True)
class Step:
    """What people may do with a mission: from which states, to which, and in which words."""

    befores: frozenset[MissionState]
    after: MissionState
    event: str
    done: str


STEPS: Mapping[str, Step] = {
    "start": Step(frozenset({"draft", "paused"}), "running", "mission_started", "started"),
    "pause": Step(frozenset({"running"}), "paused", "mission_paused", "paused"),
    "close": Step(frozenset({"draft", "running", "paused"}), "closed", "mission_closed", "closed"),
    "archive": Step(frozenset({"closed"}), "archived", "mission_archived", "archived"),
    "reopen": Step(frozenset({"closed", "archived"}), "paused", "mission_reopened", "reopened"),
}
"""A mission that is reopened is paused, so that no robot drives off before somebody starts it."""


class Lifecycle:
    """Leads a mission from state to state: saved, shown, and told as an event."""

    def __init__(self, store: Store, roster: Roster, events: Events) -> None:
        self._store = store
        self._roster = roster
        self._events = events
        self._changing = asyncio.Lock()

    @property
    def record(self) -> MissionRecord:
        """The mission as it is now."""
        return self._roster.record

    async def take(self, step: str, by: str) -> bool:
        """Take one of ``STEPS``; return whether that changed anything, which it does not a second time.

        Raises:
            ApiError: it does not follow from the state the mission is in, or robots still drive.
            DatabaseError: it could not be saved, and the state is as it was.
        """
        async with self._changing:
            record, told = self._roster.record, STEPS[step]
            if record.state == told.after and step != "reopen":
                return False
            self._check(step, record)
            now = time.time()
            changed = replace(
                record,
                state=told.after,
                state_by=by,
                state_unix_s=now,
                ran_s=record.duration_s(now),
                started_unix_s=now
                if told.after == "running" and record.started_unix_s is None
                else record.started_unix_s,
            )
            await self._store.missions.record_state(changed)
            self._roster.enter(changed)
        await self._events.tell(told.event, f"{record.name} was {told.done} by {by}.")
        return True

    def check_open(self) -> None:
        """Refuse a change where the mission is over.

        Raises:
            ApiError: it is over.
        """
        record = self._roster.record
        if record.is_over:
            who = f" by {record.state_by}" if record.state_by else ""
            text = (
                f"{record.name} was {record.state}{who}, and nothing in it is changed any more;"
                " reopen it, or go to a mission that runs."
            )
            raise ApiError(409, f"mission_{record.state}", text)

    def check_running(self) -> None:
        """Refuse observations where nobody has started the mission, or it is over.

        Raises:
            ApiError: it takes none now.
        """
        self.check_open()
        if self._roster.record.state == "draft":
            text = (
                f"{self._roster.record.name} is a draft and takes no observations;"
                " start it, then send them again."
            )
            raise ApiError(409, "mission_draft", text)

    def _check(self, step: str, record: MissionRecord) -> None:
        told = STEPS[step]
        if record.state not in told.befores:
            befores = " or ".join(sorted(told.befores))
            text = f"{record.name} is {record.state}; only a mission that is {befores} can be {told.done}."
            raise ApiError(409, "wrong_state", text)
        live = [robot.robot_id for robot in self._roster.robots.values() if robot.link == "live"]
        if step == "close" and record.state == "running" and live:
            text = (
                f"{', '.join(sorted(live))} would go on without anybody to lead them;"
                " pause the mission first, so that they stand still."
            )
            raise ApiError(409, "robots_drive", text)
