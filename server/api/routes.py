"""Routes for people: from a tag to a victim, a note or another tag, in words that need no map."""

from __future__ import annotations

from math import isfinite
from typing import Annotated

from fastapi import APIRouter, Query

from robots.routes.planner import Leg
from robots.routes.texts import Language
from robots.routes.words import North, is_last_uncertain, is_uncertain, leg_text
from robots.tags.short_id import understood
from server.api.common import ERRORS, READS, AllMissions, OneMission, Viewer
from server.errors import ApiError
from server.mission.whereabouts import whereabouts
from server.missions import Missions
from server.people.actor import Actor
from server.people.audit import AuditedRoute
from server.schemas.routes import LastOut, LegOut, NearVictimOut, NeighbourOut, RouteOut, TypedOut, WhereOut

where = APIRouter(tags=["routes"], responses=ERRORS, dependencies=READS)
router = APIRouter(
    prefix="/missions/{mission_id}/routes",
    tags=["routes"],
    responses=ERRORS,
    dependencies=READS,
    route_class=AuditedRoute,
)
From = Annotated[str, Query(alias="from", max_length=100, description="The tag you are at.")]
OfMission = Annotated[str | None, Query(max_length=100, description="Only this mission.")]
Typed = Annotated[str, Query(max_length=100, description="What is written on the tag, as typed.")]
Speaks = Annotated[Language, Query(description="The language of the words.")]
To = Annotated[
    str, Query(max_length=120, description="victim:ID, tag:ID, note:ID, exit:ID, exit (the nearest) or base.")
]


@router.get("", summary="The way there", operation_id="get_route")
async def get_route(mission: OneMission, from_: From, to: To, language: Speaks = "en") -> RouteOut:
    """Return tags to follow one after the other, each with distance, bearing and what to do in words.

    It runs where robots have driven or people walked, round hazards and narrow places where that is
    possible, and says where it is uncertain. ``exit`` is the nearest of all, ``base`` where robots started.
    """
    route = mission.routes.find(mission.shared_map.grid, from_, to, language)
    north, last = mission.routes.north, None
    if route.last is not None:
        start, end = route.last.points_m
        last = LastOut(
            from_tag=route.last.from_tag,
            distance_m=route.last.length_m,
            bearing_deg=north.bearing_deg(start, end),
            text=route.last_text,
            uncertain=is_last_uncertain(route.last_sd_m),
            sd_m=route.last_sd_m,
        )
    return RouteOut(
        from_tag=from_,
        to=to,
        x_m=route.to_m[0],
        y_m=route.to_m[1],
        distance_m=route.distance_m,
        legs=[_leg(leg, language, north) for leg in route.legs],
        last=last,
        north=north.kind,
    )


@where.get("/where/{tag_id}", summary="Where am I?", operation_id="get_where")
async def get_where(
    tag_id: str, missions: AllMissions, by: Viewer, mission: OfMission = None, language: Speaks = "en"
) -> WhereOut:
    """Return where a tag is, in the latest running mission that has it, and what is near it."""
    return where_of(missions, by, tag_id, mission, language)


def where_of(missions: Missions, by: Actor, tag_id: str, mission: str | None, language: Language) -> WhereOut:
    """Return where a tag is, of what this person or robot may see.

    Raises:
        ApiError: no mission that they may see has it.
    """
    able = [
        m
        for m in missions.all()
        if by.is_for(m.mission_id) and m.board.get(f"tag/{tag_id}") and mission in (None, m.mission_id)
    ]
    if not able:
        raise ApiError(404, "unknown_tag", f"No mission here knows a tag {tag_id!r}; check its number.")
    latest = max(able, key=lambda m: (m.roster.record.state == "running", m.roster.record.created_unix_s))
    found = whereabouts(latest.board, latest.routes, latest.shared_map.grid, tag_id, language)
    return WhereOut(
        **found
        | {
            "mission_id": latest.mission_id,
            "mission_name": latest.roster.record.name,
            "neighbours": [NeighbourOut(**item) for item in found["neighbours"]],
            "victims": [NearVictimOut(**item) for item in found["victims"]],
        }
    )


@where.get("/where", summary="Which tag is meant?", operation_id="get_typed")
async def get_typed(typed: Typed, missions: AllMissions, by: Viewer) -> TypedOut:
    """Return the tags that one means who types what a label says, with or without its check character."""
    able = [m for m in missions.all() if by.is_for(m.mission_id)]
    found = understood(typed, {tag["tag_id"] for m in able for tag in m.board.of_kind("tag")})
    return TypedOut(tag_ids=list(found.tag_ids), trouble=found.trouble)


def _leg(leg: Leg, language: Language, north: North) -> LegOut:
    way = leg.way
    return LegOut(
        from_tag=way.from_tag,
        to_tag=way.to_tag,
        distance_m=way.length_m,
        bearing_deg=north.bearing_deg(way.points_m[0], way.points_m[1]),
        text=leg_text(leg, language, north),
        points_m=[[round(float(x), 2), round(float(y), 2)] for x, y in way.points_m],
        uncertain=is_uncertain(leg),
        walked=way.walked_m is not None,
        width_m=way.width_m if isfinite(way.width_m) else None,
        hazards=list(leg.hazards),
    )
