"""Missions, STOP for their robots, and what happened in them."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Query

from server.api.common import (
    ERRORS,
    READS,
    AllMissions,
    OneMission,
    Operator,
    Responder,
    RobotOrOperator,
    TheChange,
)
from server.mission.mission import Mission
from server.people.audit import AuditedRoute
from server.schemas.missions import EventOut, EventsOut, MissionIn, MissionOut, MissionsOut, StopIn, StopOut
from server.sharing import event_value

router = APIRouter(
    prefix="/missions", tags=["missions"], responses=ERRORS, dependencies=READS, route_class=AuditedRoute
)


@router.get("", summary="All missions", operation_id="get_missions")
async def get_missions(missions: AllMissions) -> MissionsOut:
    """Return every mission, oldest first."""
    return MissionsOut(missions=[_out(mission) for mission in missions.all()])


@router.post("", status_code=201, summary="Open a mission", operation_id="create_mission")
async def create_mission(
    body: MissionIn, missions: AllMissions, by: RobotOrOperator, change: TheChange
) -> MissionOut:
    """Open a mission; its id is made from the name unless it is given."""
    mission = await missions.open(body.name, body.mission_id, body.tag_key)
    change.subject = mission.mission_id
    return _out(mission)


@router.get("/{mission_id}", summary="One mission", operation_id="get_mission")
async def get_mission(mission: OneMission) -> MissionOut:
    """Return a mission."""
    return _out(mission)


@router.post("/{mission_id}/stop", summary="STOP robots", operation_id="stop_robots")
async def stop_robots(body: StopIn, mission: OneMission, by: Responder, change: TheChange) -> StopOut:
    """Put STOP into every reply to these robots from now on, whether their agents live or not."""
    change.subject = _whom(body)
    return StopOut(stopped=await mission.stops.stop(body.robots, by.name))


@router.post("/{mission_id}/resume", summary="Let robots go on", operation_id="resume_robots")
async def resume_robots(body: StopIn, mission: OneMission, by: Operator, change: TheChange) -> StopOut:
    """Take STOP back."""
    change.subject = _whom(body)
    return StopOut(stopped=await mission.stops.resume(body.robots, by.name))


@router.get("/{mission_id}/events", summary="What happened", operation_id="get_events")
async def get_events(
    mission: OneMission,
    after: Annotated[int, Query(ge=0, description="Only events after this event_id.")] = 0,
    limit: Annotated[int, Query(ge=1, le=1000, description="At most so many.")] = 200,
) -> EventsOut:
    """Return events, oldest first; ask again after the last event_id for more."""
    events = await mission.events.after(after, limit)
    return EventsOut(events=[EventOut(**event_value(event)) for event in events])


def _whom(body: StopIn) -> str:
    return "all robots" if body.robots is None else " ".join(body.robots)


def _out(mission: Mission) -> MissionOut:
    record = mission.roster.record
    return MissionOut(
        mission_id=record.mission_id,
        name=record.name,
        state=record.state,
        created_unix_s=record.created_unix_s,
        robots=len(mission.roster.robots),
    )
