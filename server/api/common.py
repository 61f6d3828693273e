"""What the routers share: how a request finds its mission, and the errors they all have."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import Depends, Path, Request

from server.mission.mission import Mission
from server.missions import Missions
from server.schemas.common import ErrorWire

ERRORS: dict[int | str, dict[str, Any]] = {
    404: {"model": ErrorWire, "description": "There is no such thing."},
    409: {"model": ErrorWire, "description": "It contradicts what is there."},
    413: {"model": ErrorWire, "description": "The body is too large."},
    422: {"model": ErrorWire, "description": "A field is wrong; `field` names it."},
    503: {"model": ErrorWire, "description": "Not now; send again after `Retry-After` seconds."},
}


def all_missions(request: Request) -> Missions:
    """Return the missions of this application."""
    missions: Missions = request.app.state.missions
    return missions


AllMissions = Annotated[Missions, Depends(all_missions)]


def _mission(
    mission_id: Annotated[str, Path(description="The mission's id.")], missions: AllMissions
) -> Mission:
    return missions.get(mission_id)


OneMission = Annotated[Mission, Depends(_mission)]
