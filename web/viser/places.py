"""Where the things of the board are, as the plan has them (static/console/notes.js and photos.js)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

Value = dict[str, Any]
Values = Mapping[str, Value]
Place = tuple[float, float]
Corners = tuple[Place, ...]

KINDS = ("robot", "victim", "tag", "note", "photo", "sector")
"""What has a place; all but ``note`` are kinds of the board's keys, a note's key is ``annotation/ID``."""
_ASIDE = (0.45, -0.45)  # where a thing's photos are shown, for the thing itself stands at its place


def of_kind(values: Values, kind: str) -> Iterator[tuple[str, Value]]:
    """Yield id and value of every key of a kind."""
    start = f"{kind}/"
    return ((key[len(start) :], value) for key, value in values.items() if key.startswith(start))


def centre_of(area_m: Sequence[Sequence[float]]) -> Place:
    """Return the mean of an area's corners, in metres."""
    return sum(x for x, _ in area_m) / len(area_m), sum(y for _, y in area_m) / len(area_m)


def corners_of(value: Value) -> Corners:
    """Return the corners of a note's or a sector's area, none where it has no area."""
    return tuple((x, y) for x, y in value["area_m"])


def place_of(values: Values, kind: str, thing_id: str) -> Place | None:
    """Return where a thing is in the world frame, in metres; None where it is not there or nobody knows."""
    value = values.get(f"{'annotation' if kind == 'note' else kind}/{thing_id}")
    if value is None or kind not in KINDS:
        return None
    if kind in ("note", "sector") and value["area_m"]:
        return centre_of(value["area_m"])
    if kind == "photo":
        for name, of in (("victim_id", "victim"), ("annotation_id", "note"), ("tag_id", "tag")):
            if value.get(name) is not None:
                thing = place_of(values, of, value[name])
                return None if thing is None else (thing[0] + _ASIDE[0], thing[1] + _ASIDE[1])
    if kind == "note" and value.get("tag_id") is not None:
        return place_of(values, "tag", value["tag_id"])
    x_m, y_m = value.get("x_m"), value.get("y_m")
    return None if x_m is None or y_m is None else (x_m, y_m)


def photo_places(values: Values) -> dict[str, tuple[Place, int]]:
    """Return, by the id of the first photo of each thing or place, where it is and how many there are."""
    first: dict[object, str] = {}
    counts: dict[str, int] = {}
    for photo_id, photo in of_kind(values, "photo"):
        subject = tuple(photo.get(name) for name in ("victim_id", "annotation_id", "tag_id", "x_m", "y_m"))
        shown = first.setdefault(subject, photo_id)
        counts[shown] = counts.get(shown, 0) + 1
    placed = ((photo_id, place_of(values, "photo", photo_id), n) for photo_id, n in counts.items())
    return {photo_id: (place, n) for photo_id, place, n in placed if place is not None}


def contains(area_m: Sequence[Sequence[float]], x_m: float, y_m: float) -> bool:
    """Say whether a point lies in an area (even-odd rule)."""
    inside = False
    for k, (ax, ay) in enumerate(area_m):
        bx, by = area_m[k - 1]
        if (ay > y_m) != (by > y_m) and x_m < ax + (y_m - ay) / (by - ay) * (bx - ax):
            inside = not inside
    return inside
