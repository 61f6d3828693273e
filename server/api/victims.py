"""Victims: measured by robots, judged by people."""

from __future__ import annotations

from fastapi import APIRouter

from server.api.common import ERRORS, READS, OneMission, Responder, TheChange
from server.mission.victims import judgement
from server.people.audit import AuditedRoute
from server.schemas.findings import VictimIn, VictimOut, VictimsOut
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


@router.patch("/{victim_id}", summary="Judge a victim", operation_id="judge_victim")
async def judge_victim(
    victim_id: str, body: VictimIn, mission: OneMission, by: Responder, change: TheChange
) -> VictimOut:
    """Set a victim's status; robots never change what a person said."""
    change.before = judgement(mission.victims.get(victim_id))
    victim = await mission.victims.judge(victim_id, body.status, body.note, by.name)
    change.after = judgement(victim)
    return VictimOut(**victim_value(victim))
