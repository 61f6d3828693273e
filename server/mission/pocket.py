"""A mission as a phone carries it out of reach: plan, tags, ways, victims and notes in one file."""

from __future__ import annotations

import asyncio
import base64
import time
from collections.abc import Callable, Sequence
from math import isfinite
from typing import Any

from robots.routes.place_kind import PlaceKind
from robots.routes.planner import RouteMap
from robots.routes.ways import centimetres
from robots.team import TeamGrid
from server.board import Board, Value
from server.map_image import MapImage
from server.mission.goals import ends_of, place_of, sd_of
from server.mission.locating import Locating
from server.mission.pack import Pack
from server.mission.roster import Roster
from server.mission.routes import Routes, places_of
from server.mission.shared_map import SharedMap

_MOST = {"tags": 20_000, "victims": 2_000, "notes": 2_000}
_FRESH_S = 1.0  # so old an answer does for all who ask meanwhile
_KINDS = ("tag", "trail", "victim", "annotation", "walk")
_OF_VICTIM = ("victim_id", "status", "confidence", "live", "dead", "triage", "note", "merged_into", "by")
_OF_NOTE = ("annotation_id", "kind", "text", "tag_id", "area_m", "by", "changed_unix_s")


class Pocket:
    """Packs what the board shows, anew only when it has changed."""

    def __init__(
        self, board: Board, roster: Roster, routes: Routes, shared_map: SharedMap, locating: Locating
    ) -> None:
        self._board = board
        self._roster = roster
        self._routes = routes
        self._shared_map = shared_map
        self._locating = locating
        self._packing = asyncio.Lock()
        self._of: list[object] = []  # what the pack was made of
        self._pack: Pack | None = None
        self._packed_s = 0.0
        self._as_of_unix_s = 0.0

    async def pack(self) -> tuple[Pack, float]:
        """Return the file as of now, or of the last second, and as of when."""
        async with self._packing:
            pack = self._pack
            if pack is not None and time.monotonic() - self._packed_s < _FRESH_S:
                return pack, self._as_of_unix_s
            as_of_unix_s = time.time()
            kinds = {kind: self._board.of_kind(kind) for kind in _KINDS}
            image, grid = self._shared_map.image, self._shared_map.grid
            evacuation, record = self._board.get("evacuation"), self._roster.record
            now: list[object] = [*(value for values in kinds.values() for value in values), image, grid]
            radio = self._locating.value()
            now += [evacuation, record, radio, self._board.get("georeference")]
            is_same = len(now) == len(self._of) and all(a is b for a, b in zip(now, self._of, strict=True))
            if pack is None or not is_same:
                head = {
                    "mission_id": record.mission_id,
                    "mission_name": record.name,
                    "state": record.state,
                    "created_unix_s": record.created_unix_s,
                    "evacuation": evacuation,
                    "radio": radio,
                    "x_axis_deg": self._routes.north.x_axis_deg,
                }
                roads = self._routes.roads(grid)
                head["base"] = base_out(self._routes, roads, grid)
                pack = await asyncio.to_thread(
                    pack_of, head, kinds, roads, image, grid, self._routes.place_kind
                )
                self._of, self._pack = now, pack
            self._packed_s, self._as_of_unix_s = time.monotonic(), as_of_unix_s
            return pack, as_of_unix_s


def base_out(routes: Routes, roads: RouteMap, grid: TeamGrid | None) -> Value | None:
    """Return where the base is, and the tags in sight of it; None while that is not known."""
    base = routes.base()
    if base is None:
        return None
    ends = base.ends(grid, routes.places(), roads.tags)
    return {
        "x_m": base.place_m[0],
        "y_m": base.place_m[1],
        "tag_id": base.tag_id,
        "ends": [[tag, centimetres(far_m)] for tag, far_m in ends.items()],
    }


def pack_of(
    head: Value,
    kinds: dict[str, list[Value]],
    roads: RouteMap,
    image: MapImage | None,
    grid: TeamGrid | None,
    place_kind: Callable[[TeamGrid | None, Value], PlaceKind],
) -> Pack:
    """Return the file: ``head`` and what ``kinds`` of the board's values hold, with the ways and the plan."""
    places = places_of(kinds["tag"])

    def with_ends(value: Value, names: Sequence[str]) -> dict[str, Any]:
        place = place_of(value, places)
        kept = {name: value[name] for name in names}
        if place is None:
            return kept | {"x_m": None, "y_m": None, "ends": []}
        ends = ends_of(grid, places, roads.tags, place)
        return kept | {
            "x_m": place[0],
            "y_m": place[1],
            "ends": [[tag, centimetres(far_m)] for tag, far_m in ends.items()],
        }

    tags = [
        {
            "tag_id": tag["tag_id"],
            "x_m": places[tag["tag_id"]][0],
            "y_m": places[tag["tag_id"]][1],
            "sd_m": sd_of(tag),
            "state": tag["state"],
            "notice": tag["notice"],
            "place_kind": place_kind(grid, tag),
        }
        for tag in kinds["tag"][: _MOST["tags"]]
    ]
    of = {tag["tag_id"]: k for k, tag in enumerate(tags)}
    victims = [
        with_ends(victim, _OF_VICTIM) | {"sd_m": sd_of(victim)}
        for victim in kinds["victim"][: _MOST["victims"]]
    ]
    said = kinds["annotation"]
    newest = sorted(range(len(said)), key=lambda k: -float(said[k]["changed_unix_s"]))[: _MOST["notes"]]
    value = head | {
        "map": _plan(image),
        "tags": tags,
        "ways": _ways(roads, of),
        "victims": victims,
        "notes": [with_ends(said[k], _OF_NOTE) for k in sorted(newest)],
        "left_out": {
            name: max(0, len(kinds[kind]) - _MOST[name])
            for name, kind in (("tags", "tag"), ("victims", "victim"), ("notes", "annotation"))
        },
    }
    return Pack(value)


def _ways(roads: RouteMap, of: dict[str, int]) -> list[list[Any]]:
    """Return for each way its tags and, in cm, length, points, narrowness, width, what was walked.

    Width is 0 where it is wide, what was walked where it was driven.
    """
    return [
        [
            of[way.from_tag],
            of[way.to_tag],
            centimetres(way.length_m),
            [centimetres(float(number)) for number in way.points_m.ravel()],
            way.narrow_cm,
            centimetres(way.width_m) if isfinite(way.width_m) else 0,
            0 if way.walked_m is None else centimetres(way.walked_m),
        ]
        for way in roads.ways
        if way.from_tag in of and way.to_tag in of
    ]


def _plan(image: MapImage | None) -> dict[str, Any] | None:
    if image is None:
        return None
    return {
        "version": image.version,
        "width": image.width,
        "height": image.height,
        "resolution_m": image.resolution_m,
        "origin_m": list(image.origin_m),
        "png": base64.b64encode(image.png).decode(),
    }
