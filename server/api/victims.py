"""Victims: measured by robots, judged by people."""

from __future__ import annotations

from fastapi import APIRouter

from db.victim_records import StartRecord
from server.api.common import ERRORS, READS, OneMission, Responder, TheChange
from server.people.audit import AuditedRoute
from server.schemas.victims import VictimIn, VictimOut, VictimsOut
from server.sharing import victim_value

router = APIRouter(
    prefix="/missions/{mission_id}/victims",
    tags=["victims"],
    responses=ERRORS,
    dependencies=READS,
    route_class=AuditedRoute,
)


@router.get("", summary="All victims", operation_id="get_victims")
async def get_victims(mission: OneMission) -> VictimsOut:
    """Return every victim."""
    return VictimsOut(victims=[VictimOut(**victim_value(victim)) for victim in mission.victims.all()])


@router.get("/{victim_id}", summary="One victim", operation_id="get_victim")
async def get_victim(victim_id: str, mission: OneMission) -> VictimOut:
    """Return a victim."""
    return VictimOut(**victim_value(mission.victims.get(victim_id)))


@router.patch("/{victim_id}", summary="Say something about a victim", operation_id="judge_victim")
async def judge_victim(
    victim_id: str, body: VictimIn, mission: OneMission, by: Responder, change: TheChange
) -> VictimOut:
    """Say what you found out about a victim; what is left out stays, and robots never change it."""
    words = body.model_dump(exclude_unset=True)
    if body.start is not None:
        words["start"] = StartRecord(**body.start.model_dump())
    if body.place_m is not None:
        words["place_m"] = (body.place_m.x_m, body.place_m.y_m)
    change.before = mission.victims.get(victim_id).said.value()
    victim = await mission.victims.say(victim_id, words, by.name)
    change.after = victim.said.value()
    return VictimOut(**victim_value(victim))
