"""A tour for a robot that knows the plan: what exploring in the dark is measured against.

Places that together see almost everything (greedy set cover), in an order that 2-opt and Or-opt cannot
shorten, less those whose view is had on the way to the others. A plan that can be driven, not a proven best.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from robots.planning.plan_grid import FREE, OCCUPIED, PlanGrid
from robots.planning.travel import UNREACHED, find_path, travel_costs
from robots.se2 import Array, Pose2
from robots.sim.arena.ground import Ground
from robots.sim.rays import look_round
from robots.sim.world import Mask

_PLACES_M = 1.0  # between places that views are taken from
_LOOK_M = 0.5  # of the way between views
_SAMPLE_M = 0.2  # between cells that have to be seen
Cell = tuple[int, int]


@dataclass(frozen=True, slots=True)
class Tour:
    """``length_m`` of a way from the start on which ``share`` of what can be seen is seen."""

    length_m: float
    share: float


class Oracle:
    """Plans on the true map of a ground for a body and a laser."""

    def __init__(self, ground: Ground, radius_m: float, reach_m: float) -> None:
        world = ground.world
        free = world.reachable(radius_m)
        cells = np.where(free, FREE, OCCUPIED).astype(np.uint8)
        steps = np.where(free, 5, 0).astype(np.uint8)
        self._grid = PlanGrid(cells, steps, world.origin_m, world.resolution_m)
        self._world, self._reach_m = world, reach_m
        stride = max(1, round(_SAMPLE_M / world.resolution_m))
        self._wanted = np.zeros_like(ground.observable)
        self._wanted[::stride, ::stride] = ground.observable[::stride, ::stride]
        self._views: dict[tuple[Cell, Cell], tuple[float, Mask]] = {}

    def tour(self, start: Pose2, share: float) -> Tour:
        """Return a tour from a start; ``share`` in 0..1 of what can be seen is to be seen."""
        begin = self._grid.cell_of(start.x, start.y)
        stops = self._cover(begin, share)
        order = self._ordered(begin, stops)
        enough = share * float(self._wanted.sum())
        while True:
            fewer = self._ordered(begin, self._pruned(begin, order, enough))
            if self._seen(begin, fewer).sum() < enough or self._length_m(begin, fewer) >= self._length_m(
                begin, order
            ):
                break
            order = fewer
        seen = float(self._seen(begin, order).sum()) / float(self._wanted.sum())
        return Tour(self._length_m(begin, order), seen)

    def _look(self, cells: Sequence[Cell]) -> Mask:
        rows, columns = (np.array(values, np.int64) for values in zip(*cells, strict=True))
        seen = look_round(self._world, rows, columns, self._reach_m, 360)
        view: Mask = seen[self._wanted] > 0
        return view

    def _cover(self, begin: Cell, share: float) -> list[Cell]:
        """Return places that together see enough, greedily: each sees most of what is left."""
        costs = travel_costs(self._grid, *begin)
        stride = max(1, round(_PLACES_M / self._world.resolution_m))
        places = [
            (int(r), int(c))
            for r, c in np.argwhere(costs != UNREACHED)
            if r % stride == 0 and c % stride == 0
        ]
        views = np.array([self._look([place]) for place in places])
        left = ~self._look([begin])
        chosen: list[Cell] = []
        while left.mean() > 1.0 - share:
            gains = (views & left).sum(axis=1)
            best = int(gains.argmax())
            if gains[best] == 0:
                break
            chosen.append(places[best])
            left &= ~views[best]
        return chosen

    def _ordered(self, begin: Cell, stops: Sequence[Cell]) -> list[Cell]:
        """Return the stops in an order from the start that neither 2-opt nor Or-opt shortens."""
        if not stops:
            return []
        cells = [begin, *stops]
        floods = (travel_costs(self._grid, *cell) for cell in cells)
        ways = np.array([[float(costs[cell]) for cell in cells] for costs in floods])
        order, left = [0], set(range(1, len(cells)))
        while left:
            nearest = min(left, key=lambda k: (ways[order[-1], k], k))
            order.append(nearest)
            left.remove(nearest)
        improved = True
        while improved:
            improved = _two_opt(order, ways) or _or_opt(order, ways)
        return [cells[k] for k in order[1:]]

    def _leg(self, a: Cell, b: Cell) -> tuple[float, Mask]:
        """Return the length of the way between two stops in metres, and what is seen on it."""
        if (a, b) not in self._views:
            path = find_path(self._grid, a, b)
            cells = np.array([a, b]) if path is None else path
            length = float(np.hypot(*np.diff(cells, axis=0).T).sum()) * self._world.resolution_m
            stride = max(1, round(_LOOK_M / self._world.resolution_m))
            points = [(int(r), int(c)) for r, c in (*cells[::stride], cells[-1])]
            self._views[a, b] = length, self._look(points)
        return self._views[a, b]

    def _legs(self, begin: Cell, order: Sequence[Cell]) -> list[tuple[float, Mask]]:
        stops = [begin, *order]
        return [self._leg(a, b) for a, b in pairwise(stops)]

    def _length_m(self, begin: Cell, order: Sequence[Cell]) -> float:
        return sum(length for length, _ in self._legs(begin, order))

    def _seen(self, begin: Cell, order: Sequence[Cell]) -> Mask:
        views = [view for _, view in self._legs(begin, order)]
        seen: Mask = np.any([self._look([begin]), *views], axis=0)
        return seen

    def _pruned(self, begin: Cell, order: Sequence[Cell], enough: float) -> list[Cell]:
        """Return the stops without those that others make needless, the most saving first."""
        stops = [begin, *order]
        counts = self._look([begin]).astype(np.int32)
        for _, view in self._legs(begin, order):
            counts += view
        while True:
            found: list[tuple[float, int, NDArray[np.int32]]] = []
            for k in range(1, len(stops)):
                before, after = self._leg(stops[k - 1], stops[k]), stops[k + 1 : k + 2]
                without = counts - before[1]
                saved = before[0]
                if after:
                    old, new = self._leg(stops[k], after[0]), self._leg(stops[k - 1], after[0])
                    without = without - old[1] + new[1]
                    saved += old[0] - new[0]
                if (without > 0).sum() >= enough:
                    found.append((saved, k, without))
            if not found:
                return stops[1:]
            _, k, counts = max(found, key=lambda item: (item[0], -item[1]))
            del stops[k]


def _two_opt(order: list[int], ways: Array) -> bool:
    """Turn round one piece of an open way where that shortens it; say whether there was one."""
    for i in range(1, len(order) - 1):
        for j in range(i + 1, len(order)):
            a, b, c = order[i - 1], order[i], order[j]
            gain = ways[a, b] - ways[a, c]
            if j + 1 < len(order):
                gain += ways[c, order[j + 1]] - ways[b, order[j + 1]]
            if gain > 1e-9:
                order[i : j + 1] = order[i : j + 1][::-1]
                return True
    return False


def _or_opt(order: list[int], ways: Array) -> bool:
    """Put up to three stops in a row elsewhere where that shortens the way; say whether there were any."""

    def length(stops: list[int]) -> float:
        return float(ways[stops[:-1], stops[1:]].sum())

    now = length(order)
    for size in (1, 2, 3):
        for i in range(1, len(order) - size + 1):
            piece, rest = order[i : i + size], order[:i] + order[i + size :]
            for j in range(1, len(rest) + 1):
                moved = rest[:j] + piece + rest[j:]
                if length(moved) < now - 1e-9:
                    order[:] = moved
                    return True
    return False
