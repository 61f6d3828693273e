"""What people keep away from, and which ways come near it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robots.se2 import Array

UNNAMED = "hazard"
"""The text of a hazard of which nobody has said what it is."""
_REACH_CM = 200.0


@dataclass(frozen=True, slots=True)
class Hazard:
    """Something to keep away from: a point, or the corners of an area, in the world frame."""

    text: str
    points_m: tuple[tuple[float, float], ...]


def is_near(points_m: Array, hazard: Hazard) -> bool:
    """Say whether a line of points (n, 2) comes within 2 m of a hazard: of its sides, or into it.

    In centimetres and squares, as a phone reckons: both have to come to the same.
    """
    line, corners = 100.0 * points_m, 100.0 * np.array(hazard.points_m)
    gap = np.maximum(corners.min(axis=0) - line.max(axis=0), line.min(axis=0) - corners.max(axis=0))
    if gap.max() >= _REACH_CM:
        return False
    start, end, ahead = line[:-1, None], line[1:, None], np.roll(corners, -1, axis=0)
    if len(corners) >= 3 and (_inside(line, corners).any() or _cross(start, end, corners, ahead).any()):
        return True
    squares = _off(line[:, None], corners, ahead).min(), _off(corners, start, end).min()
    return bool(min(squares) < _REACH_CM**2)


def _off(points: Array, start: Array, end: Array) -> Array:
    """Return the squared distance of points to the pieces from start to end, all (..., 2)."""
    px, py = np.moveaxis(points - start, -1, 0)
    dx, dy = np.moveaxis(end - start, -1, 0)
    squared = dx * dx + dy * dy
    share = np.clip((px * dx + py * dy) / np.where(squared == 0.0, 1.0, squared), 0.0, 1.0)
    ex, ey = px - share * dx, py - share * dy
    square: Array = ex * ex + ey * ey
    return square


def _cross(start: Array, end: Array, one: Array, other: Array) -> NDArray[np.bool_]:
    """Say which pieces from start to end cross which from one to other."""

    def left(a: Array, b: Array, c: Array) -> NDArray[np.bool_]:
        side: NDArray[np.bool_] = (b - a)[..., 0] * (c - a)[..., 1] - (b - a)[..., 1] * (c - a)[..., 0] > 0.0
        return side

    crossing: NDArray[np.bool_] = (left(start, end, one) != left(start, end, other)) & (
        left(one, other, start) != left(one, other, end)
    )
    return crossing


def _inside(points: Array, corners: Array) -> NDArray[np.bool_]:
    """Say which points (n, 2) lie in a polygon: a ray from them crosses its sides an odd number of times."""
    x, y = points[:, :1], points[:, 1:]
    x0, y0 = corners.T
    x1, y1 = np.roll(corners, -1, axis=0).T
    with np.errstate(divide="ignore", invalid="ignore"):
        crosses = (y0 > y) != (y1 > y)
        at = x0 + (y - y0) * (x1 - x0) / (y1 - y0)
    odd: NDArray[np.bool_] = (crosses & (x < at)).sum(axis=1) % 2 == 1
    return odd
