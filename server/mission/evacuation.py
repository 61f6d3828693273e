"""EVACUATE: ordered once, heard by name, until it is over (INSARAG: three short signals)."""

from __future__ import annotations

import asyncio
import time
from typing import Any

from db.records import EvacuationRecord
from db.store import Store
from server.board import Board
from server.errors import ApiError
from server.mission.events import Events


class Evacuation:
    """Whether all have to leave, and who has said that they heard it."""

    def __init__(self, store: Store, mission_id: str, board: Board, events: Events) -> None:
        self._store = store.alerts
        self._mission_id = mission_id
        self._board = board
        self._events = events
        self._now: EvacuationRecord | None = None
        self._changing = asyncio.Lock()

    async def restore(self) -> None:
        """Bring it back from the database."""
        self._now = await self._store.evacuation_of(self._mission_id)
        self._publish()

    def value(self) -> dict[str, Any]:
        """Return ``evacuation`` of the board."""
        now = self._now
        heard = [] if now is None else [{"name": n, "unix_s": t} for n, t in now.acknowledged]
        return {
            "ordered": now is not None,
            "by": None if now is None else now.by,
            "since_unix_s": None if now is None else now.since_unix_s,
            "acknowledged": heard,
        }

    async def order(self, by: str) -> None:
        """Order everybody out; again while it holds changes nothing."""
        async with self._changing:
            if self._now is not None:
                return
            self._now = EvacuationRecord(by, time.time())
            self._publish()  # before it is saved: a full disk must not keep people inside
            await self._store.record_evacuation(self._mission_id, self._now)
        await self._events.tell("evacuate", f"EVACUATE, says {by}: everybody out.", None, "alarm")

    async def acknowledge(self, name: str) -> None:
        """Keep that somebody has heard it.

        Raises:
            ApiError: nobody has ordered it.
        """
        async with self._changing:
            now = self._now
            if now is None:
                raise ApiError(409, "not_ordered", "Nobody has ordered to evacuate.")
            if any(known == name for known, _ in now.acknowledged):
                return
            self._now = EvacuationRecord(now.by, now.since_unix_s, (*now.acknowledged, (name, time.time())))
            self._publish()
            await self._store.record_evacuation(self._mission_id, self._now)
        await self._events.tell("evacuate_heard", f"{name} has heard EVACUATE.")

    async def end(self, by: str) -> None:
        """Let people in again; where it was not ordered nothing changes."""
        async with self._changing:
            if self._now is None:
                return
            await self._store.record_evacuation(self._mission_id, None)
            self._now = None
            self._publish()
        await self._events.tell("evacuate_over", f"EVACUATE is over, says {by}.")

    def _publish(self) -> None:
        self._board.publish({"evacuation": self.value() if self._now is not None else None})
