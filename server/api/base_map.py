"""The map that was there before the mission: a floor plan, or what another mission came to."""

from __future__ import annotations

import asyncio
from typing import Annotated, Any

from fastapi import APIRouter, Header, Query, Request, Response

from server.api.common import ERRORS, READS, AllMissions, OneMission, Operator, TheChange
from server.api.maps import PNG, picture
from server.base_map import BaseMapError, MapWords, grid_of, grid_of_image, words_of
from server.errors import ApiError
from server.mission.mission import Mission
from server.people.audit import AuditedRoute
from server.schemas.base_map import BaseMapOut, CopyIn, PlanQuery

router = APIRouter(
    prefix="/missions/{mission_id}",
    tags=["map"],
    responses=ERRORS,
    dependencies=READS,
    route_class=AuditedRoute,
)
SUBJECT = "the base map"
_BINARY = {"schema": {"type": "string", "format": "binary"}}
_KINDS = ("image/png", "image/x-portable-graymap", "image/jpeg", "image/webp")


@router.get("/base-map", summary="The base map", operation_id="get_base_map")
async def get_base_map(mission: OneMission) -> BaseMapOut:
    """Return where the base map lies in the world, and what it is."""
    return _out(mission)


@router.get(
    "/base-map.png",
    summary="The base map's picture",
    operation_id="get_base_map_png",
    response_class=Response,
    responses=PNG,
)
async def get_base_map_png(
    mission: OneMission, if_none_match: Annotated[str | None, Header()] = None
) -> Response:
    """Return its picture: 0 unknown (transparent), 1 free, 2 occupied."""
    return picture(mission.base_map.get(), if_none_match)


@router.put(
    "/base-map",
    summary="Lay a plan under the map",
    operation_id="put_base_map",
    openapi_extra={"requestBody": {"required": True, "content": dict.fromkeys(_KINDS, _BINARY)}},
)
async def put_base_map(
    request: Request,
    mission: OneMission,
    plan: Annotated[PlanQuery, Query()],
    by: Operator,
    change: TheChange,
) -> BaseMapOut:
    """Keep a plan: the body is its picture (PNG, PGM, JPEG, WebP), the address has its YAML or numbers."""
    change.subject = SUBJECT
    try:
        if plan.yaml is not None:
            words = words_of(plan.yaml)
        elif plan.resolution_m is not None:
            origin = (plan.origin_x_m, plan.origin_y_m, plan.origin_yaw_rad)
            words = MapWords(plan.resolution_m, origin, plan.negate, plan.occupied_thresh, plan.free_thresh)
        else:
            raise BaseMapError("say how large a pixel is: give yaml or resolution_m")
        grid = await asyncio.to_thread(grid_of, await request.body(), words)
    except BaseMapError as error:
        text = str(error)
        raise ApiError(422, "no_plan", f"{text[0].upper()}{text[1:]}.") from error
    change.before = _place(mission)
    await mission.base_map.set(grid, plan.source, by.name)
    change.after = _place(mission)
    return _out(mission)


@router.post("/base-map/copy", summary="Take another mission's map", operation_id="copy_base_map")
async def copy_base_map(
    body: CopyIn, mission: OneMission, missions: AllMissions, by: Operator, change: TheChange
) -> BaseMapOut:
    """Lay another mission's best map under this one, its latest where it has none, and lie where it lies."""
    other = missions.get(body.mission_id)
    change.subject = SUBJECT
    image = other.best_map.image or other.shared_map.image
    if image is None:
        raise ApiError(409, "no_map", f"{other.roster.record.name} has no map to take over.", "mission_id")
    change.before = _place(mission)
    await mission.base_map.set(
        await asyncio.to_thread(grid_of_image, image), other.roster.record.name, by.name
    )
    await mission.georeferences.take_over(other.georeferences, by.name)
    change.after = _place(mission)
    return _out(mission)


@router.delete("/base-map", status_code=204, summary="Take the base map away", operation_id="delete_base_map")
async def delete_base_map(mission: OneMission, by: Operator, change: TheChange) -> None:
    """Take the base map away; the map that robots made stays. That can be taken back."""
    change.subject = SUBJECT
    change.before = _place(mission)
    await mission.base_map.remove(by.name)
    change.after = _place(mission)


def _place(mission: Mission) -> dict[str, Any]:
    """Return base map and georeference, for the log of changes: a copy brings both."""
    return {"base_map": mission.base_map.value(), "georeference": mission.georeferences.value()}


def _out(mission: Mission) -> BaseMapOut:
    mission.base_map.get()
    return BaseMapOut.model_validate(mission.board.get("base_map"), strict=False)
