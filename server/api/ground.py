"""Layers of the ground: how well it was looked at, own maps of robots, where they were heard, memories."""

from __future__ import annotations

from typing import Annotated
from urllib.parse import quote

from fastapi import APIRouter, Header
from fastapi.responses import Response

from server.api.common import ERRORS, READS, OneMission
from server.api.maps import PNG, picture
from server.map_image import MapImage
from server.people.audit import AuditedRoute
from server.schemas.findings import MapOut
from server.schemas.ground import ContactsOut, CoverageOut, MemoriesOut, TagWindowOut, WayOut
from server.sharing import map_value

router = APIRouter(
    prefix="/missions/{mission_id}",
    tags=["map"],
    responses=ERRORS,
    dependencies=READS,
    route_class=AuditedRoute,
)
Known = Annotated[str | None, Header(alias="If-None-Match")]


@router.get("/coverage", summary="How well the ground was looked at", operation_id="get_coverage")
async def get_coverage(mission: OneMission) -> CoverageOut:
    """Return where the picture of it lies, and the areas."""
    image, areas = await mission.ground.coverage()
    return CoverageOut(map=_out(mission.mission_id, image, "coverage.png"), **areas)


@router.get(
    "/coverage.png",
    summary="The same as a picture",
    operation_id="get_coverage_png",
    response_class=Response,
    responses=PNG,
)
async def get_coverage_png(mission: OneMission, known: Known = None) -> Response:
    """Return the picture: 0 unknown, 1 free, 2 safe (a robot was near, in sight), 3 cleared of victims."""
    return picture((await mission.ground.coverage())[0], known)


@router.get("/robots/{robot_id}/map", summary="A robot's own map", operation_id="get_robot_map")
async def get_robot_map(robot_id: str, mission: OneMission) -> MapOut:
    """Return where the picture of what one robot has mapped lies in the world."""
    image = await mission.ground.own_map(robot_id)
    return _out(mission.mission_id, image, f"robots/{quote(robot_id, safe='')}/map.png")


@router.get(
    "/robots/{robot_id}/map.png",
    summary="A robot's own map as a picture",
    operation_id="get_robot_map_png",
    response_class=Response,
    responses=PNG,
)
async def get_robot_map_png(robot_id: str, mission: OneMission, known: Known = None) -> Response:
    """Return the picture: 0 unknown (transparent), 1 free, 2 occupied."""
    return picture(await mission.ground.own_map(robot_id), known)


@router.get("/contact", summary="Where robots were heard", operation_id="get_contact")
async def get_contact(mission: OneMission) -> ContactsOut:
    """Return each robot's way, and where it was heard at once or told of it later."""
    return ContactsOut(robots=[WayOut(**way) for way in await mission.ground.contact()])


@router.get("/memories", summary="What all tags' memories say", operation_id="get_memories")
async def get_memories(mission: OneMission) -> MemoriesOut:
    """Return the ground that each tag's memory tells of, where the tag is on the map."""
    tags = []
    for tag in mission.board.of_kind("tag"):
        told = await mission.memories.told(tag["tag_id"])
        if told is not None:
            place = {name: tag[name] for name in ("tag_id", "x_m", "y_m")}
            tags.append(TagWindowOut(**place, cell_m=told[0]["cell_m"], window=told[0]["window"]))
    return MemoriesOut(tags=tags)


def _out(mission_id: str, image: MapImage, png: str) -> MapOut:
    return MapOut.model_validate(map_value(mission_id, image, png), strict=False)
