"""What happened in a mission, for the people who watch."""

from __future__ import annotations

import time
from collections import deque
from typing import Any

import structlog

from db.errors import DatabaseError
from db.records import EventRecord, Severity
from db.store import Store
from server.board import Board
from server.sharing import event_value

_SHOWN = 50

log = structlog.get_logger()


class Events:
    """Records events and shows the latest fifty on the board."""

    def __init__(self, store: Store, mission_id: str, board: Board) -> None:
        self._store = store
        self._mission_id = mission_id
        self._board = board
        self._shown: deque[int] = deque()

    async def restore(self) -> None:
        """Show the latest events of the database."""
        for event in await self._store.findings.latest_events(self._mission_id, _SHOWN):
            self._show(event)

    async def tell(
        self, kind: str, text: str, robot_id: str | None = None, severity: Severity = "info"
    ) -> None:
        """Record an event and show it.

        What happened has happened: a database that cannot take the event is a matter for the log, not for
        the caller.
        """
        event = EventRecord(0, time.time(), kind, text, robot_id, severity)
        try:
            event = await self._store.findings.record_event(self._mission_id, event)
        except DatabaseError as error:
            log.error(
                "an event could not be saved", mission_id=self._mission_id, text=text, reason=str(error)
            )
            return
        self._show(event)

    async def after(self, event_id: int, limit: int) -> list[EventRecord]:
        """Return at most ``limit`` events after one, oldest first."""
        return await self._store.findings.events_after(self._mission_id, event_id, limit)

    def _show(self, event: EventRecord) -> None:
        self._shown.append(event.event_id)
        values: dict[str, dict[str, Any] | None] = {f"event/{event.event_id}": event_value(event)}
        if len(self._shown) > _SHOWN:
            values[f"event/{self._shown.popleft()}"] = None
        self._board.publish(values)
