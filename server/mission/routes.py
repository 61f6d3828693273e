"""Routes for people over a mission's tags, from what everybody sees of it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Set
from dataclasses import dataclass, replace
from math import degrees, hypot, sqrt

import numpy as np

from robots.routes.place_kind import PlaceKind
from robots.routes.planner import Hazard, Leg, NoRouteError, RouteMap
from robots.routes.sight import is_clear
from robots.routes.texts import Language, say
from robots.routes.ways import Way, ways_along
from robots.routes.words import North, metres, warning
from robots.team import TeamGrid
from server.board import Board, Value
from server.errors import ApiError, unknown
from server.mission.place_kinds import PlaceKinds

_IN_SIGHT_M = 15.0  # from a tag to what is looked for
_AT_ONCE = 5  # of the nearest tags in sight, so many are tried


@dataclass(frozen=True, slots=True, eq=False)
class Route:
    """Legs from tag to tag, and the last piece from the last tag to a place that is no tag."""

    legs: tuple[Leg, ...]
    to_m: tuple[float, float]
    last: Way | None
    last_text: str

    @property
    def distance_m(self) -> float:
        """How long it is in all."""
        return sum(leg.way.length_m for leg in self.legs) + (0.0 if self.last is None else self.last.length_m)


class Routes:
    """Finds routes; the ways are gathered anew only when tags, trails, notes or the map have changed."""

    def __init__(self, board: Board) -> None:
        self._board = board
        self._of: list[object] = []  # what the roads were made of; values of a board never change in place
        self._roads = RouteMap([])
        self._place_kinds = PlaceKinds()

    @property
    def north(self) -> North:
        """Where north is, as far as the mission's georeference tells."""
        return north_of(self._board.get("georeference"))

    def find(self, grid: TeamGrid | None, from_tag: str, to: str, language: Language = "en") -> Route:
        """Return the best route from a tag to ``tag:ID``, ``victim:ID`` or ``note:ID``.

        Raises:
            ApiError: there is no such thing, or no route to it.
        """
        self._refresh(grid)
        return _find(self._board, self._roads, grid, from_tag, to, language, self.north)

    def neighbours(self, grid: TeamGrid | None, tag_id: str) -> list[tuple[str, Way, float]]:
        """Return the tags next to a tag with the ways and bearings there, the nearest first."""
        self._refresh(grid)
        return [
            (way.to_tag, way, self.north.bearing_deg(way.points_m[0], way.points_m[1]))
            for way in self._roads.neighbours(tag_id)
        ]

    def place_kind(self, grid: TeamGrid | None, tag: Value) -> PlaceKind:
        """Return of what kind a tag's place is, "" where the map does not tell or the tag is doubtful."""
        if tag["notice"]:
            return ""
        tag_id = tag["tag_id"]
        return self._place_kinds.of(grid, tag_id, places_of([tag])[tag_id], sd_of(tag))

    def roads(self, grid: TeamGrid | None) -> RouteMap:
        """Return the tags and ways as they are now; what is returned never changes."""
        self._refresh(grid)
        return self._roads

    def _refresh(self, grid: TeamGrid | None) -> None:
        board = self._board
        now: list[object] = [grid]
        now += [value for kind in ("tag", "trail", "annotation") for value in board.of_kind(kind)]
        if len(now) != len(self._of) or any(a is not b for a, b in zip(now, self._of, strict=True)):
            self._of, self._roads = now, _roads(board, grid)


def north_of(georeference: Value | None) -> North:
    """Return where north is, to a hundredth of a degree: phones are told no more."""
    if georeference is None:
        return North()
    return North(round((90.0 - degrees(georeference["yaw_rad"])) % 360.0, 2))


