"""Annotations: what people write on the map."""

from __future__ import annotations

import time
from uuid import UUID

from fastapi import APIRouter

from db.records import AnnotationRecord
from server.api.common import ERRORS, READS, OneMission, Responder, TheChange
from server.people.audit import AuditedRoute
from server.schemas.findings import AnnotationIn, AnnotationOut, AnnotationsOut
from server.sharing import annotation_value

router = APIRouter(
    prefix="/missions/{mission_id}/annotations",
    tags=["annotations"],
    responses=ERRORS,
    dependencies=READS,
    route_class=AuditedRoute,
)


@router.get("", summary="All annotations", operation_id="get_annotations")
async def get_annotations(mission: OneMission) -> AnnotationsOut:
    """Return every annotation, oldest first."""
    return AnnotationsOut(
        annotations=[AnnotationOut(**annotation_value(item)) for item in mission.annotations.all()]
    )


@router.put("/{annotation_id}", summary="Write an annotation", operation_id="put_annotation")
async def put_annotation(
    annotation_id: UUID, body: AnnotationIn, mission: OneMission, by: Responder, change: TheChange
) -> AnnotationOut:
    """Write or replace an annotation. The id is made by whoever writes it, so sending twice does no harm."""
    now = time.time()
    record = AnnotationRecord(
        annotation_id=str(annotation_id),
        by=by.name,
        created_unix_s=now,
        changed_unix_s=now,
        **body.model_dump() | {"area_m": tuple((x, y) for x, y in body.area_m)},
    )
    change.before = mission.annotations.value(str(annotation_id))
    written = annotation_value(await mission.annotations.put(record))
    change.after = written
    return AnnotationOut(**written)


@router.delete(
    "/{annotation_id}", status_code=204, summary="Remove an annotation", operation_id="delete_annotation"
)
async def delete_annotation(
    annotation_id: UUID, mission: OneMission, by: Responder, change: TheChange
) -> None:
    """Take an annotation off the map."""
    change.before = mission.annotations.value(str(annotation_id))
    await mission.annotations.remove(str(annotation_id))
