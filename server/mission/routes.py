"""Routes for people over a mission's tags, from what everybody sees of it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from math import degrees, hypot

import numpy as np

from robots.routes.hazards import UNNAMED, Hazard
from robots.routes.pace import is_too_far
from robots.routes.place_kind import PlaceKind
from robots.routes.planner import Leg, NoRouteError, RouteMap
from robots.routes.texts import Language
from robots.routes.ways import Way, way_walked, ways_along
from robots.routes.words import North, last_text
from robots.team import TeamGrid
from server.board import Board, Value
from server.errors import ApiError, unknown
from server.mission.goals import Goal, Places, base_of, goals_of, nearest_ends, place_of, sd_of
from server.mission.place_kinds import PlaceKinds


@dataclass(frozen=True, slots=True, eq=False)
class Route:
    """Legs from tag to tag, and the last piece from the last tag to a place that is no tag.

    ``last_sd_m``: how well that place and the last tag are known to each other.
    """

    legs: tuple[Leg, ...]
    to_m: tuple[float, float]
    last: Way | None = None
    last_text: str = ""
    last_sd_m: float = 0.0

    @property
    def distance_m(self) -> float:
        """How long it is in all."""
        return sum(leg.way.length_m for leg in self.legs) + (0.0 if self.last is None else self.last.length_m)


class Routes:
    """Finds routes; the ways are gathered anew only when tags, trails, walks or the map have changed.

    With 5,000 tags that takes a second: a note alone does not need it.
    """

    def __init__(self, board: Board) -> None:
        self._board = board
        # what ways and roads were made of; values of a board never change in place
        self._ways_of: list[object] = []
        self._notes: list[object] = []
        self._ways: list[Way] = []
        self._roads = RouteMap([])
        self._place_kinds = PlaceKinds()

    @property
    def north(self) -> North:
        """Where north is, as far as the mission's georeference tells."""
        return north_of(self._board.get("georeference"))

    def find(self, grid: TeamGrid | None, from_tag: str, to: str, language: Language = "en") -> Route:
        """Return the best route from a tag to what ``goals_of`` makes of ``to``.

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

    def base(self) -> Goal | None:
        """Return where the mission's first robot started; None while none has."""
        return base_of(self._board, self.places())

    def places(self) -> Places:
        """Return where tags are."""
        return places_of(self._board.of_kind("tag"))

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
        ground: list[object] = [grid]
        ground += [value for kind in ("tag", "trail", "walk") for value in board.of_kind(kind)]
        notes: list[object] = [*board.of_kind("annotation")]
        is_moved = not _are_same(ground, self._ways_of)
        if is_moved:
            self._ways_of, self._ways = ground, _ways(board, grid)
        if is_moved or not _are_same(notes, self._notes):
            self._notes, self._roads = notes, _roads(board, self._ways)


def _are_same(some: list[object], others: list[object]) -> bool:
    return len(some) == len(others) and all(a is b for a, b in zip(some, others, strict=True))


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
    goals = goals_of(board, places, to)
    ends, whose = nearest_ends([goal.ends(grid, places, roads.tags) for goal in goals])
    if from_tag not in roads.tags:
        ends = {tag: far for tag, far in ends.items() if tag == from_tag}
    try:
        if not ends:
            raise NoRouteError(f"no tag lies in sight of {to} yet")
        legs = tuple(roads.route(from_tag, ends, ends))
    except NoRouteError as error:
        raise ApiError(409, "no_route", f"There is no route: {error}.", "to") from error
    last = legs[-1].way.to_tag if legs else from_tag
    goal = goals[whose[last]]
    if goal.tag_id is not None:
        return Route(legs, goal.place_m)
    way = Way(last, to, np.array([places[last], goal.place_m]))
    sd_m = hypot(sd_of(tags[last]), goal.sd_m)
    text = last_text(way, goal.words(language), sd_m, roads.hazards_near(way.points_m), language, north)
    return Route(legs, goal.place_m, way, text, sd_m)


def places_of(tags: Iterable[Value]) -> dict[str, tuple[float, float]]:
    """Return where tags are, to the centimetre: phones are told no more, and have to find the same routes."""
    return {tag["tag_id"]: (round(float(tag["x_m"]), 2), round(float(tag["y_m"]), 2)) for tag in tags}


def _ways(board: Board, grid: TeamGrid | None) -> list[Way]:
    tags = {value["tag_id"]: value for value in board.of_kind("tag")}
    places = places_of(tags.values())
    sound = {tag_id: place for tag_id, place in places.items() if tags[tag_id]["state"] == "sound"}
    ways: list[Way] = []
    for trail in board.of_kind("trail"):
        if len(trail["points_m"]) > 1:
            ways += ways_along(np.array(trail["points_m"]), sound, grid)
    ways += _walked(board, tags, sound)
    return [replace(way, points_m=np.round(way.points_m, 2)) for way in ways]


def _roads(board: Board, ways: list[Way]) -> RouteMap:
    tags = {value["tag_id"]: value for value in board.of_kind("tag")}
    places = places_of(tags.values())
    sds_m = {tag_id: sd_of(value) for tag_id, value in tags.items()}
    hazards = []
    for note in board.of_kind("annotation"):
        place = place_of(note, places)
        if note["kind"] == "hazard" and place is not None:
            points = tuple((float(x), float(y)) for x, y in note["area_m"]) or (place,)
            hazards.append(Hazard(note["text"] or UNNAMED, points))
    return RouteMap(ways, sds_m, hazards)


def _walked(board: Board, tags: dict[str, Value], places: Places) -> list[Way]:
    """Return the ways of people who touched one tag after another, in a time in which that can be."""
    ways: list[Way] = []
    for walk in board.of_kind("walk"):
        one, other = walk["from_tag"], walk["to_tag"]
        way = way_walked(one, other, places, walk["steps_m"]) if {one, other} <= places.keys() else None
        if way is None:
            continue
        straight_m = float(np.hypot(*(way.points_m[1] - way.points_m[0])))
        if not is_too_far(straight_m, hypot(sd_of(tags[one]), sd_of(tags[other])), walk["after_s"]):
            ways.append(way)
    return ways