def _find(
    board: Board,
    roads: RouteMap,
    grid: TeamGrid | None,
    from_tag: str,
    to: str,
    language: Language,
    north: North,
) -> Route:
    tags = {value["tag_id"]: value for value in board.of_kind("tag")}
    if from_tag not in tags:
        raise unknown("tag", from_tag)
    places = places_of(tags.values())
    kind, _, name = to.partition(":")
    target = _target(board, places, kind, name)
    try:
        if kind == "tag":
            return Route(tuple(roads.route(from_tag, [name])), target, None, "")
        ends = ends_of(grid, places, roads.tags, target)
        if from_tag not in roads.tags:
            ends = {tag: far for tag, far in ends.items() if tag == from_tag}
        if not ends:
            raise NoRouteError(f"no tag lies in sight of {to} yet")
        legs = roads.route(from_tag, ends, ends)
    except NoRouteError as error:
        raise ApiError(409, "no_route", f"There is no route: {error}.", "to") from error
    last = legs[-1].way.to_tag if legs else from_tag
    way = Way(last, to, np.array([places[last], target]))
    bearing = north.bearing_deg(way.points_m[0], way.points_m[1])
    goal, where = say(language, f"goal_{kind}", name=name), north.point(bearing, language)
    text = say(language, "last_leg", tag=last, far=metres(way.length_m), way=where, goal=goal)
    text += warning(roads.hazards_near(way.points_m), language)
    return Route(tuple(legs), target, way, text)


def _target(
    board: Board, places: Mapping[str, tuple[float, float]], kind: str, name: str
) -> tuple[float, float]:
    if kind == "tag":
        if name not in places:
            raise unknown("tag", name)
        return places[name]
    key = {"victim": "victim", "note": "annotation"}.get(kind)
    if key is None:
        message = "to: name tag:ID, victim:ID or note:ID."
        raise ApiError(422, "invalid", message, "to")
    value = board.get(f"{key}/{name}")
    if value is None:
        raise unknown(kind, name)
    place = place_of(value, places)
    if place is None:
        raise ApiError(409, "no_place", f"Where {to_words(kind, name)} is, is not known yet.", "to")
    return place


def to_words(kind: str, name: str) -> str:
    """Return what is looked for, in words."""
    return f"{kind} {name}"


def places_of(tags: Iterable[Value]) -> dict[str, tuple[float, float]]:
    """Return where tags are, to the centimetre: phones are told no more, and have to find the same routes."""
    return {tag["tag_id"]: (round(float(tag["x_m"]), 2), round(float(tag["y_m"]), 2)) for tag in tags}


def sd_of(value: Value) -> float:
    """Return how well a place is known: the root of the sum of its variances, in millimetres of a metre."""
    return round(sqrt(value["covariance"][0] + value["covariance"][2]), 3)


def place_of(value: Value, places: Mapping[str, tuple[float, float]]) -> tuple[float, float] | None:
    """Return where a victim or a note is; None while it is at a tag whose place is not known."""
    if value.get("area_m"):
        middle = np.mean(value["area_m"], axis=0)
        return round(float(middle[0]), 2), round(float(middle[1]), 2)
    if value.get("x_m") is not None:
        return round(float(value["x_m"]), 2), round(float(value["y_m"]), 2)
    return places.get(value.get("tag_id") or "")


def _roads(board: Board, grid: TeamGrid | None) -> RouteMap:
    tags = {value["tag_id"]: value for value in board.of_kind("tag")}
    places = places_of(tags.values())
    sound = {tag_id: place for tag_id, place in places.items() if tags[tag_id]["state"] == "sound"}
    ways: list[Way] = []
    for trail in board.of_kind("trail"):
        if len(trail["points_m"]) > 1:
            ways += ways_along(np.array(trail["points_m"]), sound, grid)
    ways = [replace(way, points_m=np.round(way.points_m, 2)) for way in ways]
    sds_m = {tag_id: sd_of(value) for tag_id, value in tags.items()}
    hazards = []
    for note in board.of_kind("annotation"):
        place = place_of(note, places)
        if note["kind"] == "hazard" and place is not None:
            points = tuple((float(x), float(y)) for x, y in note["area_m"]) or (place,)
            hazards.append(Hazard(note["text"] or "hazard", points))
    return RouteMap(ways, sds_m, hazards)


def ends_of(
    grid: TeamGrid | None,
    places: Mapping[str, tuple[float, float]],
    on_roads: Set[str],
    target: tuple[float, float],
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
