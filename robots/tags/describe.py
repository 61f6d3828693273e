"""A tag's memory in words that people and JSON can hold."""

from __future__ import annotations

import re
from collections.abc import Callable
from itertools import groupby
from typing import Any, TypeVar
from unicodedata import category

import numpy as np

from robots.tags.map_memory import TagBelief, WriterMap, merge_maps
from robots.tags.marks import MAX_NAME, MAX_TEXT, Note, Notes, Pass, VictimMark, merged_marks
from robots.tags.memory import CENTRED, MAX_PHASE, REACH, SIDE, VISITED_REACH, TagMemory, TagMemoryError
from robots.tags.window import Cells

STATES = ".o#"  # unseen, open, closed
VISITS = ".12"  # not, once, more often
_NUMBERS = ("x_m", "y_m", "variance_x", "covariance_xy", "variance_y")
T = TypeVar("T")
_FIELDS = ("window", "maps", "victims", "notes", "passes", "visited", "phase", "reach", "visited_reach")
_UNSEEN = re.compile("[\\x00-\\x1f\\x7f-\\x9f]+")
_TURNS = re.compile("[\\u061c\\u200e\\u200f\\u202a-\\u202e\\u2066-\\u2069]")  # to be read from the other side
_SAID_BESIDE = {"notes_let_go", "cell_m"}


def describe(memory: TagMemory) -> dict[str, Any]:
    """Return a memory as JSON takes it.

    ``window`` and ``visited`` have one text a row, north first and west to the left. ``key``: the 16 bits by
    which tags know a robot or a victim. Places are metres north and west of the tag.
    """
    maps = [
        {
            "robot_id": each.writer,
            "revision": each.revision,
            "tags": [
                {"tag_id": b.tag_id, **{name: getattr(b, name) for name in _NUMBERS}} for b in each.beliefs
            ],
        }
        | ({"frame": list(each.frame)} if each.frame else {})
        for each in memory.maps
    ]
    victims = [
        {
            "key": v.key,
            "north_m": v.north_dm / 10,
            "west_m": v.west_dm / 10,
            "confidence": round(v.confidence / 255, 3),
            "seen_min": v.seen_min,
        }
        for v in memory.victims
    ]
    passes = [
        {
            "key": p.key,
            "count": p.count,
            "serial": p.serial,
            "goal_north_m": p.north / 2,
            "goal_west_m": p.west / 2,
        }
        for p in memory.passes
    ]
    notes = [{"number": n.number, "author": n.author, "text": n.text} for n in memory.notes.notes]
    return {
        "window": _rows(memory.cells, STATES),
        "phase": memory.phase,
        "cell_m": memory.cell_m,
        "reach": memory.reach,
        "visited": _rows(memory.visited, VISITS),
        "visited_reach": memory.visited_reach,
        "victims": victims,
        "notes": notes,
        "notes_let_go": memory.notes.gone,
        "passes": passes,
        "maps": maps,
    }


def understand(value: object) -> TagMemory:
    """Return the memory that ``describe`` told of; what is left out is empty.

    Raises:
        TagMemoryError: something is missing, or is not what it should be; the message says what.
    """
    if not isinstance(value, dict) or not set(value) <= {*_FIELDS} | _SAID_BESIDE:
        raise TagMemoryError(f"a memory is an object with {', '.join(_FIELDS)}")
    victims = _each(value, "victims", _victim, "key, north_m, west_m, confidence and seen_min")
    passes = _each(value, "passes", _pass, "key, count, serial, goal_north_m and goal_west_m")
    notes = _each(value, "notes", _note, f"number, author ({MAX_NAME} bytes) and text ({MAX_TEXT} bytes)")
    maps = _each(value, "maps", _map, f"robot_id, revision and tags with {', '.join(_NUMBERS)}")
    gone = _each({"gone": [value.get("notes_let_go") or (0, 0)]}, "gone", _order, "two numbers")[0]
    return TagMemory(
        _window(value.get("window", ["."]), "window", STATES, SIDE),
        merge_maps(tuple(maps), ()),
        merged_marks(*victims),
        Notes(tuple(notes), gone if any(gone) else None).merge(Notes()),
        merged_marks(*passes),
        _window(value.get("visited", ["."]), "visited", VISITS, 2 * VISITED_REACH + 1),
        _number(value.get("phase", CENTRED), 0, MAX_PHASE - 1, "phase"),
        _number(value.get("reach", REACH), -1, REACH, "reach"),
        _number(value.get("visited_reach", VISITED_REACH), -1, VISITED_REACH, "visited_reach"),
    )


