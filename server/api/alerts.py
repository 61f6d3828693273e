"""Alerts: what people have to know, who has taken note of it, and MAYDAY."""

from __future__ import annotations

from fastapi import APIRouter, Response

from server.api.common import ERRORS, READS, OneMission, Operator, TheChange, Viewer
from server.errors import ApiError, unknown
from server.mission.mayday import call_for_help, is_repeated
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
    body: MaydayIn, mission: OneMission, by: Viewer, change: TheChange, response: Response
) -> AlertOut:
    """Tell everybody that you need help, whatever your role and however the mission stands.

    Again it is told anew, unless it says nothing new and nobody has taken note yet (200).
    """
    change.subject = by.name
    if by.is_robot:
        raise ApiError(403, "not_for_robots", "MAYDAY is for people; a robot in need is an alert by itself.")
    known = mission.alerts.get("mayday", by.name)
    if known is not None and is_repeated(mission.alerts, by.name, body.text, body.tag_id):
        response.status_code = 200
        return AlertOut(**alert_value(known))
    return AlertOut(**alert_value(await call_for_help(mission.alerts, by.name, body.text, body.tag_id)))


@router.delete("/mayday/{name}", status_code=204, summary="MAYDAY is over", operation_id="end_mayday")
async def end_mayday(name: str, mission: OneMission, by: Viewer, change: TheChange) -> None:
    """End somebody's MAYDAY: they themselves, or whoever has seen to it, a responder or above."""
    change.subject = name
    if by.is_robot or not (name == by.name or by.may("responder")):
        message = "Only your own MAYDAY is yours to end; ask a commander for a role."
        raise ApiError(403, "role_too_low", message)
    if not mission.alerts.is_on("mayday", name):
        raise unknown("mayday", name)
    await mission.alerts.end(
        "mayday", name, f"MAYDAY from {name} is over, says {by.name}.", event="mayday_over"
    )
