"""Where a tag is, in words that need no map."""

from __future__ import annotations

from math import hypot
from typing import Any

from robots.routes.words import compass_point, metres
from server.board import Board
from server.errors import ApiError
from server.mission.routes import Route, Routes

_NEAR_M = 20.0
_NEIGHBOURS = 4


def whereabouts(board: Board, routes: Routes, grid: Any, tag_id: str) -> dict[str, Any]:
    """Return what somebody at a tag has to know: its neighbours, the victims near it, and both in words."""
    tag = board.get(f"tag/{tag_id}")
    if tag is None:
        raise ApiError(404, "unknown_tag", f"There is no tag {tag_id!r} on the map; read another one.")
    neighbours = [
        {"tag_id": b, "distance_m": way.length_m, "bearing_deg": bearing}
        for b, way, bearing in routes.neighbours(tag_id)[:_NEIGHBOURS]
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
    victims.sort(key=lambda v: (not v["reachable"], v["distance_m"]))
    return {
        "tag_id": tag_id,
        "x_m": tag["x_m"],
        "y_m": tag["y_m"],
        "sd_m": hypot(tag["covariance"][0] ** 0.5, tag["covariance"][2] ** 0.5),
        "notice": tag["notice"],
        "text": _text(tag_id, neighbours, victims),
        "neighbours": neighbours,
        "victims": victims,
    }


def _route(routes: Routes, grid: Any, tag_id: str, victim_id: str) -> Route | None:
    try:
        return routes.find(grid, tag_id, f"victim:{victim_id}")
    except ApiError:
        return None


def _text(tag_id: str, neighbours: list[dict[str, Any]], victims: list[dict[str, Any]]) -> str:
    words = [f"You are at tag {tag_id}."]
    if neighbours:
        there = [
            f"{metres(n['distance_m'])} {compass_point(n['bearing_deg'])} is tag {n['tag_id']}"
            for n in neighbours[:2]
        ]
        words.append(f"{'; '.join(there)}.")
    near = sum(victim["distance_m"] <= _NEAR_M for victim in victims)
    if near:
        words.append(f"{_count(near)} within {_NEAR_M:.0f} m.")
    elif victims:
        words.append(f"The nearest victim is {metres(victims[0]['distance_m'])} away.")
    else:
        words.append("No victim is known.")
    return " ".join(words)


def _count(number: int) -> str:
    words = ("No", "One", "Two", "Three", "Four", "Five", "Six", "Seven", "Eight", "Nine")
    return f"{words[number] if number < len(words) else number} victim{'' if number == 1 else 's'}"
