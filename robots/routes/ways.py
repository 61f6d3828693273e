"""Ways between tags: the pieces of trails from one tag to the next tag they passed, and people's walks."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from math import inf

import numpy as np
from scipy.spatial import cKDTree

from robots.routes.width import narrowness
from robots.se2 import Array
from robots.team import TeamGrid

PASSED_M = 0.75  # a trail that comes so near to a tag passes it
_BENDS_M = 0.5  # bends smaller than this are no bends to a person
_WALKED_M = 30.0  # somebody who touched two tags further apart went by more than one room: that says no way
_COUNTED = 0.7  # of the straight line at the least, or a phone did not count all steps
_DETOUR = 0.5  # by how much more a walk counts whose steps nobody counted


@dataclass(frozen=True, slots=True, eq=False)
class Way:
    """A way that was driven or walked: ``points_m`` (n, 2) in the world frame, with both tags at its ends.

    ``width_m`` of its narrowest passage; ``narrow_cm``: by how much more than its length it counts for that.
    ``walked_m``: its length to somebody who walked it, nobody knows just where; None where it was driven.
    """

    from_tag: str
    to_tag: str
    points_m: Array
    width_m: float = inf
    narrow_cm: int = 0
    walked_m: float | None = None

    @property
    def length_m(self) -> float:
        """How long it is."""
        return length(self.points_m) if self.walked_m is None else self.walked_m

    @property
    def cost_cm(self) -> int:
        """What it costs to walk it, in whole centimetres: its length, and more where it is narrow."""
        return centimetres(self.length_m) + self.narrow_cm

    def reversed(self) -> Way:
        """Return the way back."""
        return replace(self, from_tag=self.to_tag, to_tag=self.from_tag, points_m=self.points_m[::-1])


def centimetres(length_m: float) -> int:
    """Return a length in whole centimetres."""
    return round(100.0 * length_m)


def length(points_m: Array) -> float:
    """Return the length of a line of points (n, 2)."""
    return float(np.hypot(*np.diff(points_m, axis=0).T).sum())


def ways_along(
    trail_m: Array, tags: Mapping[str, tuple[float, float]], grid: TeamGrid | None = None
) -> list[Way]:
    """Return the ways of a trail (k, 2) between the tags it passes, in the order in which it passes them.

    A tag counts as passed where the trail is nearest to it, once for each time that it comes near. A trail
    has no gap: whoever was carried off begins another. With the fused map ways know how wide they are.
    """
    if len(tags) < 2 or len(trail_m) < 2:
        return []
    trail_m = np.asarray(trail_m, float)
    (x0, y0), (x1, y1) = trail_m.min(0) - PASSED_M, trail_m.max(0) + PASSED_M
    names = sorted(name for name, (x, y) in tags.items() if x0 <= x <= x1 and y0 <= y <= y1)
    if len(names) < 2:
        return []
    places = np.array([tags[name] for name in names])
    passed: list[tuple[int, int]] = []  # index on the trail, index of the tag
    for tag, near in enumerate(cKDTree(trail_m).query_ball_point(places, PASSED_M)):
        for visit in _visits(sorted(near)):
            far = np.hypot(*(trail_m[visit] - places[tag]).T)
            passed.append((visit[int(far.argmin())], tag))
    passed.sort()
    ways = []
    for (i, a), (j, b) in pairwise(passed):
        if a != b:
            points = np.vstack([places[a], trail_m[i : j + 1], places[b]])
            width = (inf, 0) if grid is None else narrowness(grid, trail_m[i : j + 1])
            ways.append(Way(names[a], names[b], simplified(points, _BENDS_M), *width))
    return ways


def way_walked(
    one: str, other: str, places: Mapping[str, tuple[float, float]], steps_m: float | None
) -> Way | None:
    """Return the way of somebody who touched one tag and then the other; None where they are far apart.

    As long as their steps made it (``steps_m``), else the straight line, that counts half as much again.
    """
    points = np.array([places[one], places[other]])
    straight_m = length(points)
    if straight_m > _WALKED_M:
        return None
    if steps_m is None or steps_m < _COUNTED * straight_m:
        more_cm = centimetres(_DETOUR * straight_m)
        return Way(one, other, points, narrow_cm=more_cm, walked_m=round(straight_m, 2))
    return Way(one, other, points, walked_m=round(max(steps_m, straight_m), 2))


def shortest_ways(ways: Iterable[Way]) -> dict[tuple[str, str], Way]:
    """Return the way of each pair of tags that costs least, in both directions."""
    best: dict[tuple[str, str], Way] = {}
    for way in ways:
        key = way.from_tag, way.to_tag
        if key not in best or way.cost_cm < best[key].cost_cm:
            best[key], best[key[::-1]] = way, way.reversed()
    return best


def simplified(points_m: Array, within_m: float) -> Array:
    """Return the line without points that lie within so much of it (Douglas and Peucker 1973); ends stay."""
    keep = np.zeros(len(points_m), bool)
    keep[[0, -1]] = True
    pieces = [(0, len(points_m) - 1)]
    while pieces:
        i, j = pieces.pop()
        if j - i < 2:
            continue
        off = _off_line(points_m[i + 1 : j], points_m[i], points_m[j])
        k = i + 1 + int(off.argmax())
        if off[k - i - 1] > within_m:
            keep[k] = True
            pieces += [(i, k), (k, j)]
    return points_m[keep]


def _visits(indices: list[int]) -> list[list[int]]:
    """Return runs of indices that follow each other."""
    runs: list[list[int]] = []
    for index in indices:
        if runs and index == runs[-1][-1] + 1:
            runs[-1].append(index)
        else:
            runs.append([index])
    return runs


def _off_line(points_m: Array, start: Array, end: Array) -> Array:
    """Return the distance of points (n, 2) to the piece from start to end."""
    along = end - start
    squared = float(along @ along)
    share = (
        np.zeros(len(points_m)) if squared == 0.0 else np.clip((points_m - start) @ along / squared, 0.0, 1.0)
    )
    off: Array = np.hypot(*(points_m - start - share[:, None] * along).T)
    return off
