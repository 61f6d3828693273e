"""Where a tag is, in words that need no map."""

from __future__ import annotations

from math import hypot
from typing import Any

from robots.routes.place_kind import PlaceKind
from robots.routes.texts import Language, say
from robots.routes.words import North, metres
from server.board import Board
from server.errors import ApiError
from server.mission.routes import Route, Routes

_NEAR_M = 20.0
_NEIGHBOURS = 4


def whereabouts(
    board: Board, routes: Routes, grid: Any, tag_id: str, language: Language = "en"
) -> dict[str, Any]:
    """Return what somebody at a tag has to know: its neighbours, the victims near it, and both in words."""
    tag = board.get(f"tag/{tag_id}")
    if tag is None:
        raise ApiError(404, "unknown_tag", f"There is no tag {tag_id!r} on the map; read another one.")
    neighbours = [
        {"tag_id": b, "distance_m": way.length_m, "bearing_deg": bearing}
        for b, way, bearing in routes.neighbours(grid, tag_id)[:_NEIGHBOURS]
    ]
    victims = []
    for victim in board.of_kind("victim"):
        if victim["status"] in ("dismissed", "extricated") or victim["merged_into"]:
            continue
        route = _route(routes, grid, tag_id, victim["victim_id"])
        straight_m = hypot(victim["x_m"] - tag["x_m"], victim["y_m"] - tag["y_m"])
        if straight_m <= _NEAR_M or route is not None:
            victims.append(
                {
                    "victim_id": victim["victim_id"],
                    "status": victim["status"],
                    "distance_m": straight_m if route is None else route.distance_m,
                    "reachable": route is not None,
                }
            )
    kind = routes.place_kind(grid, tag)
    victims.sort(key=lambda v: (not v["reachable"], v["distance_m"]))
    return {
        "tag_id": tag_id,
        "x_m": tag["x_m"],
        "y_m": tag["y_m"],
        "sd_m": hypot(tag["covariance"][0] ** 0.5, tag["covariance"][2] ** 0.5),
        "state": tag["state"],
        "notice": tag["notice"],
        "place_kind": kind,
        "text": _text(tag_id, kind, neighbours, victims, language, routes.north),
        "north": routes.north.kind,
        "neighbours": neighbours,
        "victims": victims,
    }


def _route(routes: Routes, grid: Any, tag_id: str, victim_id: str) -> Route | None:
    try:
        return routes.find(grid, tag_id, f"victim:{victim_id}")
    except ApiError:
        return None


def _text(
    tag_id: str,
    kind: PlaceKind,
    neighbours: list[dict[str, Any]],
    victims: list[dict[str, Any]],
    language: Language,
    north: North,
) -> str:
    here = say(language, f"in_{kind}") if kind else ""
    words = [say(language, "you_are_in" if kind else "you_are_at", tag=tag_id, place=here)]
    if neighbours:
        there = [
            say(
                language,
                "next_to_it",
                far=metres(n["distance_m"]),
                way=north.point(n["bearing_deg"], language),
                tag=n["tag_id"],
            )
            for n in neighbours[:2]
        ]
        words.append(f"{'; '.join(there)}.")
    near = sum(victim["distance_m"] <= _NEAR_M for victim in victims)
    if near:
        count = say(language, f"count_{near}") if near < 10 else str(near)
        key = "victims_near.one" if near == 1 else "victims_near.other"
        words.append(say(language, key, count=count, far=metres(_NEAR_M)))
    elif victims:
        words.append(say(language, "nearest_victim", far=metres(victims[0]["distance_m"])))
    else:
        words.append(say(language, "no_victim"))
    return " ".join(words)
