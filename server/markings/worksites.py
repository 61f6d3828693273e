"""Worksites as they are marked at their front: INSARAG, by the edition of their id, and FEMA."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from robots.exploration.area import holds
from server.markings.shapes import (
    Marking,
    Shape,
    day_of,
    hour_of,
    letters,
    lines_of,
    ring,
    size_that_fits,
    stroke,
)
from server.markings.structures import clearance_marking, structure_marking, team_name

Value = Mapping[str, Any]

_TRIAGE = {
    "A": "live victims confirmed, under 12 hours of work",
    "B": "live victims confirmed, over 12 hours of work",
    "C": "live victims possible",
    "D": "only deceased",
}


@dataclass(frozen=True, slots=True)
class Inside:
    """Who is still in a worksite: as counted, and how many places of victims nobody has counted."""

    live: int
    dead: int
    uncounted: int


def inside(sector: Value, victims: Iterable[Value]) -> Inside:
    """Return who is still in a sector, by the victims on the map."""
    corners = tuple((x, y) for x, y in sector["area_m"])
    there = [
        victim
        for victim in victims
        if not victim["merged_into"]
        and victim["status"] != "dismissed"
        and holds(corners, victim["x_m"], victim["y_m"])
    ]
    uncounted = [
        victim
        for victim in there
        if victim["live"] is None and victim["dead"] is None and victim["status"] != "extricated"
    ]
    return Inside(
        sum(victim["live"] or 0 for victim in there),
        sum(victim["dead"] or 0 for victim in there),
        len(uncounted),
    )


def worksite_markings(sector: Value, victims: Iterable[Value]) -> list[Marking]:
    """Return the markings of ``sector/ID`` of the board; none where it is no worksite."""
    worksite = sector.get("worksite")
    if not worksite:
        return []
    drawn = [_insarag(worksite)]
    if worksite["visits"]:
        drawn.append(_fema(worksite, inside(sector, victims)))
    if worksite.get("ratings"):
        drawn.append(structure_marking(worksite))
    is_new = _is_new(worksite)
    return [*drawn, *(clearance_marking(each, is_new) for each in worksite.get("clearances", ()))]


def _is_new(worksite: Value) -> bool:
    return "-" not in worksite["worksite_id"][:2]


def _insarag(worksite: Value) -> Marking:
    """Return a box with the id and a line for every level done; hazards above, triage below."""
    is_new = _is_new(worksite)
    edition = "2027" if is_new else "2020"
    hazards = lines_of(worksite["hazards"].upper(), 22)
    top = 10 + 24 * len(hazards)
    shapes = [
        letters(text, 150, 22 + 24 * k, size_that_fits(text, 20, 280)) for k, text in enumerate(hazards)
    ]
    name = worksite["worksite_id"]
    done = [_done(visit, is_new) for visit in worksite["visits"] if visit["level"] and visit["is_finished"]]
    high = max(200, 118 + 26 * len(done))
    shapes.append(stroke(f"M30 {top}H270V{top + high}H30Z", 6))
    shapes.append(letters(name, 150, top + 78, size_that_fits(name, 80, 224)))
    for k, text in enumerate(done):
        shapes.append(letters(text, 150, top + 118 + 26 * k, size_that_fits(text, 20, 224)))
    if worksite["is_complete"]:
        shapes.append(stroke(f"M8 {top + 94 if is_new else top + high // 2}H292", 6))
    if worksite["triage"]:
        shapes.append(letters(worksite["triage"], 150, top + high + 50, 52))
    height = top + high + (62 if worksite["triage"] else 10)
    return Marking(f"INSARAG {edition}, worksite", _words(worksite), 300, height, tuple(shapes))


def _done(visit: Value, is_new: bool) -> str:
    return f"{team_name(visit['team'], is_new)} ASR{visit['level']} {day_of(visit['left_unix_s'])}"


def _words(worksite: Value) -> str:
    triage = worksite["triage"]
    parts = [f"Worksite {worksite['worksite_id']}"]
    if triage:
        parts.append(f"{triage}: {_TRIAGE[triage]}")
    parts.append("no more work needed" if worksite["is_complete"] else "not complete")
    return ", ".join(parts)


def told_visit(worksite: Value) -> Value:
    """Return the visit that a marking at the door tells of: the first team still inside, else the last."""
    still = [visit for visit in worksite["visits"] if visit["left_unix_s"] is None]
    found: Value = still[0] if still else worksite["visits"][-1]
    return found


def _fema(worksite: Value, there: Inside) -> Marking:
    """Return the search marking: one stroke while a team is inside, a second one once all is searched.

    With a dot where it left unfinished; team and entry left, exit above, hazards right, who is left below.
    """
    visit = told_visit(worksite)
    entered, left = visit["entered_unix_s"], visit["left_unix_s"]
    shapes = [stroke("M100 60 200 160", 8)]
    for k, text in enumerate((visit["team"], day_of(entered), hour_of(entered))):
        shapes.append(letters(text, 96, 96 + 22 * k, size_that_fits(text, 18, 92), "end"))
    for k, text in enumerate(lines_of(worksite["hazards"].upper(), 9)[:6]):
        shapes.append(letters(text, 204, 72 + 22 * k, size_that_fits(text, 18, 92), "start"))
    height, who = 180, f"{visit['team']} is inside"
    if left is not None:
        shapes.append(letters(f"{day_of(left)} {hour_of(left)}", 150, 44, 18))
        if visit["is_finished"]:
            shapes.append(stroke("M200 60 100 160", 8))
        else:
            shapes.append(ring(150, 110, 5, 10))
        how = "has searched all" if visit["is_finished"] else "left before all was searched"
        who = f"{visit['team']} {how}, {_left_words(there)}"
        if not there.uncounted:
            shapes.append(letters(_left_inside(there), 150, 190, 20))
            height = 204
    if visit["parts"]:
        shapes += _parts(visit["parts"], height)
        height += 46
    return Marking("FEMA search", who, 300, height, tuple(shapes))


def _parts(text: str, top: int) -> list[Shape]:
    return [
        stroke(f"M70 {top}H230V{top + 36}H70Z", 4),
        letters(text, 150, top + 24, size_that_fits(text, 18, 150)),
    ]


def _left_inside(there: Inside) -> str:
    counts = [f"{n} {name}" for n, name in ((there.live, "LIVE"), (there.dead, "DEAD")) if n]
    return " ".join(counts) or "0"


def _left_words(there: Inside) -> str:
    if there.uncounted:
        return f"victims not counted yet at {there.uncounted} places"
    counts = " and ".join(f"{n} {name}" for n, name in ((there.live, "live"), (there.dead, "dead")) if n)
    return f"{counts or 'nobody'} still inside"
