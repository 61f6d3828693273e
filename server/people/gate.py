"""Who may look at a mission in 3D."""

from __future__ import annotations

import asyncio

from starlette.requests import HTTPConnection

from server.errors import ApiError
from server.people.access import Access


def gate(connection: HTTPConnection, mission_id: str) -> asyncio.Event | None:
    """Return what is set once a connection may see the mission no more; None where it may not at all."""
    access: Access = connection.app.state.access
    try:
        actor = access.actor_of(connection)
    except ApiError:
        return None
    return actor.over if actor.is_for(mission_id) else None
