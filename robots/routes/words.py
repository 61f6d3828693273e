"""Ways in words: how far, which way by the compass, where to turn."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise
from math import atan2, degrees
from typing import Literal

import numpy as np

from robots.routes.hazards import UNNAMED
from robots.routes.planner import Leg
from robots.routes.texts import Language, say
from robots.routes.ways import Way, centimetres
from robots.routes.width import NARROW_M
from robots.se2 import Array

_POINTS = ("north", "north_east", "east", "south_east", "south", "south_west", "west", "north_west")
_STRAIGHT_DEG = 35.0  # a smaller turn is no turn
_UNCERTAIN_M, _UNCERTAIN_SHARE = 1.0, 0.25


@dataclass(frozen=True, slots=True)
class North:
    """Where north is: ``x_axis_deg`` is the true bearing of the plan's x axis.

    None where nobody has said how the plan lies on the Earth: north is the plan's then, along x, and said so.
    """

    x_axis_deg: float | None = None

    @property
    def kind(self) -> Literal["true", "plan"]:
        """From which north bearings are."""
        return "plan" if self.x_axis_deg is None else "true"

    def bearing_deg(self, start: Array, end: Array) -> float:
        """Return the bearing from one point to another, 0 to 360."""
        return float((bearing_deg(start, end) + (self.x_axis_deg or 0.0)) % 360.0)

    def point(self, bearing: float, language: Language = "en") -> str:
        """Return the nearest of eight points of the compass to a bearing from this north."""
        way = say(language, _POINTS[round(bearing / 45.0) % 8])
        return way if self.x_axis_deg is not None else say(language, "of_plan", way=way)


OF_PLAN = North()


def bearing_deg(start: Array, end: Array) -> float:
    """Return the bearing from one point to another on the plan, 0 to 360, clockwise from x."""
    dx, dy = end - start
    return float(-degrees(atan2(dy, dx)) % 360.0)


def is_uncertain(leg: Leg) -> bool:
    """Say whether its length and direction are but a guess."""
    far_m = leg.way.length_m
    return leg.way.walked_m is not None or leg.sd_m > _UNCERTAIN_M or leg.sd_m > _UNCERTAIN_SHARE * far_m


def is_narrow(way: Way) -> bool:
    """Say whether people in gear have to squeeze through it."""
    return way.width_m < NARROW_M


def leg_text(leg: Leg, language: Language = "en", north: North = OF_PLAN) -> str:
    """Return a leg as a sentence: "Go 6 m north, turn left and go 3 m to tag A4."."""

    def piece(key: str, way: str, run_m: float) -> str:
        far = metres(run_m)
        return say(language, key, way=way, far=say(language, "about", far=far) if is_uncertain(leg) else far)

    pieces: list[str] = []
    key, way, run_m = "go", "", 0.0
    before: float | None = None
    for start, end in pairwise(leg.way.points_m):
        bearing, step_m = north.bearing_deg(start, end), float(np.hypot(*(end - start)))
        turn = 0.0 if before is None else (bearing - before + 180.0) % 360.0 - 180.0
        if before is None:
            way = north.point(bearing, language)
        elif abs(turn) > _STRAIGHT_DEG:
            pieces.append(piece(key, way, run_m))
            side = "round" if abs(turn) > 145.0 else "left" if turn < 0.0 else "right"
            key, run_m = f"turn_{side}", 0.0
        run_m, before = run_m + step_m, bearing
    if leg.way.walked_m is not None:  # a straight line: it has no bend
        run_m = leg.way.walked_m
    text = ", ".join([*pieces, piece(key, way, run_m)])
    sentence = say(language, "leg", pieces=text[0].upper() + text[1:], tag=leg.way.to_tag)
    if leg.way.walked_m is not None:
        sentence += f" {say(language, 'walked')}"
    if is_narrow(leg.way):
        sentence += f" {say(language, 'narrow', width=10 * round(centimetres(leg.way.width_m) / 10))}"
    return sentence + warning(leg.hazards, language)


def is_last_uncertain(sd_m: float) -> bool:
    """Say whether one has to search for what is at the end of a route, known to ``sd_m`` of the last tag."""
    return sd_m > _UNCERTAIN_M


def last_text(
    way: Way,
    goal: str,
    sd_m: float,
    hazards: Iterable[str],
    language: Language = "en",
    north: North = OF_PLAN,
) -> str:
    """Return the last piece as a sentence: "From tag A4 go 3 m north: there is victim v1."."""
    point = north.point(north.bearing_deg(way.points_m[0], way.points_m[1]), language)
    key = "last_leg_unsure" if is_last_uncertain(sd_m) else "last_leg"
    values = {"tag": way.from_tag, "far": metres(way.length_m), "way": point, "goal": goal}
    return say(language, key, **values, doubt=metres(2.0 * sd_m)) + warning(hazards, language)


def warning(hazards: Iterable[str], language: Language = "en") -> str:
    """Return what to take care of, as sentences with a gap before each."""
    named = (say(language, "a_hazard") if hazard == UNNAMED else hazard for hazard in hazards)
    return "".join(f" {say(language, 'take_care', hazard=hazard)}" for hazard in named)


def metres(distance_m: float) -> str:
    """Return a distance as people say it."""
    return f"{max(1, round(distance_m))} m"
