"""How a mission gets on: samples of what it has come to, to compare missions by."""

from __future__ import annotations

import asyncio
import time
from typing import Any

import structlog

from db.errors import DatabaseError
from db.mission_records import ProgressRecord
from db.store import Store
from server.board import Board

_EVERY_S = 5.0

log = structlog.get_logger()


class Progress:
    """Keeps a sample whenever something has changed, at most every five seconds."""

    def __init__(self, store: Store, mission_id: str, board: Board) -> None:
        self._store = store
        self._mission_id = mission_id
        self._board = board
        self._last: tuple[float, int, int] | None = None

    async def watch(self) -> None:
        """Look again and again, until cancelled."""
        while True:
            await asyncio.sleep(_EVERY_S)
            await self.note()

    async def note(self) -> None:
        """Keep how the mission stands now, where that is news."""
        now = figures(self._board)
        found = (now["explored_m2"], now["tags"], now["victims"])
        try:
            known = await self.all() if self._last is None else ()
        except DatabaseError as error:
            log.warning("progress could not be read", mission_id=self._mission_id, reason=str(error))
            return
        if known:
            self._last = (known[-1].explored_m2, known[-1].tags, known[-1].victims)
        if self._last is None and self._board.of_kind("robot"):
            found = (0.0, 0, 0)  # the moment at which the first robot was heard
        elif self._board.get("map") is None or found == self._last:  # after a restart the map comes late
            return
        mission = self._board.get("mission") or {}
        sample = ProgressRecord(time.time(), float(mission.get("clock_s", 0.0)), *found)
        try:
            await self._store.missions.record_progress(self._mission_id, sample)
        except DatabaseError as error:
            log.warning("progress could not be saved", mission_id=self._mission_id, reason=str(error))
            return
        self._last = found

    async def all(self) -> list[ProgressRecord]:
        """Return all samples, in order of time."""
        return await self._store.missions.progress_of(self._mission_id)


def figures(board: Board) -> dict[str, Any]:
    """Return what a mission has come to, as its board shows it."""
    victims = [v for v in board.of_kind("victim") if v["status"] != "dismissed" and not v["merged_into"]]
    heard = [robot["heard_unix_s"] for robot in board.of_kind("robot")]
    return {
        "explored_m2": float((board.get("map") or {}).get("explored_m2", 0.0)),
        "tags": len(board.of_kind("tag")),
        "victims": len(victims),
        "heard_unix_s": max((unix_s for unix_s in heard if unix_s is not None), default=None),
    }
