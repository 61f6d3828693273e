"""Photos of victims, notes, tags and places."""

from __future__ import annotations

import time
from typing import Annotated, Any
from uuid import UUID

from fastapi import APIRouter, Depends, Query, Request, Response

from db.photos import PhotoRecord
from server.api.common import ERRORS, READS, Needs, OneMission, Operator, TheChange
from server.people.actor import Actor
from server.people.audit import AuditedRoute
from server.schemas.photos import PhotoOut, PhotoQuery, PhotosOut

router = APIRouter(
    prefix="/missions/{mission_id}/photos",
    tags=["photos"],
    responses=ERRORS,
    dependencies=READS,
    route_class=AuditedRoute,
)
_BINARY = {"schema": {"type": "string", "format": "binary"}}
_JPEG: dict[int | str, dict[str, Any]] = {200: {"content": {"image/jpeg": _BINARY}}}
_SAFE = {
    # a photo of an id never changes; in a browser's own cache alone, for it may show somebody in need
    "Cache-Control": "private, max-age=31536000, immutable",
    "X-Content-Type-Options": "nosniff",
    "Content-Security-Policy": "default-src 'none'; sandbox",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
}
RobotOrResponder = Annotated[Actor, Depends(Needs("responder", robots=True))]


@router.get("", summary="All photos", operation_id="get_photos")
async def get_photos(mission: OneMission) -> PhotosOut:
    """Return what is told of every photo, oldest first; the pictures are at `address` and `thumbnail`."""
    photos = mission.photos
    return PhotosOut(photos=[PhotoOut(**photos.value(photo)) for photo in photos.all()])


@router.post(
    "",
    status_code=201,
    summary="Leave a photo",
    operation_id="post_photo",
    openapi_extra={
        "requestBody": {
            "required": True,
            "description": "The file itself, not a form.",
            "content": dict.fromkeys(("image/jpeg", "image/png", "image/webp"), _BINARY),
        }
    },
)
async def post_photo(
    request: Request,
    response: Response,
    mission: OneMission,
    about: Annotated[PhotoQuery, Query()],
    by: RobotOrResponder,
    change: TheChange,
) -> PhotoOut:
    """Keep a photo: the body is the JPEG, PNG or WebP file, and the address says what it shows.

    `POST .../photos?photo_id=UUID&victim_id=3&text=left+arm`, with `Content-Type: image/jpeg`. It may be of
    12 MiB and of 50 million pixels; smaller arrives sooner. Position, time and camera in the file are not
    kept. The id is the sender's: the same photo again is answered 200 and changes nothing, another one under
    that id 409. What it is of need not have arrived yet.
    """
    change.subject = str(about.photo_id)
    words = about.model_dump() | {
        "photo_id": str(about.photo_id),
        "annotation_id": None if about.annotation_id is None else str(about.annotation_id),
    }
    told = PhotoRecord(sha256="", width=0, height=0, by=by.name, created_unix_s=time.time(), **words)
    photo, is_new = await mission.photos.add(told, await request.body())
    response.status_code = 201 if is_new else 200
    return PhotoOut(**mission.photos.value(photo))


@router.get(
    "/{photo_id}", summary="A photo", operation_id="get_photo", response_class=Response, responses=_JPEG
)
async def get_photo(photo_id: UUID, mission: OneMission) -> Response:
    """Return a photo as JPEG, at most 2048 pixels along its longer side."""
    return await _picture(mission, photo_id, small=False)


@router.get(
    "/{photo_id}/thumbnail",
    summary="A small photo",
    operation_id="get_photo_thumbnail",
    response_class=Response,
    responses=_JPEG,
)
async def get_photo_thumbnail(photo_id: UUID, mission: OneMission) -> Response:
    """Return a photo as JPEG, at most 320 pixels along its longer side."""
    return await _picture(mission, photo_id, small=True)


@router.delete("/{photo_id}", status_code=204, summary="Take a photo away", operation_id="delete_photo")
async def delete_photo(photo_id: UUID, mission: OneMission, by: Operator, change: TheChange) -> None:
    """Take a photo away; that can be taken back."""
    change.before = mission.photos.value(mission.photos.get(str(photo_id)))
    await mission.photos.remove(str(photo_id))


async def _picture(mission: OneMission, photo_id: UUID, *, small: bool) -> Response:
    picture = await mission.photos.picture(str(photo_id), small=small)
    return Response(picture, media_type="image/jpeg", headers=_SAFE)
