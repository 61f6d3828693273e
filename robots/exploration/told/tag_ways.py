"""Ways along tags: a topological map for a robot whose own map ends a few metres from it.

Tags that were within the small map together and could be driven to are linked by the way over the robot's
place. The way to somewhere far leads from tag to tag; the small map only has to lead to the next one.
"""

from __future__ import annotations

from heapq import heappop, heappush
from math import floor, hypot, inf

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robots.planning.plan_grid import PlanGrid
from robots.planning.travel import UNREACHED
from robots.se2 import Array

Place = tuple[float, float]
Index = NDArray[np.int64]
_LINKED = 6  # tags nearest to the robot that are linked with each other
_LINK_M = 5.0
_NEAR_CELLS = 3  # a tag beside a wall is driven to that near
_ROOM = 8


class TagWays:
    """Tags and the ways between them that one robot saw to be free; tags go by their number here.

    ``names`` and ``places_m`` (n, 2) in the map frame, of all; ``known`` (n,), which of them count now;
    ``order`` (n,): their numbers by name.
    """

    def __init__(self) -> None:
        self.names: list[str] = []
        self.order: Index = np.zeros(0, np.int64)
        self._numbers: dict[str, int] = {}
        self._places = np.zeros((_ROOM, 2))
        self._known = np.zeros(_ROOM, np.bool_)
        self._counts = np.zeros(_ROOM, np.int64)  # of links
        self._others = np.zeros((_ROOM, _ROOM), np.int64)
        self._lengths = np.zeros((_ROOM, _ROOM))
        self._between = np.zeros((_ROOM, _ROOM, 2))

    @property
    def places_m(self) -> Array:
        """Where the tags are, (n, 2)."""
        return self._places[: len(self.names)]

    @property
    def known(self) -> NDArray[np.bool_]:
        """Which tags count now, (n,)."""
        return self._known[: len(self.names)]

    def note(self, name: str, place: Place) -> None:
        """Note where a tag is."""
        number = self._numbers.get(name)
        if number is None:
            number = self._numbers[name] = len(self.names)
            self.names.append(name)
            self._make_room(number + 1)
            self.order = np.array(sorted(range(number + 1), key=self.names.__getitem__))
        self._places[number] = place
        self._known[number] = True

    def forget_all(self) -> None:
        """Let none of the tags count until they are noted again; the ways between them stay."""
        self._known[:] = False

    def is_near(self, here: Place, within_m: float) -> bool:
        """Say whether a tag that counts lies within so many metres."""
        apart_m = np.hypot(*(self.places_m[self.known] - here).T)
        return bool((apart_m <= within_m).any())

    def see(self, here: Place, grid: PlanGrid, costs: NDArray[np.int32]) -> Array:
        """Link the tags in reach of the map and return the ways to all in metres, (n,), inf beyond it.

        ``here`` where the robot is, in the map frame; ``costs`` int32 (h, w) as ``travel_costs`` gives them.
        """
        reached: Array = _reached(self.places_m, self.known, costs, grid.origin, grid.cell_m)
        inside = self.order[np.isfinite(reached[self.order])]
        near = inside[np.argsort(reached[inside], kind="stable")[:_LINKED]]
        if len(near) > 1:
            self._make_room(len(self.names), int(self._counts[near].max()) + _LINKED)
            _link(near, reached, here, self._counts, self._others, self._lengths, self._between)
        return reached

    def ways(self, reached: Array) -> tuple[Array, Index]:
        """Return the ways in metres to all tags, (n,), inf where none is linked, and the tag before each.

        Dijkstra from where the robot stands; the tags reached have none before them, -1.
        """
        ranks = np.empty_like(self.order)
        ranks[self.order] = np.arange(len(ranks))
        found: tuple[Array, Index] = _shortest(reached, ranks, self._counts, self._others, self._lengths)
        return found

    def between(self, first: int, second: int) -> Place:
        """Return where the robot was when it saw the way from one tag to another; both lay round it."""
        link = int(np.flatnonzero(self._others[first, : self._counts[first]] == second)[0])
        x, y = self._between[first, link]
        return float(x), float(y)

    def _make_room(self, tags: int, links: int = 0) -> None:
        if tags > len(self._places):
            for name in ("_places", "_known", "_counts", "_others", "_lengths", "_between"):
                part = getattr(self, name)
                setattr(self, name, np.concatenate([part, np.zeros_like(part)]))
        if links > self._others.shape[1]:
            for name in ("_others", "_lengths", "_between"):
                part = getattr(self, name)
                setattr(self, name, np.concatenate([part, np.zeros_like(part)], axis=1))


