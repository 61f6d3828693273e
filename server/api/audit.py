"""The audit log, and taking changes of pins back."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import Annotated, Any

from fastapi import APIRouter, Query

from db.mission_records import GeoreferenceRecord
from db.records import AnnotationRecord
from server.api.common import ERRORS, AllMissions, Commander, OneMission, Operator, Responder, TheChange
from server.errors import ApiError, unknown
from server.people.audit import AuditedRoute
from server.schemas.people import AuditEntryOut, AuditOut


def plain(value: dict[str, Any] | None) -> dict[str, Any] | None:
    """Return a value as the database gives it back: tuples are lists there."""
    found: dict[str, Any] | None = json.loads(json.dumps(value))
    return found


router = APIRouter(tags=["people"], responses=ERRORS, route_class=AuditedRoute)
Before = Annotated[int | None, Query(ge=1, description="Only changes before this audit_id.")]
Limit = Annotated[int, Query(ge=1, le=1000, description="At most so many.")]


@router.get("/audit", summary="Every change", operation_id="get_audit")
async def get_audit(
    missions: AllMissions, by: Commander, before: Before = None, limit: Limit = 200
) -> AuditOut:
    """Return changes of everything on this server, newest first."""
    entries = await missions.store.people.audit_of(None, before, limit)
    return AuditOut(entries=[AuditEntryOut(**asdict(entry)) for entry in entries])


@router.get(
    "/missions/{mission_id}/audit", summary="Every change of a mission", operation_id="get_mission_audit"
)
async def get_mission_audit(
    mission: OneMission, missions: AllMissions, by: Operator, before: Before = None, limit: Limit = 200
) -> AuditOut:
    """Return changes of a mission, newest first."""
    entries = await missions.store.people.audit_of(mission.mission_id, before, limit)
    return AuditOut(entries=[AuditEntryOut(**asdict(entry)) for entry in entries])


@router.post(
    "/missions/{mission_id}/audit/{audit_id}/undo",
    status_code=204,
    summary="Take a change back",
    operation_id="take_back",
)
async def take_back(
    audit_id: int, mission: OneMission, missions: AllMissions, by: Responder, change: TheChange
) -> None:
    """Put a victim's status, an annotation, a sector, a photo or what lies under the map back to what it was.

    Refused where somebody has changed it again since.
    """
    entry = await missions.store.people.audit_entry(mission.mission_id, audit_id)
    if entry is None:
        raise unknown("change", str(audit_id))
    change.before, change.after = entry.after, entry.before
    change.subject = entry.subject
    changed = ApiError(409, "changed_since", f"{entry.subject} was changed again since; look at it anew.")
    if entry.action == "judge_victim" and entry.before is not None:
        if plain(mission.victims.get(entry.subject).said.value()) != entry.after:
            raise changed
        await mission.victims.put_back(entry.subject, entry.before, by.name)
    elif entry.action in ("put_annotation", "delete_annotation"):
        if plain(mission.annotations.value(entry.subject)) != entry.after:
            raise changed
        if entry.before is None:
            await mission.annotations.remove(entry.subject)
        else:
            await mission.annotations.put(AnnotationRecord.of(entry.before))
    elif entry.action in ("put_sector", "delete_sector"):
        if plain(mission.sectors.value(entry.subject)) != entry.after:
            raise changed
        if entry.before is None:
            await mission.sectors.remove(entry.subject)
        else:
            await mission.sectors.put_back(entry.before)
    elif entry.action in ("put_georeference", "delete_georeference"):
        if plain(mission.georeferences.value()) != entry.after:
            raise changed
        before = None if entry.before is None else GeoreferenceRecord.of(entry.before)
        await mission.georeferences.set(before, by.name)
    elif entry.action in ("put_base_map", "copy_base_map", "delete_base_map") and entry.before is not None:
        if entry.after is None or plain(mission.base_map.value()) != entry.after["base_map"]:
            raise changed
        await mission.base_map.put_back(entry.before["base_map"], by.name)
        if (
            entry.before["georeference"]
            != entry.after["georeference"]
            == plain(mission.georeferences.value())
        ):
            place = entry.before["georeference"]
            await mission.georeferences.set(None if place is None else GeoreferenceRecord.of(place), by.name)
    elif entry.action == "delete_photo":
        await mission.photos.put_back(entry.subject)
    else:
        message = "Only changes of what is on the map can be taken back."
        raise ApiError(409, "cannot_undo", message, "audit_id")
