"""Ways along tags: a topological map for a robot whose own map ends a few metres from it.

Tags that were within the small map together and could be driven to are linked by the way over the robot's
place. The way to somewhere far leads from tag to tag; the small map only has to lead to the next one.
"""

from __future__ import annotations

from collections.abc import Mapping
from heapq import heappop, heappush
from math import hypot, inf

import numpy as np
from numpy.typing import NDArray

from robots.planning.plan_grid import PlanGrid
from robots.planning.travel import UNREACHED

Place = tuple[float, float]
_LINKED = 6  # tags nearest to the robot that are linked with each other
_LINK_M = 5.0
_NEAR_CELLS = 3  # a tag beside a wall is driven to that near


class TagWays:
    """Tags and the ways between them that one robot saw to be free."""

    def __init__(self) -> None:
        self._links: dict[str, dict[str, tuple[float, Place]]] = {}

    def see(
        self, here: Place, places: Mapping[str, Place], grid: PlanGrid, costs: NDArray[np.int32]
    ) -> dict[str, float]:
        """Link the tags in reach of the map and return the ways to them in metres.

        ``here`` where the robot is and ``places`` of tags, in the map frame; ``costs`` int32 (h, w) as
        ``travel_costs`` gives them.
        """
        reached = {}
        for tag_id, place in places.items():
            cell = reachable_near(grid, costs, place)
            if cell is not None:
                reached[tag_id] = float(costs[cell]) / 5.0 * grid.cell_m
        near = sorted(reached, key=lambda tag_id: (reached[tag_id], tag_id))[:_LINKED]
        for k, first in enumerate(near):
            for second in near[k + 1 :]:
                self._link(first, second, reached[first] + reached[second], here)
        return reached

    def ways(self, reached: Mapping[str, float]) -> tuple[dict[str, float], dict[str, str]]:
        """Return the ways in metres to all tags that are linked with those reached, and the tag before each.

        Dijkstra from where the robot stands; the tags reached have none before them.
        """
        ways = dict(reached)
        before: dict[str, str] = {}
        heap = [(way, tag_id) for tag_id, way in reached.items()]
        heap.sort()
        while heap:
            way, tag_id = heappop(heap)
            if way > ways[tag_id]:
                continue
            for other, (length, _) in self._links.get(tag_id, {}).items():
                if way + length < ways.get(other, inf):
                    ways[other], before[other] = way + length, tag_id
                    heappush(heap, (way + length, other))
        return ways, before

    def between(self, first: str, second: str) -> Place:
        """Return where the robot was when it saw the way from one tag to another; both lay round it."""
        return self._links[first][second][1]

    def _link(self, first: str, second: str, length_m: float, here: Place) -> None:
        if length_m > _LINK_M:
            return
        for a, b in ((first, second), (second, first)):
            links = self._links.setdefault(a, {})
            if length_m < links.get(b, (inf, here))[0]:
                links[b] = length_m, here


def reachable_near(grid: PlanGrid, costs: NDArray[np.int32], place: Place) -> tuple[int, int] | None:
    """Return the reachable cell nearest to a place, within a few cells of it; None where there is none."""
    row, column = grid.cell_of(*place)
    top, left = max(0, row - _NEAR_CELLS), max(0, column - _NEAR_CELLS)
    part = costs[top : max(0, row + _NEAR_CELLS + 1), left : max(0, column + _NEAR_CELLS + 1)]
    cells = np.argwhere(part != UNREACHED)
    if len(cells) == 0:
        return None
    cells += (top, left)
    off = ((cells - (row, column)) ** 2).sum(axis=1)
    best = cells[int(off.argmin())]
    return int(best[0]), int(best[1])


def nearest_reachable(grid: PlanGrid, costs: NDArray[np.int32], place: Place) -> tuple[int, int]:
    """Return the reachable cell nearest to a place anywhere; there is one, the robot's own."""
    cells = np.argwhere(costs != UNREACHED)
    x, y = grid.centres_of(cells).T
    row, column = cells[int(np.hypot(x - place[0], y - place[1]).argmin())]
    return int(row), int(column)


def apart(a: Place, b: Place) -> float:
    """Return how far two places are from each other."""
    return hypot(a[0] - b[0], a[1] - b[1])
