"""The team map on the board and in the store: what a ``TeamUpdate`` means for those who watch."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from typing import Any

from db.records import (
    AlertRecord,
    AnnotationRecord,
    EventRecord,
    NodeRecord,
    PointRecord,
    TagRecord,
)
from db.victim_records import SaidRecord, VictimRecord
from robots.se2 import Array
from robots.team import TeamTag, TeamUpdate, TeamVictim
from server.map_image import MapImage

_BY_HAND_M = 0.5  # how well a person points at a place on the plan
_BESIDE_M = 2.0  # so far from a tag, a victim that somebody reports there may lie


def tag_record(tag: TeamTag) -> TagRecord:
    """Return a tag as it is stored."""
    place = _place(tag.x_m, tag.y_m, tag.covariance)
    return TagRecord(tag.tag_id, place, tag.sightings, tag.robots, tag.state, tag.notice)


def victim_record(victim: TeamVictim, known: VictimRecord | None) -> VictimRecord:
    """Return a victim as it is stored; what people said about it stays."""
    return VictimRecord(
        victim_id=victim.victim_id,
        place=_place(victim.x_m, victim.y_m, victim.covariance),
        confidence=victim.confidence,
        sightings=victim.sightings,
        robots=victim.robots,
        first_seen_s=victim.first_seen_s,
        last_seen_s=victim.last_seen_s,
        said=SaidRecord() if known is None else known.said,
    )


def tag_value(tag: TagRecord) -> dict[str, Any]:
    """Return ``tag/ID`` of the board."""
    return {
        "tag_id": tag.tag_id,
        **_place_value(tag.place),
        "sightings": tag.sightings,
        "robots": list(tag.robots),
        "state": tag.state,
        "notice": tag.notice,
    }


def victim_value(victim: VictimRecord) -> dict[str, Any]:
    """Return ``victim/ID`` of the board."""
    return {
        "victim_id": victim.victim_id,
        **_place_value(victim.place if victim.said.place_m is None else _put(*victim.said.place_m)),
        "confidence": victim.confidence,
        "sightings": victim.sightings,
        "robots": list(victim.robots),
        "first_seen_s": victim.first_seen_s,
        "last_seen_s": victim.last_seen_s,
        **victim.said.value(),
        "triage": victim.said.start.triage,
    }


def node_value(node: NodeRecord, trends: Mapping[str, float | None]) -> dict[str, Any]:
    """Return ``node/ID`` of the board: what an active node measured last, and how that goes."""
    names = ("tag_id", "temperature_c", "pressure_hpa", "tilt_rad", "heard_unix_s", "robot_id")
    return {name: getattr(node, name) for name in names} | dict(trends)


def alert_value(alert: AlertRecord) -> dict[str, Any]:
    """Return ``alert/ID`` of the board."""
    return {name: getattr(alert, name) for name in AlertRecord.__slots__}


def annotation_value(annotation: AnnotationRecord) -> dict[str, Any]:
    """Return ``annotation/ID`` of the board."""
    return {**asdict(annotation), "area_m": [list(corner) for corner in annotation.area_m]}


def event_value(event: EventRecord) -> dict[str, Any]:
    """Return ``event/ID`` of the board."""
    return {name: getattr(event, name) for name in EventRecord.__slots__}


def victim_place_value(victim: TeamVictim) -> dict[str, Any]:
    """Return where a victim is, without what people said about it."""
    place = _place(victim.x_m, victim.y_m, victim.covariance)
    return {"victim_id": victim.victim_id, **_place_value(place)}


def map_value(mission_id: str, image: MapImage, png: str = "map.png") -> dict[str, Any]:
    """Return ``map`` of the board; ``png`` is the last part of the picture's address."""
    return {
        "version": image.version,
        "width": image.width,
        "height": image.height,
        "resolution_m": image.resolution_m,
        "origin_m": list(image.origin_m),
        "explored_m2": round(image.explored_m2, 2),
        "png": f"/api/v1/missions/{mission_id}/{png}?version={image.version}",
    }


def team_values(update: TeamUpdate) -> dict[str, dict[str, Any] | None]:
    """Return links and trails of a team map for the board."""
    values: dict[str, dict[str, Any] | None] = {"links": {"pairs": [list(pair) for pair in update.links]}}
    for robot in update.robots:
        points = [[round(float(x), 2), round(float(y), 2)] for x, y in robot.trail_m] if robot.located else []
        values[f"trail/{robot.robot_id}"] = {"robot_id": robot.robot_id, "points_m": points}
    return values


def vanished(before: Iterable[str], now: Iterable[str], kind: str) -> dict[str, None]:
    """Return the board's keys of things that are no longer there."""
    return {f"{kind}/{name}": None for name in sorted(set(before) - set(now))}


def beside(x_m: float, y_m: float, covariance: Sequence[float]) -> PointRecord:
    """Return where somebody lies who was reported at a tag: there, but for what one reaches from it."""
    var_x, var_xy, var_y = covariance
    return PointRecord(x_m, y_m, var_x + _BESIDE_M**2, var_xy, var_y + _BESIDE_M**2)


def _put(x_m: float, y_m: float) -> PointRecord:
    """Return a place that a person has put something at."""
    return PointRecord(x_m, y_m, _BY_HAND_M**2, 0.0, _BY_HAND_M**2)


def _place(x_m: float, y_m: float, covariance: Array) -> PointRecord:
    return PointRecord(x_m, y_m, float(covariance[0, 0]), float(covariance[0, 1]), float(covariance[1, 1]))


def _place_value(place: PointRecord) -> dict[str, Any]:
    return {
        "x_m": round(place.x_m, 4),
        "y_m": round(place.y_m, 4),
        "covariance": [place.var_x, place.var_xy, place.var_y],
    }