def plain(text: str) -> str:
    """Return what others wrote so that it can neither turn round nor cover what stands beside it.

    As ``plain`` of the phone's texts.js: in one line, and no more than two marks over a letter.
    """
    text = _TURNS.sub("", _UNSEEN.sub(" ", text))
    marked = groupby(text, lambda sign: category(sign).startswith("M"))
    return "".join("".join(run)[: 2 if are_marks else None] for are_marks, run in marked)


def sentences(told: dict[str, Any]) -> list[str]:
    """Return what a described memory holds beside the ground, one sentence each."""
    said = [
        f"Victim {v['key']:04x}: {_way(v['north_m'], v['west_m'])}, {v['confidence']:.0%} sure, "
        f"seen at minute {v['seen_min']}."
        for v in told["victims"]
    ]
    said += [f"{plain(n['author'])} writes: {plain(n['text'])}" for n in told["notes"]]
    for p in told["passes"]:
        goal = p["goal_north_m"], p["goal_west_m"]
        went = f", last on its way to a place {_way(*goal)}" if any(goal) else ""
        times = "once" if p["count"] == 1 else f"{p['count']} times"
        said.append(f"Robot {p['key']:04x} passed here {times}{went}.")
    driven = sum(cell != "." for cell in "".join(told["visited"]))
    if driven:
        said.append(f"Robots drove through {driven} cells of 0.4 m round it.")
    said += [f"{m['robot_id']} left a map of {len(m['tags'])} tags." for m in told["maps"]]
    return said


def _way(north_m: float, west_m: float) -> str:
    return (
        f"{abs(north_m):.1f} m plan {'north' if north_m >= 0 else 'south'} and "
        f"{abs(west_m):.1f} m plan {'west' if west_m >= 0 else 'east'} of the tag"
    )


def _each(value: dict[str, Any], name: str, make: Callable[[Any], T], has: str) -> list[T]:
    try:
        return [make(each) for each in value.get(name, [])]
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        raise TagMemoryError(f"{name}: each has {has}") from error


def _victim(told: Any) -> VictimMark:
    return VictimMark(
        _number(round(255 * told["confidence"]), 0, 255),
        _number(told["seen_min"], 0, 65535),
        _number(round(10 * told["north_m"]), -32768, 32767),
        _number(round(10 * told["west_m"]), -32768, 32767),
        _number(told["key"], 0, 65535),
    )


def _pass(told: Any) -> Pass:
    north, west = (_number(round(2 * told[f"goal_{way}_m"]), -128, 127) for way in ("north", "west"))
    count, serial = (_number(told[name], 0, 255) for name in ("count", "serial"))
    return Pass(count, serial, north, west, _number(told["key"], 0, 65535))


def _note(told: Any) -> Note:
    note = Note(_number(told["number"], 0, 65535), str(told["author"]), str(told["text"]))
    if len(note.author.encode()) > MAX_NAME or len(note.text.encode()) > MAX_TEXT:
        raise ValueError
    return note


def _order(told: Any) -> tuple[int, int]:
    number, key = told
    return _number(number, 0, 65535), _number(key, 0, 65535)


def _map(told: Any) -> WriterMap:
    beliefs = (TagBelief(str(t["tag_id"]), *(float(t[name]) for name in _NUMBERS)) for t in told["tags"])
    frame = tuple(float(number) for number in told.get("frame", ()))
    return WriterMap(str(told["robot_id"]), int(told["revision"]), tuple(beliefs), frame)


def _number(value: Any, least: int, most: int, name: str = "") -> int:
    if not isinstance(value, int) or not least <= value <= most:
        raise TagMemoryError(f"{name or 'a number'} has to be a whole number from {least} to {most}")
    return value


def _rows(cells: Cells, states: str) -> list[str]:
    return ["".join(states[cell] for cell in row[::-1]) for row in cells[::-1]]


def _window(rows: object, name: str, states: str, most: int) -> Cells:
    if not isinstance(rows, list) or not all(isinstance(row, str) for row in rows):
        raise TagMemoryError(f"{name} has to be a list of texts, one a row")
    side = len(rows)
    if side % 2 == 0 or side > most or any(len(row) != side for row in rows):
        raise TagMemoryError(f"{name} has to be a square of an odd side up to {most}")
    if set("".join(rows)) - set(states):
        raise TagMemoryError(f"{name}: a cell is one of {' '.join(states)}")
    cells = np.array([[states.index(cell) for cell in row] for row in rows], np.uint8)
    return cells[::-1, ::-1].copy()
