"""A tag's memory in words that people and JSON can hold."""

from __future__ import annotations

from typing import Any

import numpy as np

from robots.tags.map_memory import TagBelief, WriterMap, merge_maps
from robots.tags.memory import SIDE, TagMemory, TagMemoryError

STATES = ".o#"  # unseen, open, closed
_NUMBERS = ("x_m", "y_m", "variance_x", "covariance_xy", "variance_y")


def describe(memory: TagMemory) -> dict[str, Any]:
    """Return a memory as JSON takes it: ``window`` has one text a row, north first and west to the left."""
    rows = ["".join(STATES[cell] for cell in row[::-1]) for row in memory.cells[::-1]]
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
    return {"window": rows, "maps": maps}


def understand(value: object) -> TagMemory:
    """Return the memory that ``describe`` told of.

    Raises:
        TagMemoryError: something is missing, or is not what it should be; the message says what.
    """
    if not isinstance(value, dict) or not set(value) <= {"window", "maps"}:
        raise TagMemoryError("a memory is an object with window and maps")
    maps = value.get("maps", [])
    try:
        told = tuple(
            WriterMap(
                str(each["robot_id"]),
                int(each["revision"]),
                tuple(
                    TagBelief(str(t["tag_id"]), *(float(t[name]) for name in _NUMBERS)) for t in each["tags"]
                ),
                tuple(float(number) for number in each.get("frame", ())),
            )
            for each in maps
        )
    except (KeyError, TypeError, ValueError) as error:
        raise TagMemoryError(
            f"maps: a map has robot_id, revision and tags with {', '.join(_NUMBERS)}"
        ) from error
    return TagMemory(_window(value.get("window", ["."])), merge_maps(told, ()))


def _window(rows: object) -> np.ndarray[Any, np.dtype[np.uint8]]:
    if not isinstance(rows, list) or not all(isinstance(row, str) for row in rows):
        raise TagMemoryError("window has to be a list of texts, one a row")
    side = len(rows)
    if side % 2 == 0 or side > SIDE or any(len(row) != side for row in rows):
        raise TagMemoryError(f"window has to be a square of an odd side up to {SIDE}")
    if set("".join(rows)) - set(STATES):
        raise TagMemoryError(f"window: a cell is one of {' '.join(STATES)} (unseen, open, closed)")
    cells = np.array([[STATES.index(cell) for cell in row] for row in rows], np.uint8)
    return cells[::-1, ::-1].copy()
