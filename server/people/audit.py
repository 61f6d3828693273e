"""The audit log: every change with who and when. It only grows; the database refuses anything else."""

from __future__ import annotations

import time
from collections.abc import Callable, Coroutine
from dataclasses import asdict, dataclass
from typing import Any

import structlog
from fastapi import Request, Response
from fastapi.routing import APIRoute

from db.errors import DatabaseError
from db.people_records import AuditRecord
from db.store import Store
from server.missions import Missions
from server.people.actor import Actor

_READS = {"GET", "HEAD", "OPTIONS"}

log = structlog.get_logger()


@dataclass(slots=True)
class Change:
    """What a route tells of the change it makes; ``before`` and ``after`` where it can be undone."""

    subject: str = ""
    before: dict[str, Any] | None = None
    after: dict[str, Any] | None = None


class AuditedRoute(APIRoute):
    """A route whose changes are in the audit log before its answer leaves; none can forget to say so."""

    def get_route_handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        """Return the handler with the log behind it."""
        handle = super().get_route_handler()
        if set(self.methods or ()) <= _READS:
            return handle

        async def noted(request: Request) -> Response:
            response = await handle(request)
            if response.status_code < 400:
                await _note(request, self.name)
                await _record(request)
            return response

        return noted


async def _record(request: Request) -> None:
    """Have the change in the mission's past before its answer leaves."""
    missions: Missions = request.app.state.missions
    mission = missions.find(request.path_params.get("mission_id", ""))
    if mission is not None:
        await mission.history.flush()


async def _note(request: Request, action: str) -> None:
    actor: Actor = request.state.actor
    change: Change = getattr(request.state, "change", None) or Change()
    store: Store = request.app.state.missions.store
    names = [value for key, value in request.path_params.items() if key != "mission_id"]
    record = AuditRecord(
        audit_id=0,
        unix_s=time.time(),
        mission_id=request.path_params.get("mission_id"),
        by=actor.name,
        role=actor.role,
        action=action,
        subject=change.subject or " ".join(map(str, names)),
        before=change.before,
        after=change.after,
    )
    try:
        await store.people.note(record)
    except DatabaseError as error:  # what was done is done: whoever pressed STOP has to be told that it holds
        log.error("a change could not be noted", change=asdict(record), reason=str(error))
