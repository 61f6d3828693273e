"""Where somebody is who hears radio nodes that robots have mapped."""

from __future__ import annotations

import asyncio
from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import replace
from math import sqrt
from statistics import fmean
from typing import Any

from robots.config import RadioConfig
from robots.estimation.radio.hearing import EXPONENT_SD, GAIN_SD_DB, Ears, NodePlace
from robots.estimation.radio.locating import Heard, Located, Plan, Since, locate
from robots.estimation.radio.walls import WALL_DB
from robots.routes.fix_words import fix_text, near_tag, right_to_m
from robots.routes.texts import Language
from robots.routes.words import North
from robots.team import TeamGrid
from server.board import Board
from server.errors import ApiError, unknown
from server.map_image import classes_of
from server.mission.goals import sd_of
from server.mission.roster import Roster
from server.mission.routes import north_of, places_of
from server.mission.shared_map import SharedMap
from server.robot import Robot
from server.schemas.locating import HeardIn, LocatedOut, LocateIn, PlaceOut, RingOut

STEP_M = 0.7  # of somebody in gear, Weinberg 2002 gives 0.6 to 0.8
_LONG_STEP = 1.3  # two deviations of a step's length, and of steps missed
_AT_TAG_M = 0.5  # who touches a tag stands beside it


class Locating:
    """Locates people by the places of nodes, the mission's radio and what RSLAM has learnt of it."""

    def __init__(self, board: Board, roster: Roster, shared_map: SharedMap) -> None:
        self._board = board
        self._roster = roster
        self._shared_map = shared_map
        self._value: dict[str, Any] = {}

    async def locate(self, said: LocateIn, language: Language) -> LocatedOut:
        """Return where one is who hears this.

        Raises:
            ApiError: none of the nodes is on the map, or the last tag is not.
        """
        tags = {tag["tag_id"]: tag for tag in self._board.of_kind("tag")}
        nodes = {
            tag_id: NodePlace(tag_id, *place, sd_of(tags[tag_id]) / sqrt(2.0))
            for tag_id, place in places_of(tags.values()).items()
        }
        since = None if said.last_tag is None else _since(nodes, said.last_tag, said.steps or 0)
        ears = self.ears
        heard, contrary, strange = _heard(ears, nodes, said.heard)
        if not heard:
            message = "None of these nodes is on the map yet; read a tag, or walk on to where robots were."
            if contrary:
                message = "What was heard of the nodes contradicts itself; stand still and listen again."
            raise ApiError(409, "nothing_heard", message, "heard")
        found = await asyncio.to_thread(locate, heard, ears.shared, since, _plan(self._shared_map.grid))
        north = north_of(self._board.get("georeference"))
        return _answer(found, nodes, contrary, strange, language, north)

    @property
    def ears(self) -> Ears:
        """The mission's radio, as its robots have it."""
        return ears_of(self._roster.robots.values())

    def value(self) -> dict[str, Any]:
        """Return the radio as a phone needs it; the same object while nothing has changed."""
        value = radio_value(self.ears)
        if value != self._value:
            self._value = value
        return self._value


def radio_value(ears: Ears) -> dict[str, Any]:
    """Return a radio as phones take it."""
    radio = ears.radio
    return {
        "power_at_1m_dbm": radio.power_at_1m_dbm,
        "path_loss_exponent": radio.path_loss_exponent,
        "distances_m": list(radio.table_distances_m or (0.0,)),
        "sds_db": list(radio.table_sds_db or (radio.shadowing_sd_db,)),
        "fading_sd_db": radio.fading_sd_db,
        "reach_m": radio.reach_m,
        "gain_sd_db": GAIN_SD_DB,
        "exponent_sd": EXPONENT_SD,
        "wall_db": WALL_DB,
    }


