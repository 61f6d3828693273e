"""Missions, STOP for their robots, and what happened in them."""

from __future__ import annotations

import time
from collections import Counter
from dataclasses import asdict
from typing import Annotated

from fastapi import APIRouter, Query

from server.api.common import (
    ERRORS,
    READS,
    AllMissions,
    Commander,
    OneMission,
    Operator,
    Responder,
    RobotOrOperator,
    TheChange,
)
from server.mission.mission import Mission
from server.mission.progress import figures
from server.people.audit import AuditedRoute
from server.schemas.missions import (
    EffortWire,
    EventOut,
    EventsOut,
    MissionIn,
    MissionOut,
    MissionsOut,
    ProgressWire,
    StopIn,
    StopOut,
    SummaryOut,
)
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
    """Open a mission, running or as a draft; its id is made from the name unless it is given."""
    mission = await missions.open(body.name, body.mission_id, body.tag_key, body.state, by.name)
    change.subject = mission.mission_id
    return _out(mission)


@router.get("/{mission_id}", summary="One mission", operation_id="get_mission")
async def get_mission(mission: OneMission) -> MissionOut:
    """Return a mission."""
    return _out(mission)


@router.get("/{mission_id}/summary", summary="A mission in figures", operation_id="get_mission_summary")
async def get_mission_summary(mission: OneMission, missions: AllMissions) -> SummaryOut:
    """Return what a mission has come to, and how it got there, to compare it with others."""
    board, kept = mission.board, missions.store.findings
    victims = Counter(v["status"] for v in board.of_kind("victim") if not v["merged_into"])
    return SummaryOut(
        mission=_out(mission),
        robots=[
            EffortWire(robot_id=r["robot_id"], distance_m=r["distance_m"], explored_m2=r["explored_m2"])
            for r in board.of_kind("robot")
        ],
        victims=dict(victims),
        alerts=await kept.alarms_of(mission.mission_id),
        progress=[ProgressWire(**asdict(sample)) for sample in await mission.progress.all()],
    )


@router.post("/{mission_id}/start", summary="Start a mission", operation_id="start_mission")
async def start_mission(mission_id: str, missions: AllMissions, by: Operator) -> MissionOut:
    """Let a draft, or a mission that is paused, run: robots go on with what they were at."""
    return _out(await missions.take(mission_id, "start", by.name))


@router.post("/{mission_id}/pause", summary="Pause a mission", operation_id="pause_mission")
async def pause_mission(mission_id: str, missions: AllMissions, by: Operator) -> MissionOut:
    """Have all robots stand still, as every reply to them says, while what they observe is logged on."""
    return _out(await missions.take(mission_id, "pause", by.name))


@router.post("/{mission_id}/close", summary="Close a mission", operation_id="close_mission")
async def close_mission(mission_id: str, missions: AllMissions, by: Commander) -> MissionOut:
    """End a mission: it can be read, nothing in it changes, and its robots are refused.

    Refused itself while robots drive in it: pause it first.
    """
    return _out(await missions.take(mission_id, "close", by.name))


@router.post("/{mission_id}/archive", summary="Archive a mission", operation_id="archive_mission")
async def archive_mission(mission_id: str, missions: AllMissions, by: Commander) -> MissionOut:
    """Put a closed mission out of sight; it can still be read."""
    return _out(await missions.take(mission_id, "archive", by.name))


@router.post("/{mission_id}/reopen", summary="Reopen a mission", operation_id="reopen_mission")
async def reopen_mission(mission_id: str, missions: AllMissions, by: Commander) -> MissionOut:
    """Bring a mission that is over back, paused: nothing drives off before somebody starts it."""
    return _out(await missions.take(mission_id, "reopen", by.name))


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
        state_by=record.state_by,
        state_unix_s=record.state_unix_s,
        created_unix_s=record.created_unix_s,
        started_unix_s=record.started_unix_s,
        duration_s=record.duration_s(time.time()),
        robots=len(mission.roster.robots),
        **figures(mission.board),
    )
