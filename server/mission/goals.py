"""What a route may lead to: a tag, a victim, a note, an exit or the base."""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass
from math import hypot, sqrt

import numpy as np

from robots.routes.sight import is_clear
from robots.routes.texts import Language, say
from robots.routes.ways import PASSED_M, centimetres
from robots.team import TeamGrid
from server.board import Board, Value
from server.errors import ApiError, unknown

_IN_SIGHT_M = 15.0  # from a tag to what is looked for
_AT_ONCE = 5  # of the nearest tags in sight, so many are tried

Places = Mapping[str, tuple[float, float]]


@dataclass(frozen=True, slots=True)
class Goal:
    """Something to go to, known to ``sd_m``; ``tag_id`` where it is at a tag, and reached with it."""

    kind: str
    name: str
    place_m: tuple[float, float]
    tag_id: str | None = None
    sd_m: float = 0.0

    def words(self, language: Language) -> str:
        """Return what it is called."""
        return say(language, f"goal_{self.kind}", name=self.name).strip()

    def ends(self, grid: TeamGrid | None, places: Places, on_roads: Set[str]) -> dict[str, float]:
        """Return the tags from which it can be seen and walked to, with what is still to go."""
        if self.tag_id is not None:
            return {self.tag_id: 0.0}
        return ends_of(grid, places, on_roads, self.place_m)


def goals_of(board: Board, places: Places, to: str) -> list[Goal]:
    """Return what is meant by ``tag:ID``, ``victim:ID``, ``note:ID``, ``exit:ID``, ``exit`` or ``base``.

    For ``exit`` these are all exits: the nearest is meant.

    Raises:
        ApiError: there is no such thing, or its place is not known.
    """
    kind, _, name = to.partition(":")
    if to == "base":
        base = base_of(board, places)
        if base is None:
            raise ApiError(409, "no_place", "No robot has started yet, so there is no base.", "to")
        return [base]
    if to == "exit":
        notes = [note for note in board.of_kind("annotation") if note["kind"] == "exit"]
        exits = [goal for note in notes if (goal := _exit(note, places)) is not None]
        if not exits:
            raise ApiError(409, "no_place", "No exit is marked yet; whoever is at one marks it.", "to")
        return exits
    if kind == "tag":
        if name not in places:
            raise unknown("tag", name)
        return [Goal("tag", name, places[name], name)]
    key = {"victim": "victim", "note": "annotation", "exit": "annotation"}.get(kind)
    if key is None:
        message = "to: name tag:ID, victim:ID, note:ID, exit:ID, exit or base."
        raise ApiError(422, "invalid", message, "to")
    value = board.get(f"{key}/{name}")
    if value is None or (kind == "exit" and value["kind"] != "exit"):
        raise unknown(kind, name)
    place = place_of(value, places)
    if place is None:
        raise ApiError(409, "no_place", f"Where {kind} {name} is, is not known yet.", "to")
    if kind == "exit":
        return [goal for goal in [_exit(value, places)] if goal is not None]
    return [Goal(kind, name, place, sd_m=sd_of(value) if kind == "victim" else 0.0)]


def base_of(board: Board, places: Places) -> Goal | None:
    """Return where the mission's first robot started, or the tag that lies there; None while none has."""
    for robot in board.of_kind("robot"):
        trail = board.get(f"trail/{robot['robot_id']}")
        if trail is None or not trail["points_m"]:
            continue
        x, y = (float(number) for number in trail["points_m"][0])
        near = sorted((hypot(x - a, y - b), tag_id) for tag_id, (a, b) in places.items())
        if near and near[0][0] <= PASSED_M:
            return Goal("base", "", places[near[0][1]], near[0][1])
        return Goal("base", "", (round(x, 2), round(y, 2)))
    return None


def _exit(note: Value, places: Places) -> Goal | None:
    """Return an exit: at its tag where it was marked at one."""
    place, tag_id = place_of(note, places), note["tag_id"]
    if place is None:
        return None
    at = tag_id if tag_id in places and place == places[tag_id] else None
    return Goal("exit", note["text"], place, at)


def nearest_ends(ends: Sequence[Mapping[str, float]]) -> tuple[dict[str, float], dict[str, int]]:
    """Return the tags of several goals' ends with the least that is still to go, and to which goal."""
    least: dict[str, float] = {}
    whose: dict[str, int] = {}
    for k, each in enumerate(ends):
        for tag, far_m in each.items():
            if tag not in least or centimetres(far_m) < centimetres(least[tag]):
                least[tag], whose[tag] = far_m, k
    return least, whose


def sd_of(value: Value) -> float:
    """Return how well a place is known: the root of the sum of its variances, in millimetres of a metre."""
    return round(sqrt(value["covariance"][0] + value["covariance"][2]), 3)


def place_of(value: Value, places: Places) -> tuple[float, float] | None:
    """Return where a victim or a note is; None while it is at a tag whose place is not known."""
    if value.get("area_m"):
        middle = np.mean(value["area_m"], axis=0)
        return round(float(middle[0]), 2), round(float(middle[1]), 2)
    if value.get("x_m") is not None:
        return round(float(value["x_m"]), 2), round(float(value["y_m"]), 2)
    return places.get(value.get("tag_id") or "")


def ends_of(
    grid: TeamGrid | None, places: Places, on_roads: Set[str], target: tuple[float, float]
) -> dict[str, float]:
    """Return the tags from which the target can be seen and walked to, with what is still to go.

    The nearest of those that ways lead to, and all that none leads to: whoever stands there needs no way.
    """
    near = {
        name: hypot(x - target[0], y - target[1])
        for name, (x, y) in places.items()
        if abs(x - target[0]) <= _IN_SIGHT_M and abs(y - target[1]) <= _IN_SIGHT_M
    }
    order = sorted((far, name) for name, far in near.items() if far <= _IN_SIGHT_M)
    seen = {name: far for far, name in order if grid is None or is_clear(grid, places[name], target)}
    first = [name for name in seen if name in on_roads][:_AT_ONCE]
    return {name: far for name, far in seen.items() if name in first or name not in on_roads}