def ears_of(robots: Iterable[Robot]) -> Ears:
    """Return the radio of robots that hear nodes, with what they have learnt of it, to the decimetre."""
    known = [(robot.ears, robot.graph, robot.slam) for robot in robots]
    hearing = [(ears, graph) for ears, graph, _ in known if graph is not None and len(graph.range_pairs)]
    if not hearing:
        by_radio = [ears for ears, _, slam in known if slam in ("rslam", "ekf")]
        told = [ears for ears, _, _ in known if ears.radio != RadioConfig()]
        return next(iter(by_radio + told), Ears())
    offsets: dict[str, list[float]] = defaultdict(list)
    for _, graph in hearing:
        for tag_id, offset_m in zip(graph.tag_ids, graph.range_offsets_m, strict=False):
            offsets[tag_id].append(float(offset_m))
    means = {tag_id: round(fmean(values), 1) for tag_id, values in sorted(offsets.items())}
    return replace(
        hearing[0][0],
        scale=min(max(round(fmean(graph.range_scale for _, graph in hearing), 2), 0.5), 2.0),
        offsets_m={tag_id: offset_m for tag_id, offset_m in means.items() if offset_m},
    )


def _heard(
    ears: Ears, nodes: Mapping[str, NodePlace], readings: Iterable[HeardIn]
) -> tuple[list[Heard], list[str], list[str]]:
    """Return ranges, one a node; nodes whose readings disagree; and nodes that are not on the map."""
    signals: defaultdict[str, list[float]] = defaultdict(list)
    ranges: defaultdict[str, list[float]] = defaultdict(list)
    for reading in readings:
        if reading.rssi_dbm is not None:
            signals[reading.node_id].append(reading.rssi_dbm)
        elif reading.range_m is not None:
            ranges[reading.node_id].append(reading.range_m)
    heard, contrary = [], []
    for node_id in sorted(signals.keys() | ranges.keys()):
        node = nodes.get(node_id)
        if node is None:
            continue
        one = (
            ears.by_range(node, ranges[node_id])
            if ranges[node_id]
            else ears.by_signal(node, signals[node_id])
        )
        if one is None:
            contrary.append(node_id)
        else:
            heard.append(one)
    return heard, contrary, sorted((signals.keys() | ranges.keys()) - nodes.keys())


def _since(nodes: Mapping[str, NodePlace], tag_id: str, steps: int) -> Since:
    if tag_id not in nodes:
        raise unknown("tag", tag_id)
    tag = nodes[tag_id]
    return Since(tag.x_m, tag.y_m, sqrt(tag.sd_m**2 + _AT_TAG_M**2), _LONG_STEP * STEP_M * steps)


def _plan(grid: TeamGrid | None) -> Plan | None:
    return None if grid is None else Plan(classes_of(grid), grid.origin_m, grid.resolution_m)


def _answer(
    found: Located,
    nodes: Mapping[str, NodePlace],
    contrary: list[str],
    strange: list[str],
    language: Language,
    north: North,
) -> LocatedOut:
    tags = {tag_id: (node.x_m, node.y_m) for tag_id, node in nodes.items()}
    places = []
    for place in found.places:
        near = near_tag(place, tags, north)
        places.append(
            PlaceOut(
                x_m=place.x_m,
                y_m=place.y_m,
                covariance=[place.var_x, place.var_xy, place.var_y],
                share=place.share,
                is_hollow=place.is_hollow,
                right_to_m=right_to_m(place),
                tag_id=near.tag_id,
                distance_m=near.distance_m,
                bearing_deg=near.bearing_deg,
            )
        )
    ring = None
    if found.ring is not None:
        node = nodes[found.ring.node_id]
        ring = RingOut(
            node_id=node.node_id,
            x_m=node.x_m,
            y_m=node.y_m,
            range_m=found.ring.range_m,
            sd_m=found.ring.sd_m,
        )
    left_out = contrary + ([] if found.left_out is None else [found.left_out])
    return LocatedOut(
        places=places,
        ring=ring,
        north=north.kind,
        fits=found.fits,
        left_out=left_out,
        unknown=strange,
        text=fix_text(found, tags, strange, language, north),
    )
