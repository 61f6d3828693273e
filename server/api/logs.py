"""A mission's log as one file."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter
from fastapi.responses import StreamingResponse

from server.api.common import ERRORS, READS, AllMissions, OneMission
from server.mission_log import mission_log
from server.people.audit import AuditedRoute

router = APIRouter(
    prefix="/missions/{mission_id}",
    tags=["missions"],
    responses=ERRORS,
    dependencies=READS,
    route_class=AuditedRoute,
)
_GZIP: dict[int | str, dict[str, Any]] = {
    200: {"content": {"application/gzip": {"schema": {"type": "string", "format": "binary"}}}}
}


@router.get(
    "/log",
    summary="The mission's log",
    operation_id="get_log",
    response_class=StreamingResponse,
    responses=_GZIP,
)
async def get_log(mission: OneMission, missions: AllMissions) -> StreamingResponse:
    """Return every robot's configuration and all that it observed, for `waymark replay log`.

    Robots may go on meanwhile. A file that breaks off is found out by its missing last line.
    """
    name = f"{mission.mission_id}.waymark-log.gz"
    return StreamingResponse(
        mission_log(missions.store, mission.roster.record),
        media_type="application/gzip",
        headers={"Content-Disposition": f'attachment; filename="{name}"'},
    )
