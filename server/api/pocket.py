"""A mission as a phone carries it."""

from __future__ import annotations

import asyncio
from typing import Annotated, Any

from fastapi import APIRouter, Header, Query, Response

from server.api.common import AS_OF, ERRORS, READS, OneMission
from server.people.audit import AuditedRoute
from server.schemas.pocket import PocketOut

router = APIRouter(
    prefix="/missions/{mission_id}/pocket",
    tags=["routes"],
    responses=ERRORS,
    dependencies=READS,
    route_class=AuditedRoute,
)
_ANSWERS: dict[int | str, dict[str, Any]] = {
    200: {"model": PocketOut},
    304: {"description": "What you have is the latest."},
}


@router.get("", summary="A mission in one file", operation_id="get_pocket", responses=_ANSWERS)
async def get_pocket(
    mission: OneMission,
    if_none_match: Annotated[str | None, Header()] = None,
    accept_encoding: Annotated[str, Header()] = "",
    have: Annotated[
        str, Query(max_length=200, description="Names of `parts` to leave out, with commas between.")
    ] = "",
) -> Response:
    """Return all that a phone needs to answer without the server: plan, tags, ways, victims, notes.

    Routes over `ways` cost their length in centimetres, what each counts more for being narrow, and 5,000 for
    each hazard within 2 m; `ends` of what is looked for are the tags from which it is in sight, with the
    centimetres still to go. `parts` names the two that are large: `ground`, which is `tags` and `ways`, and
    `plan`, which is `map`; who has one under that name, says so in `have`, and is not sent it again.
    The header `Waymark-As-Of` says, also of what you have, as of when it is the latest, in Unix seconds.
    """
    pack, as_of_unix_s = await mission.pocket.pack()
    headers = {"ETag": pack.etag, "Cache-Control": "no-cache", "Vary": "Accept-Encoding"}
    headers[AS_OF] = f"{as_of_unix_s:.3f}"
    if if_none_match is not None and pack.etag in [tag.strip() for tag in if_none_match.split(",")]:
        return Response(status_code=304, headers=headers)
    known = frozenset(have.split(","))
    if "gzip" in accept_encoding:
        headers["Content-Encoding"] = "gzip"
        body = await asyncio.to_thread(pack.zipped, known)
        return Response(body, media_type="application/json", headers=headers)
    return Response(pack.plain(known), media_type="application/json", headers=headers)
