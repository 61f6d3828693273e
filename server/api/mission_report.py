"""The report of a mission, to hand over."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter, Response

from server.api.common import ERRORS, READS, AllMissions, OneMission
from server.people.audit import AuditedRoute
from server.report.make import make_report
from server.report.page import content_security_policy

router = APIRouter(
    prefix="/missions/{mission_id}",
    tags=["missions"],
    responses=ERRORS,
    dependencies=READS,
    route_class=AuditedRoute,
)
_HTML: dict[int | str, dict[str, Any]] = {200: {"content": {"text/html": {"schema": {"type": "string"}}}}}


@router.get(
    "/report.html",
    summary="The mission's report",
    operation_id="get_report_page",
    response_class=Response,
    responses=_HTML,
)
async def get_report_page(mission: OneMission, missions: AllMissions) -> Response:
    """Return plan, film, victims, robots, alerts, notes, tags and timeline as one file.

    It needs nothing beside itself, and prints on A4.
    """
    await mission.history.catch_up()
    page = await make_report(missions.store, mission.roster.record)
    headers = {
        "Content-Security-Policy": content_security_policy(),
        "X-Content-Type-Options": "nosniff",
        "Cache-Control": "no-store",
        "Content-Disposition": f'inline; filename="{mission.mission_id}-report.html"',
    }
    return Response(page, media_type="text/html", headers=headers)
