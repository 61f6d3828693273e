"""What the routers share: how a request finds its mission, and the errors they all have."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

from fastapi import Depends, Path, Request
from starlette.requests import HTTPConnection

from db.people_records import Role
from server.errors import ApiError
from server.mission.mission import Mission
from server.missions import Missions
from server.people.access import Access
from server.people.actor import Actor
from server.people.audit import Change
from server.schemas.common import ErrorWire

ERRORS: dict[int | str, dict[str, Any]] = {
    401: {"model": ErrorWire, "description": "Log in first, or show a robot's token."},
    403: {"model": ErrorWire, "description": "Your role, or the robot's token, is not for this."},
    404: {"model": ErrorWire, "description": "There is no such thing."},
    409: {"model": ErrorWire, "description": "It contradicts what is there."},
    413: {"model": ErrorWire, "description": "The body is too large."},
    422: {"model": ErrorWire, "description": "A field is wrong; `field` names it."},
    503: {"model": ErrorWire, "description": "Not now; send again after `Retry-After` seconds."},
}


async def all_missions(request: Request) -> Missions:
    """Return the missions of this application."""
    missions: Missions = request.app.state.missions
    return missions


AllMissions = Annotated[Missions, Depends(all_missions)]


AS_OF = "Waymark-As-Of"
"""Header: a Unix time of the server's. A file of then or before may lack what was taken until then; a later
one without it says that it was taken off again."""
ON_ONE_THAT_IS_OVER = {
    "start_mission", "pause_mission", "close_mission", "archive_mission", "reopen_mission",
    "stop_robots", "resume_robots", "order_evacuation", "end_evacuation", "acknowledge_evacuation",
    "acknowledge_alert", "call_mayday", "end_mayday", "make_best_map", "post_observations", "locate_by_radio",
    "put_report",
}  # fmt: skip
"""Changes that a closed mission takes: people's safety, and what settles or says by itself how it stands."""


async def _mission(
    mission_id: Annotated[str, Path(description="The mission's id.")],
    missions: AllMissions,
    request: Request,
) -> Mission:
    mission = missions.get(mission_id)
    if request.method not in ("GET", "HEAD") and request.scope["route"].name not in ON_ONE_THAT_IS_OVER:
        mission.lifecycle.check_open()
    return mission


OneMission = Annotated[Mission, Depends(_mission)]


async def access_of(connection: HTTPConnection) -> Access:
    """Return the door of this application."""
    access: Access = connection.app.state.access
    return access


TheAccess = Annotated[Access, Depends(access_of)]


async def _actor(connection: HTTPConnection, access: TheAccess) -> Actor:
    actor = access.actor_of(connection)
    connection.state.actor = actor  # for the audit log
    return actor


@dataclass(frozen=True, slots=True)
class Needs:
    """A dependency that lets in who has this role or one above, and with ``robots`` robots too."""

    role: Role
    robots: bool = False

    async def __call__(self, connection: HTTPConnection, actor: Annotated[Actor, Depends(_actor)]) -> Actor:
        """Return who it is.

        Raises:
            ApiError: their role, or the robot's token, is not for this.
        """
        mission_id, robot_id = (connection.path_params.get(name) for name in ("mission_id", "robot_id"))
        if actor.is_robot:
            if not (self.robots or self.role == "viewer"):
                message = f"A robot's token is not for this; {_ASK[self.role]}."
                raise ApiError(403, "not_for_robots", message)
            if not actor.is_for(mission_id, robot_id):
                message = "This token is for another mission or robot; ask a commander for one for this."
                raise ApiError(403, "other_scope", message)
        elif not actor.may(self.role):
            message = (
                f"This is for the role {self.role} and above, and yours is {actor.role}; {_ASK[self.role]}."
            )
            raise ApiError(403, "role_too_low", message)
        return actor


_ASK: dict[Role, str] = {
    "viewer": "log in",
    "responder": "ask a commander for a role",
    "operator": "ask an operator to do it, or a commander for the role",
    "commander": "ask a commander to do it",
}
READS = [Depends(Needs("viewer"))]
"""What every router of a mission asks for, whatever its routes ask for besides."""
Viewer = Annotated[Actor, Depends(Needs("viewer"))]
Responder = Annotated[Actor, Depends(Needs("responder"))]
Operator = Annotated[Actor, Depends(Needs("operator"))]
Commander = Annotated[Actor, Depends(Needs("commander"))]
RobotOrOperator = Annotated[Actor, Depends(Needs("operator", robots=True))]


async def change_of(request: Request) -> Change:
    """Return what the audit log will say of the change that this request makes."""
    change = request.state.change = Change()
    return change


TheChange = Annotated[Change, Depends(change_of)]
