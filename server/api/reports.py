"""Reports from the field, each counted once."""

from __future__ import annotations

import time
from typing import Annotated
from uuid import UUID

from fastapi import APIRouter, Query, Response

from db.reports import ReportRecord
from server.api.common import AS_OF, ERRORS, READS, OneMission, TheChange, Viewer
from server.errors import ApiError
from server.people.audit import AuditedRoute
from server.schemas.reports import ReportIn, ReportOut, ReportsOut

router = APIRouter(
    prefix="/missions/{mission_id}/reports",
    tags=["reports"],
    responses=ERRORS,
    dependencies=READS,
    route_class=AuditedRoute,
)


@router.get("", summary="Reports from the field", operation_id="get_reports")
async def get_reports(
    mission: OneMission,
    limit: Annotated[int, Query(ge=1, le=10_000, description="At most so many.")] = 200,
) -> ReportsOut:
    """Return the latest reports, the newest first."""
    return ReportsOut(reports=[_out(record) for record in await mission.reports.latest(limit)])


@router.put("/{report_id}", status_code=201, summary="Report", operation_id="put_report")
async def put_report(
    report_id: UUID, body: ReportIn, mission: OneMission, by: Viewer, change: TheChange, response: Response
) -> ReportOut:
    """Take a report. Whoever writes it makes its id: sent again, it is answered (200) and changes nothing.

    MAYDAY, and that EVACUATE was heard, are taken from all people, and also where the mission is over.
    """
    is_help = body.kind in ("mayday", "heard")
    if by.is_robot or not (is_help or by.may("responder")):
        message = (
            f"Reports are for responders and above, and yours is the role {by.role};"
            " ask a commander for another. It stays on your phone."
        )
        raise ApiError(403, "role_too_low", message)
    if not is_help and not await mission.reports.has(report_id):
        mission.lifecycle.check_open()
    record, is_new = await mission.reports.take(report_id, body, by.name)
    change.subject = f"{record.kind} {record.report_id}"
    response.headers[AS_OF] = f"{time.time():.3f}"
    if not is_new:
        response.status_code = 200
    return _out(record)


def _out(record: ReportRecord) -> ReportOut:
    return ReportOut(**{name: getattr(record, name) for name in ReportRecord.__slots__})
