"""Whether the server is there."""

from __future__ import annotations

import time

from fastapi import APIRouter, Request

from server import VERSION
from server.api.common import AllMissions
from server.schemas.missions import HealthOut

router = APIRouter(tags=["health"])


@router.get("/health", summary="Is the server there?", operation_id="get_health")
@router.head("/health", include_in_schema=False)
async def get_health(request: Request, missions: AllMissions) -> HealthOut:
    """Answer as soon as requests are served."""
    uptime_s = time.monotonic() - request.app.state.started_s
    return HealthOut(status="ok", version=VERSION, missions=len(missions), uptime_s=uptime_s)
