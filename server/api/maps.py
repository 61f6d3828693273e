"""The fused map as a picture, and the robots' tag graphs."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Header, Response

from server.api.common import ERRORS, READS, OneMission
from server.errors import ApiError
from server.graph_wire import graph_out
from server.map_image import MapImage
from server.mission.mission import Mission
from server.people.audit import AuditedRoute
from server.schemas.findings import GraphsOut, MapOut
from server.sharing import map_value

router = APIRouter(
    prefix="/missions/{mission_id}",
    tags=["map"],
    responses=ERRORS,
    dependencies=READS,
    route_class=AuditedRoute,
)
PNG: dict[int | str, dict[str, Any]] = {
    200: {"content": {"image/png": {"schema": {"type": "string", "format": "binary"}}}},
    304: {"description": "The picture that you have is the latest."},
}


@router.get("/map", summary="The map's place and version", operation_id="get_map")
async def get_map(mission: OneMission) -> MapOut:
    """Return where the map's picture lies in the world."""
    return MapOut.model_validate(map_value(mission.mission_id, _image(mission)), strict=False)


@router.get("/map.png", summary="The map", operation_id="get_map_png", response_class=Response, responses=PNG)
async def get_map_png(mission: OneMission, if_none_match: Annotated[str | None, Header()] = None) -> Response:
    """Return the latest picture: 0 unknown (transparent), 1 free, 2 occupied.

    The top row has the largest y.
    """
    return picture(_image(mission), if_none_match)


@router.get("/graph", summary="The tag graphs", operation_id="get_graph")
async def get_graph(mission: OneMission) -> GraphsOut:
    """Return every robot's tag graph in its own map frame."""
    graphs = [
        graph_out(robot.robot_id, robot.graph)
        for robot in mission.roster.robots.values()
        if robot.graph is not None
    ]
    return GraphsOut(graphs=graphs)


def picture(image: MapImage, if_none_match: str | None) -> Response:
    """Return a picture, or 304 to who has it already."""
    headers = {"ETag": image.etag, "Cache-Control": "no-cache"}
    if if_none_match is not None and image.etag in [tag.strip() for tag in if_none_match.split(",")]:
        return Response(status_code=304, headers=headers)
    return Response(image.png, media_type="image/png", headers=headers)


def _image(mission: Mission) -> MapImage:
    image = mission.shared_map.image
    if image is None:
        raise ApiError(404, "no_map", "There is no map yet; it comes with the first scans.")
    return image
