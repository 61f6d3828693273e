"""Alerts: what nodes measure that people have to know, and who has taken note of it."""

from __future__ import annotations

from fastapi import APIRouter

from server.api.common import ERRORS, READS, OneMission, Operator
from server.people.audit import AuditedRoute
from server.schemas.nodes import AlertOut, AlertsOut
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
    return AlertsOut(alerts=[AlertOut(**alert_value(alert)) for alert in mission.nodes.alerts()])


@router.post("/{alert_id}/acknowledge", summary="Take note of an alert", operation_id="acknowledge_alert")
async def acknowledge_alert(alert_id: str, mission: OneMission, by: Operator) -> AlertOut:
    """Keep who has taken note of an alert; one that is over leaves the list with that."""
    return AlertOut(**alert_value(await mission.nodes.acknowledge(alert_id, by.name)))
