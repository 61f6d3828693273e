"""What a marking is drawn of: strokes, rings and letters, the same here and in the console (``markings.js``).

x runs right and y down, in units of a hundredth of a victim's marking or half a centimetre of a worksite's.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from math import floor
from typing import Any

Shape = Mapping[str, Any]

EM = 0.68  # how wide a bold letter is, as a part of its size
_MONTHS = ("JAN", "FEB", "MAR", "APR", "MAY", "JUN", "JUL", "AUG", "SEP", "OCT", "NOV", "DEC")


@dataclass(frozen=True, slots=True)
class Marking:
    """One marking as it is sprayed; ``words``: what it says."""

    name: str
    words: str
    width: int
    height: int
    shapes: tuple[Shape, ...]


def stroke(path: str, width: int) -> Shape:
    """Return a stroke along an SVG path."""
    return {"path": path, "width": width}


def ring(x: int, y: int, r: int, width: int) -> Shape:
    """Return a circle."""
    return {"ring": [x, y, r], "width": width}


def letters(text: str, x: int, y: int, size: int, anchor: str = "middle") -> Shape:
    """Return letters on a base line at ``y``; ``anchor``: which part of them is at ``x``."""
    return {"text": text, "at": [x, y], "size": size, "anchor": anchor}


def size_that_fits(text: str, size: int, room: int) -> int:
    """Return the size of letters, at most ``size``, at which a text takes no more than ``room``."""
    return min(size, max(1, floor(room / (EM * max(1, len(text))))))


def lines_of(text: str, most: int) -> list[str]:
    """Return a text in lines of at most ``most`` letters; a longer word has a line to itself."""
    lines: list[str] = []
    for word in text.split():
        if lines and len(lines[-1]) + 1 + len(word) <= most:
            lines[-1] += f" {word}"
        else:
            lines.append(word)
    return lines


def day_of(unix_s: float) -> str:
    """Return a day as it is sprayed, like ``19 OCT``."""
    moment = datetime.fromtimestamp(unix_s)
    return f"{moment.day} {_MONTHS[moment.month - 1]}"


def hour_of(unix_s: float) -> str:
    """Return a time of day, like ``14:05``."""
    return datetime.fromtimestamp(unix_s).strftime("%H:%M")
