"""A mission's past: which chunks there are, each of them, the state at a moment, and the map's pictures."""

from __future__ import annotations

import gzip
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Header, Path, Query, Response

from server.api.common import ERRORS, READS, AllMissions, OneMission
from server.errors import ApiError
from server.history.film import make_film
from server.history.past import Past
from server.people.audit import AuditedRoute
from server.schemas.history import ChunkOut, HistoryOut, HistoryStateOut

router = APIRouter(
    prefix="/missions/{mission_id}/history",
    tags=["history"],
    responses=ERRORS,
    dependencies=READS,
    route_class=AuditedRoute,
)
_LARGEST = 2**53 - 1
_FOR_EVER = "private, max-age=31536000, immutable"
_CHUNK: dict[int | str, dict[str, Any]] = {200: {"content": {"application/json": {}}}}
_FILM: dict[int | str, dict[str, Any]] = {
    200: {"content": {"application/octet-stream": {"schema": {"type": "string", "format": "binary"}}}}
}
_PNG: dict[int | str, dict[str, Any]] = {
    200: {"content": {"image/png": {"schema": {"type": "string", "format": "binary"}}}}
}


async def _past(mission: OneMission, missions: AllMissions) -> Past:
    return Past(missions.store, mission.mission_id)


OnePast = Annotated[Past, Depends(_past)]


@router.get("", summary="What is known of the past", operation_id="get_history")
async def get_history(past: OnePast) -> HistoryOut:
    """Return which chunks there are. A chunk is the whole state at its beginning, then what changed."""
    spans = await past.spans()
    return HistoryOut(
        begins_unix_s=spans[0].begins_unix_s if spans else None,
        ends_unix_s=spans[-1].ends_unix_s if spans else None,
        chunks=[
            ChunkOut(number=s.number, begins_unix_s=s.begins_unix_s, ends_unix_s=s.ends_unix_s) for s in spans
        ],
    )


@router.get(
    "/chunks/{number}",
    summary="A chunk of the past",
    operation_id="get_history_chunk",
    response_class=Response,
    responses=_CHUNK,
)
async def get_history_chunk(
    number: Annotated[int, Path(ge=0, le=_LARGEST, description="As `GET history` lists it.")],
    past: OnePast,
    accept_encoding: Annotated[str, Header()] = "",
) -> Response:
    """Return `{"begins_unix_s", "state", "changes": [{"unix_s", "set", "patch", "splice", "delete"}]}`.

    Begin with `state`, keys as on the stream. Each change sets keys, puts new fields into the values of those
    in `patch`, replaces lists of those in `splice` by the first `front` of their elements, `middle`, and the
    last `back` (`[front, back, middle]`), and deletes keys. A chunk that is whole never changes again.
    """
    found = await past.chunk(number)
    if found is None:
        text = f"There is no chunk {number}; GET history lists those that there are."
        raise ApiError(404, "unknown_chunk", text, "number")
    body, is_whole = found
    headers = {"Cache-Control": _FOR_EVER if is_whole else "no-cache", "Vary": "Accept-Encoding"}
    if "gzip" in accept_encoding:
        headers["Content-Encoding"] = "gzip"
    else:
        body = gzip.decompress(body)
    return Response(body, media_type="application/json", headers=headers)


@router.get("/state", summary="The state at a moment", operation_id="get_history_state")
async def get_history_state(
    past: OnePast,
    unix_s: Annotated[
        float, Query(ge=0.0, le=1e11, allow_inf_nan=False, description="The moment, seconds since 1970.")
    ],
) -> HistoryStateOut:
    """Return what the mission showed then."""
    found = await past.state_at(unix_s)
    if found is None:
        text = "Nothing is known of that moment: it is before the mission's first; GET history tells that."
        raise ApiError(404, "before_the_first", text, "unix_s")
    return HistoryStateOut(unix_s=found[0], state=found[1])


@router.get(
    "/recording.viser",
    summary="The mission in 3D over time",
    operation_id="get_recording",
    response_class=Response,
    responses=_FILM,
)
async def get_recording(mission: OneMission, missions: AllMissions) -> Response:
    """Return a recording for viser's player, at `/viser/MISSION/?playbackPath=` and this address.

    It takes seconds to minutes; robots and consoles do not notice.
    """
    await mission.history.catch_up()
    film = await make_film(missions.store, mission.mission_id)
    headers = {
        "Cache-Control": "no-store",
        "Content-Disposition": f'attachment; filename="{mission.mission_id}.viser"',
    }
    return Response(film, media_type="application/octet-stream", headers=headers)


@router.get(
    "/maps/{version}.png",
    summary="A map of the past",
    operation_id="get_history_map",
    response_class=Response,
    responses=_PNG,
)
async def get_history_map(
    version: Annotated[int, Path(ge=0, le=_LARGEST, description="`version` of `map` in the state.")],
    past: OnePast,
) -> Response:
    """Return the map's picture as it was then, as `map.png` returns the latest."""
    png = await past.picture(version)
    if png is None:
        text = f"No picture of the map's version {version} was kept; take the version of a state of the past."
        raise ApiError(404, "unknown_map", text, "version")
    return Response(png, media_type="image/png", headers={"Cache-Control": _FOR_EVER})
