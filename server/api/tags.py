"""Tags: where they are, and what their memory says."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter, Request, Response

from robots.tags.memory import CELLS_M, TagMemoryError
from server.api.common import ERRORS, READS, OneMission, RobotOrOperator
from server.errors import ApiError, unknown
from server.mission.mission import Mission
from server.people.audit import AuditedRoute
from server.schemas.common import Name
from server.schemas.findings import MemoryOut, TagOut, TagsOut
from server.schemas.nodes import NodeOut

router = APIRouter(
    prefix="/missions/{mission_id}/tags",
    tags=["tags"],
    responses=ERRORS,
    dependencies=READS,
    route_class=AuditedRoute,
)
_BYTES = "application/octet-stream"
_MEMORY = {200: {"content": {_BYTES: {"schema": {"type": "string", "format": "binary"}}}}}


@router.get("", summary="All tags", operation_id="get_tags", response_model_exclude_unset=True)
async def get_tags(mission: OneMission) -> TagsOut:
    """Return the tags in the world frame, and the pairs driven one after the other."""
    links = (mission.board.get("links") or {}).get("pairs", [])
    tags = [_tag(mission, value) for value in mission.board.of_kind("tag")]
    return TagsOut(tags=tags, links=[(first, second) for first, second in links])


@router.get("/{tag_id}", summary="One tag", operation_id="get_tag", response_model_exclude_unset=True)
async def get_tag(tag_id: str, mission: OneMission) -> TagOut:
    """Return a tag in the world frame."""
    value = mission.board.get(f"tag/{tag_id}")
    if value is None:
        raise unknown("tag", tag_id)
    return _tag(mission, value)


@router.get("/{tag_id}/sensors", summary="What a node measures", operation_id="get_sensors")
async def get_sensors(tag_id: str, mission: OneMission) -> NodeOut:
    """Return what an active node measured last, also while its place is not known yet."""
    value = mission.board.get(f"node/{tag_id}")
    if value is None:
        raise unknown("node", tag_id)
    return NodeOut(**value)


@router.get(
    "/{tag_id}/memory",
    summary="What a tag's memory says",
    operation_id="get_memory",
    response_class=Response,
    responses=_MEMORY,  # type: ignore[arg-type]
)
async def get_memory(tag_id: str, mission: OneMission) -> Response:
    """Return the memory's bytes as far as the server knows them."""
    memory = await mission.memories.of(tag_id)
    if memory is None:
        raise unknown("tag", tag_id)
    return Response(memory, media_type=_BYTES)


@router.get("/{tag_id}/memory/content", summary="A tag's memory in words", operation_id="get_memory_content")
async def get_memory_content(tag_id: str, mission: OneMission) -> MemoryOut:
    """Return what a tag's memory says of the ground round it, of victims, notes and those who passed."""
    told = await mission.memories.told(tag_id)
    if told is None:
        if mission.board.get(f"tag/{tag_id}") is None and mission.board.get(f"node/{tag_id}") is None:
            raise unknown("tag", tag_id)
        sentences = ["Nobody has read or written its memory yet."]
        return MemoryOut(tag_id=tag_id, cell_m=CELLS_M[0], memory=None, sentences=sentences)
    return MemoryOut(tag_id=tag_id, cell_m=told[0]["cell_m"], memory=told[0], sentences=told[1])


@router.post(
    "/{tag_id}/memory",
    summary="Merge a tag's memory",
    operation_id="merge_memory",
    response_class=Response,
    responses=_MEMORY,  # type: ignore[arg-type]
    openapi_extra={
        "requestBody": {
            "required": True,
            "content": {_BYTES: {"schema": {"type": "string", "format": "binary"}}},
        }
    },
)
async def merge_memory(tag_id: Name, request: Request, mission: OneMission, by: RobotOrOperator) -> Response:
    """Merge the bytes that were read from a tag with what is known of it, and return the result."""
    try:
        merged = await mission.memories.merge(tag_id, await request.body(), by.name)
    except TagMemoryError as error:
        raise ApiError(422, "invalid_memory", f"The body is no tag memory: {error}.") from error
    return Response(merged, media_type=_BYTES)


def _tag(mission: Mission, value: dict[str, Any]) -> TagOut:
    node = mission.board.get(f"node/{value['tag_id']}")
    return TagOut(**value) if node is None else TagOut(**value, sensors=NodeOut(**node))
