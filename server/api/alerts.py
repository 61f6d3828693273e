"""Alerts: what people have to know, who has taken note of it, and MAYDAY."""

from __future__ import annotations

from fastapi import APIRouter, Response

from server.api.common import ERRORS, READS, OneMission, Operator, Responder, TheChange
from server.errors import unknown
from server.people.audit import AuditedRoute
from server.schemas.alerts import AlertOut, AlertsOut, MaydayIn
from server.sharing import alert_value

router = APIRouter(
    prefix="/missions/{mission_id}/alerts",
    tags=["alerts"],
    responses=ERRORS,
    dependencies=READS,
    route_class=AuditedRoute,
)


@router.get("", summary="All open alerts", operation_id="get_alerts")
async def get_alerts(mission: OneMission) -> AlertsOut:
    """Return the alerts that go on, or that nobody has taken note of yet, the earliest first."""
    return AlertsOut(alerts=[AlertOut(**alert_value(alert)) for alert in mission.alerts.all()])


@router.post("/{alert_id}/acknowledge", summary="Take note of an alert", operation_id="acknowledge_alert")
async def acknowledge_alert(alert_id: str, mission: OneMission, by: Operator) -> AlertOut:
    """Keep who has taken note of an alert; one that is over leaves the list with that."""
    return AlertOut(**alert_value(await mission.alerts.acknowledge(alert_id, by.name)))


@router.post("/mayday", status_code=201, summary="Call MAYDAY", operation_id="call_mayday")
async def call_mayday(
    body: MaydayIn, mission: OneMission, by: Responder, change: TheChange, response: Response
) -> AlertOut:
    """Tell everybody that you need help; again while it goes on changes nothing (200)."""
    change.subject = by.name
    if mission.alerts.is_on("mayday", by.name):
        response.status_code = 200
    said = f": {body.text}" if body.text else ""
    where = f" near tag {body.tag_id}" if body.tag_id else ""
    alert = await mission.alerts.raise_(
        "mayday", by.name, f"MAYDAY from {by.name}{where}{said}.", "alarm", event="mayday", tag_id=body.tag_id
    )
    return AlertOut(**alert_value(alert))


@router.delete("/mayday/{name}", status_code=204, summary="MAYDAY is over", operation_id="end_mayday")
async def end_mayday(name: str, mission: OneMission, by: Responder, change: TheChange) -> None:
    """End somebody's MAYDAY: they themselves, or whoever has seen to it."""
    change.subject = name
    if not mission.alerts.is_on("mayday", name):
        raise unknown("mayday", name)
    await mission.alerts.end(
        "mayday", name, f"MAYDAY from {name} is over, says {by.name}.", event="mayday_over"
    )
