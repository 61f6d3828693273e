"""EVACUATE: everybody out, acknowledged by name."""

from __future__ import annotations

from fastapi import APIRouter

from server.api.common import ERRORS, READS, OneMission, Operator, Viewer
from server.mission.mission import Mission
from server.people.audit import AuditedRoute
from server.schemas.alerts import AcknowledgementOut, EvacuationOut

router = APIRouter(
    prefix="/missions/{mission_id}/evacuation",
    tags=["alerts"],
    responses=ERRORS,
    dependencies=READS,
    route_class=AuditedRoute,
)


@router.get("", summary="Does EVACUATE hold?", operation_id="get_evacuation")
async def get_evacuation(mission: OneMission) -> EvacuationOut:
    """Return whether everybody has to leave, and who has heard it."""
    return _out(mission)


@router.post("", summary="EVACUATE", operation_id="order_evacuation")
async def order_evacuation(mission: OneMission, by: Operator) -> EvacuationOut:
    """Order everybody out, on every console and phone; robots go on unless they are stopped."""
    await mission.evacuation.order(by.name)
    return _out(mission)


@router.delete("", summary="EVACUATE is over", operation_id="end_evacuation")
async def end_evacuation(mission: OneMission, by: Operator) -> EvacuationOut:
    """Let people in again."""
    await mission.evacuation.end(by.name)
    return _out(mission)


@router.post("/acknowledge", summary="I have heard EVACUATE", operation_id="acknowledge_evacuation")
async def acknowledge_evacuation(mission: OneMission, by: Viewer) -> EvacuationOut:
    """Keep that you have heard it."""
    await mission.evacuation.acknowledge(by.name)
    return _out(mission)


def _out(mission: Mission) -> EvacuationOut:
    value = mission.evacuation.value()
    heard = [AcknowledgementOut(**item) for item in value.pop("acknowledged")]
    return EvacuationOut(**value, acknowledged=heard)
