"""Victims as they are marked with paint beside them: INSARAG (2020 and 2027 agree) and FEMA."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import floor
from typing import Any

from server.markings.shapes import EM, Marking, Shape, letters, ring, size_that_fits, stroke

Value = Mapping[str, Any]

_LINE = 22  # from one count down to the next


def victim_markings(victim: Value) -> list[Marking]:
    """Return the markings of ``victim/ID`` of the board; a dismissed one has none.

    Two of FEMA's once all are removed: its directive of 2014 draws an X over the marking, cards of some
    task forces a vertical bar.
    """
    if victim["status"] == "dismissed":
        return []
    drawn = [_insarag(victim), _fema(victim, "FEMA", "M16 12 84 84M84 12 16 84")]
    if _is_empty(victim):
        drawn.append(_fema(victim, "FEMA, by some cards", "M50 4V96"))
    return drawn


def victim_words(victim: Value) -> str:
    """Return what the markings say."""
    live, dead = victim["live"], victim["dead"]
    if victim["status"] == "dismissed":
        return "Nobody is there: no marking."
    left = " and ".join(f"{n} {name}" for n, name in ((live, "live"), (dead, "dead")) if n)
    if left:
        return f"V, {left} still there"
    if _was(victim, "live") or _was(victim, "dead"):
        return "V, all known victims removed"
    if victim["status"] == "extricated":
        return "V: say how many were there, so that they can be crossed out"
    return "V: a potential victim"


def _was(victim: Value, name: str) -> bool:
    """Say whether such a victim was ever counted there."""
    return bool(victim[name] or victim.get(f"{name}_before"))


def _is_empty(victim: Value) -> bool:
    """Say whether somebody was there and nobody is any more."""
    came = _was(victim, "live") or _was(victim, "dead") or victim["status"] == "extricated"
    return came and not victim["live"] and not victim["dead"]


def _insarag(victim: Value) -> Marking:
    """Return a V, below it L-n and D-n; counts that hold no more are crossed out, the new one is below."""
    columns: list[list[tuple[str, bool]]] = []
    for letter, name in (("L", "live"), ("D", "dead")):
        counts = [(f"{letter}-{n}", True) for n in victim.get(f"{name}_before", ())]
        if victim[name]:
            counts.append((f"{letter}-{victim[name]}", False))
        if counts:
            columns.append(counts)
    shapes: list[Shape] = [stroke("M26 8 50 60 74 8", 9)]
    for x, column in zip((50,) if len(columns) == 1 else (24, 76), columns, strict=False):
        shapes += _column(column, x, 92 if len(columns) == 1 else 44)
    rows = max(map(len, columns), default=0)
    return Marking(
        "INSARAG 2020, 2027", victim_words(victim), 100, max(100, 82 + _LINE * rows), tuple(shapes)
    )


def _column(counts: Sequence[tuple[str, bool]], x: int, room: int) -> list[Shape]:
    shapes = []
    for k, (text, is_crossed) in enumerate(counts):
        y, size = 94 + _LINE * k, size_that_fits(text, 19, room)
        shapes.append(letters(text, x, y, size))
        if is_crossed:
            half = floor(EM * size * len(text) / 2)
            shapes.append(stroke(f"M{x - half} {y - floor(size / 3)}H{x + half}", 4))
    return shapes


def _fema(victim: Value, name: str, removed: str) -> Marking:
    """Return a V; in a circle: found alive; with a bar: found dead; struck out: all were removed."""
    shapes: list[Shape] = [stroke("M28 22 50 74 72 22", 9)]
    if _was(victim, "live"):
        shapes.append(ring(50, 46, 42, 6))
    if _was(victim, "dead"):
        shapes.append(stroke("M14 46H86", 7))
    if _is_empty(victim):
        shapes.append(stroke(removed, 6))
    return Marking(name, victim_words(victim), 100, 100, tuple(shapes))