@njit(cache=True)
def _reached(
    places: Array,
    known: NDArray[np.bool_],
    costs: NDArray[np.int32],
    origin: tuple[float, float],
    cell_m: float,
) -> Array:
    """Return the ways to the tags within the grid, inf where none leads there."""
    ways = np.full(len(places), inf)
    for k in range(len(places)):
        row, column = floor((places[k, 1] - origin[1]) / cell_m), floor((places[k, 0] - origin[0]) / cell_m)
        if known[k] and 0 <= row < costs.shape[0] and 0 <= column < costs.shape[1]:
            r, c = _reachable_near(costs, row, column)
            if r >= 0:
                ways[k] = float(costs[r, c]) / 5.0 * cell_m
    return ways


@njit(cache=True)
def _reachable_near(costs: NDArray[np.int32], row: int, column: int) -> tuple[int, int]:
    rows, columns = costs.shape
    best, best_row, best_column = 2 * (_NEAR_CELLS + 1) ** 2, -1, -1
    for r in range(max(0, row - _NEAR_CELLS), min(rows, row + _NEAR_CELLS + 1)):
        for c in range(max(0, column - _NEAR_CELLS), min(columns, column + _NEAR_CELLS + 1)):
            off = (r - row) ** 2 + (c - column) ** 2
            if costs[r, c] != UNREACHED and off < best:
                best, best_row, best_column = off, r, c
    return best_row, best_column


@njit(cache=True)
def _link(
    near: Index, reached: Array, here: Place, counts: Index, others: Index, lengths: Array, between: Array
) -> None:
    """Link tags with each other over the robot's place where that is shorter than what was known."""
    for k in range(len(near)):
        for j in range(k + 1, len(near)):
            length = reached[near[k]] + reached[near[j]]
            if length > _LINK_M:
                continue
            for a, b in ((near[k], near[j]), (near[j], near[k])):
                at = 0
                while at < counts[a] and others[a, at] != b:
                    at += 1
                if at == counts[a]:
                    counts[a] += 1
                    others[a, at], lengths[a, at] = b, inf
                if length < lengths[a, at]:
                    lengths[a, at], between[a, at, 0], between[a, at, 1] = length, here[0], here[1]


@njit(cache=True)
def _shortest(
    reached: Array, ranks: Index, counts: Index, others: Index, lengths: Array
) -> tuple[Array, Index]:
    ways, before = reached.copy(), np.full(len(reached), -1, np.int64)
    heap = [(inf, -1, -1)]
    for k in range(len(reached)):
        if reached[k] < inf:
            heappush(heap, (reached[k], ranks[k], k))
    while heap[0][2] >= 0:
        way, _, tag = heappop(heap)
        if way > ways[tag]:
            continue
        for at in range(counts[tag]):
            other = others[tag, at]
            if way + lengths[tag, at] < ways[other]:
                ways[other], before[other] = way + lengths[tag, at], tag
                heappush(heap, (ways[other], ranks[other], other))
    return ways, before


def reachable_near(grid: PlanGrid, costs: NDArray[np.int32], place: Place) -> tuple[int, int] | None:
    """Return the reachable cell nearest to a place, within a few cells of it; None where there is none."""
    row, column = _reachable_near(costs, *grid.cell_of(*place))
    return None if row < 0 else (row, column)


def nearest_reachable(grid: PlanGrid, costs: NDArray[np.int32], place: Place) -> tuple[int, int]:
    """Return the reachable cell nearest to a place anywhere; there is one, the robot's own."""
    cells = np.argwhere(costs != UNREACHED)
    x, y = grid.centres_of(cells).T
    row, column = cells[int(np.hypot(x - place[0], y - place[1]).argmin())]
    return int(row), int(column)


def apart(a: Place, b: Place) -> float:
    """Return how far two places are from each other."""
    return hypot(a[0] - b[0], a[1] - b[1])
