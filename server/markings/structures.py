"""How safe a structure is, by FEMA's box, and that nobody alive is left, by INSARAG's rapid clearance."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from server.markings.shapes import Marking, day_of, hour_of, letters, lines_of, size_that_fits, stroke

Value = Mapping[str, Any]

_TEAM = re.compile(r"([A-Z]{3})-?([0-9]{2})")
_STROKES = {"low": 0, "moderate": 1, "high": 2}


def team_name(team: str, is_new: bool) -> str:
    """Return AUS-01 as INSARAG's edition of 2020 draws it, AUS01 as that of 2027, other names as they are."""
    found = _TEAM.fullmatch(team)
    return team if found is None else f"{found[1]}{'' if is_new else '-'}{found[2]}"


def structure_marking(worksite: Value) -> Marking:
    """Return FEMA's structure marking of the newest rating: a box, empty, struck once or crossed out.

    An arrow where the safest entry is; date, time, hazards and team right of it.
    """
    rating = worksite["ratings"][-1]
    team, risk, entry, when = rating["team"], rating["risk"], rating["entry"], rating["rated_unix_s"]
    hazards = lines_of(worksite["hazards"].upper(), 14)[:4]
    lines = [day_of(when), hour_of(when), *hazards, team]
    x = 60 if entry == "left" else 12
    left = x + (148 if entry == "right" else 104)
    crossing = (f"M{x} 142 {x + 90} 52", f"M{x} 52 {x + 90} 142")[: _STROKES[risk]]
    paths = [f"M{x} 52H{x + 90}V142H{x}Z", *crossing, *([_arrow(entry, x)] if entry else [])]
    shapes = [stroke(path, 7) for path in paths]
    shapes += [
        letters(text, left, 72 + 22 * k, size_that_fits(text, 20, 296 - left), "start")
        for k, text in enumerate(lines)
    ]
    words = f"{team} rates the structure a {risk} risk" + (f", safest entry {entry}" if entry else "")
    height = max(196 if entry == "below" else 156, 62 + 22 * len(lines))
    return Marking("FEMA structure", words, 300, height, tuple(shapes))


def _arrow(entry: str, x: int) -> str:
    right, middle = x + 90, x + 45
    return {
        "left": "M50 97H12M26 83 12 97 26 111",
        "right": f"M{right + 10} 97H{right + 48}M{right + 34} 83 {right + 48} 97 {right + 34} 111",
        "above": f"M{middle} 44V8M{middle - 14} 22 {middle} 8 {middle + 14} 22",
        "below": f"M{middle} 152V188M{middle - 14} 174 {middle} 188 {middle + 14} 174",
    }[entry]


def clearance_marking(clearance: Value, is_new: bool) -> Marking:
    """Return INSARAG's rapid clearance: a diamond with C, clear, or D, deceased only; team and day below."""
    team, day = team_name(clearance["team"], is_new), day_of(clearance["cleared_unix_s"])
    is_clear = clearance["found"] == "clear"
    shapes = (
        stroke("M50 8 92 50 50 92 8 50Z", 6),
        letters("C" if is_clear else "D", 50, 66, 46),
        letters(team, 50, 118, size_that_fits(team, 18, 96)),
        letters(day, 50, 140, 18),
    )
    words = f"{clearance['team']} has {'cleared it' if is_clear else 'left only deceased in it'}"
    return Marking("Rapid clearance", words, 100, 150, shapes)
