"""Tours planned far ahead and driven in legs: where much free ground is known, lanes through all of it.

A tour is planned in one go from one flood of the map; only its first leg is driven before the next is planned
(receding horizon), so that what is seen meanwhile and where others are count.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from math import hypot

import numpy as np

from robots.exploration.frontiers import Leg
from robots.exploration.strategies.tours.beam import best_way
from robots.exploration.strategies.tours.stations import NEW, Kinds, stations_of, without_ghosts
from robots.exploration.strategy import ExplorationView
from robots.planning.plan_grid import PlanGrid
from robots.se2 import Array

_LONGEST_M = 120  # of a tour
_LEG_M = 15.0
_FADES_M = 240.0  # ground made safe so much later is worth nothing
_WIDTH, _PER_STATION = 300, 2  # ways kept for each metre, and with the same end
_OTHERS = 0.3  # what ground is worth that somebody else is nearer to
_APART_M = 1.0  # a leg ends where it would come so near to itself again
_END_M = 0.5  # before the end of a leg the next is planned
_POINT_EVERY_M = 0.2
_AHEAD, _OFF_M = 15, 1.0  # points of the way that the robot may have come to, and how near it is to one
_LEAST_M2 = 1.0  # of a whole tour; less is left to what else there is to weigh
_JUST_DRIVEN, _LOOKS_EVERY = 8, 4  # points of the trail: the last 2 m say nothing yet, one a metre will do


class Tours:
    """Plans tours and keeps to the leg that is driven while nothing stands in its way."""

    def __init__(self) -> None:
        self._leg: Leg | None = None

    def kept(self, view: ExplorationView) -> Leg | None:
        """Return what is left of the leg that the robot is on, None where it has to be planned anew."""
        leg, grid, pose = self._leg, view.grid, view.pose
        if leg is None or grid is None or view.goal_m != leg.goal_m:
            return None
        way = np.array(leg.way_m)
        off_m = np.hypot(way[:_AHEAD, 0] - pose.x, way[:_AHEAD, 1] - pose.y)
        # what was passed is never gone back to, though the way may turn about
        way = way[min(int(off_m.argmin()) + 1, len(way) - 1) :]
        rest = np.concatenate([[(pose.x, pose.y)], way])
        left_m = _length_m(rest)
        if off_m.min() > _OFF_M or left_m < _END_M or not _is_open(grid, way):
            return None
        self._leg = replace(leg, cost_m=left_m, way_m=_points(rest), begun=True)
        return self._leg

    def plan(self, view: ExplorationView, kinds: Kinds, coarse_m: float) -> Leg | None:
        """Return the first leg of the best tour, None where nothing is to be gained along a lattice.

        ``kinds`` (v, u): WALL, SAFE or NEW, of coarse cells of ``coarse_m``.
        """
        grid, costs = view.grid, view.costs
        self._leg = None
        if grid is None or costs is None:
            return None
        reach_m = view.settings.safe.safe_m
        kinds = without_ghosts(grid, kinds, coarse_m, view.trail[:-_JUST_DRIVEN:_LOOKS_EVERY, :2], reach_m)
        stations = stations_of(grid, costs, view.pose, kinds, coarse_m, reach_m)
        worths = coarse_m**2 * _shares(view, kinds, coarse_m)
        order, gains, _ = best_way(
            stations.places, stations.ends, stations.ways_m, stations.first, stations.seen, worths.ravel(),
            _LONGEST_M, _WIDTH, _PER_STATION, _FADES_M,
        )  # fmt: skip
        if gains[-1] < _LEAST_M2:
            return None
        order = order[: _legs_length(stations.places[order])]
        way = stations.places[order]
        x, y = way[-1].tolist()
        if any(hypot(x - aside_x, y - aside_y) < _APART_M for aside_x, aside_y in view.aside_m):
            return None
        seen = [stations.seen[stations.first[k] : stations.first[k + 1]] for k in order]
        area_m2 = coarse_m**2 * len(np.unique(np.concatenate(seen)))
        self._leg = Leg(grid.cell_of(x, y), (x, y), 0.0, _length_m(way), _points(_resampled(way)), area_m2)
        return self._leg


def _is_open(grid: PlanGrid, way: Array) -> bool:
    """Say whether a body fits within a cell of each place of a way, (n, 2), but where it begins."""
    return all(
        grid.steps[max(0, row - 1) : row + 2, max(0, column - 1) : column + 2].any()
        for row, column in (grid.cell_of(x, y) for x, y in way[2:].tolist())
    )


def _shares(view: ExplorationView, kinds: Kinds, coarse_m: float) -> Array:
    """Return how much of the worth of each coarse cell is this robot's, (v, u)."""
    shares: Array = (kinds == NEW).astype(np.float64)
    if view.grid is None or len(view.mates_ways) == 0:
        return shares
    rows, columns = np.nonzero(kinds == NEW)
    x = view.grid.origin[0] + (columns + 0.5) * coarse_m
    y = view.grid.origin[1] + (rows + 0.5) * coarse_m
    own = np.hypot(x - view.pose.x, y - view.pose.y)
    theirs = np.full(len(x), np.inf)
    for mate_x, mate_y in view.mates_ways[:, :2]:
        theirs = np.minimum(theirs, np.hypot(x - mate_x, y - mate_y))
    shares[rows, columns] = np.where(own <= theirs, 1.0, _OTHERS)
    return shares


def _legs_length(places: Array) -> int:
    """Return how many of the places (n, 2) make a leg: up to its length, or where it comes near itself."""
    gone = np.concatenate([[0.0], np.hypot(*np.diff(places, axis=0).T).cumsum()])
    for k in range(1, len(places)):
        earlier = gone[:k] < gone[k] - 2.5 * _APART_M
        near = np.hypot(*(places[:k][earlier] - places[k]).T) < _APART_M
        if gone[k] > _LEG_M or near.any():
            return max(2, k)
    return len(places)


def _length_m(way: Array) -> float:
    return float(np.hypot(*np.diff(way, axis=0).T).sum())


def _points(way: Array) -> tuple[tuple[float, float], ...]:
    return tuple((float(x), float(y)) for x, y in way)


def _resampled(way: Array) -> Array:
    points = [way[:1]]
    for a, b in pairwise(way):
        count = max(1, round(hypot(*(b - a)) / _POINT_EVERY_M))
        points.append(a + (b - a) * (np.arange(1, count + 1) / count)[:, None])
    found: Array = np.concatenate(points)
    return found
