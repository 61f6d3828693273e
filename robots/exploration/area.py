"""Areas that people draw: polygons by their corners."""

from __future__ import annotations

from math import hypot

Corners = tuple[tuple[float, float], ...]


def holds(corners: Corners, x: float, y: float, rim_m: float = 0.0) -> bool:
    """Say whether a point lies in a polygon, or within so many metres of it; all in one frame.

    By the even-odd rule: a line from the point to the right crosses the sides an odd number of times.
    """
    inside = False
    for (ax, ay), (bx, by) in zip(corners, corners[1:] + corners[:1], strict=True):
        if (ay > y) != (by > y) and x < ax + (y - ay) / (by - ay) * (bx - ax):
            inside = not inside
        if rim_m > 0.0 and _distance_m(ax, ay, bx, by, x, y) <= rim_m:
            return True
    return inside


def _distance_m(ax: float, ay: float, bx: float, by: float, x: float, y: float) -> float:
    """Return how far a point is from a side."""
    length2 = (bx - ax) ** 2 + (by - ay) ** 2
    along = 0.0 if length2 == 0.0 else ((x - ax) * (bx - ax) + (y - ay) * (by - ay)) / length2
    along = min(1.0, max(0.0, along))
    return hypot(ax + along * (bx - ax) - x, ay + along * (by - ay) - y)
