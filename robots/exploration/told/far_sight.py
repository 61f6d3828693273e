"""Exploring with a map of a few metres and never trapped: what tags remember stands in for the large map.

Edges of the small map beyond which the ground is covered, by what tags say or the robot saw itself, are none.
Where no edge is left, the robot goes along tags to the ground that somebody saw to be open (``tag_ways``).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import hypot, inf

import numpy as np
from numba import njit

from robots.exploration.frontiers import Frontier, find_frontiers
from robots.exploration.strategy import ExplorationView
from robots.exploration.told.atlas import Atlas
from robots.exploration.told.claims import KnownTag
from robots.exploration.told.tag_ways import Index, Place, TagWays, apart, nearest_reachable, reachable_near
from robots.planning.plan_grid import PlanGrid
from robots.se2 import Array

_PASSED_M = 0.6
_MARK_M = 1.0
_LAST_LEG_M = 3.0  # from a tag to open ground as the crow flies; where it is farther,
_DETOUR = 3.0  # so many times as long, since no way is known
_TRIED_S = 180.0  # open ground that was gone to in vain is left for so long
_TRIED_M = 1.0
_STAYS_M = 3.0  # of way, by which other open ground has to be nearer before the robot turns to it


@dataclass(frozen=True, slots=True)
class FarFrontier(Frontier):
    """Open ground at ``at_m`` (x, y) that tags lead to; the goal is the next place on the way."""

    at_m: Place = (0.0, 0.0)


class FarSight:
    """What one robot with a small map remembers: covered ground, ways along tags, where it went in vain."""

    def __init__(self) -> None:
        self.atlas = Atlas()
        self._ways = TagWays()
        self._marks: dict[str, Place] = {}  # where it was itself, wherever there is no tag
        self._noted: dict[str, KnownTag] = {}
        self._tried: list[tuple[Place, float]] = []
        self._target: Place | None = None

    def untold(self, points_m: Array, within_m: float) -> Array:
        """Return how much of the squares round points (n, 2) nobody covered, (n,); to weigh them by."""
        if len(points_m) == 0:
            return np.zeros(0)
        return self.atlas.survey(points_m, within_m).shares(points_m, within_m)[0]

    def candidates(self, view: ExplorationView) -> tuple[Frontier, ...]:
        """Return the edges of the small map that lead to new ground, else the next place on the way to it."""
        grid, costs = view.grid, view.costs
        if grid is None or costs is None:
            return view.frontiers
        self.atlas.draw(view.tags)
        self.atlas.see(grid)
        self.atlas.settle()
        here = view.pose.x, view.pose.y
        self._note(view.tags)
        reached = self._ways.see(here, grid, costs)
        if not self._ways.is_near(here, _MARK_M):
            name = f"#{len(self._marks)}"
            self._marks[name] = here
            self._ways.note(name, here)
            reached = np.append(reached, inf)
        covered = replace(grid, cells=self.atlas.with_covered(grid))
        fresh = find_frontiers(covered, costs, view.settings.min_frontier_m)
        if fresh:
            self._target = None
            return fresh
        far = self._far(view, grid, reached)
        return () if far is None else (far,)

    def _note(self, tags: tuple[KnownTag, ...]) -> None:
        for tag in tags:
            if self._noted.get(tag.tag_id) is not tag:
                self._noted[tag.tag_id] = tag
                self._ways.note(tag.tag_id, tag.place_m)
        if len(self._noted) > len(tags):  # a tag's place is no longer known
            self._noted = {tag.tag_id: tag for tag in tags}
            self._ways.forget_all()
            for name, place in (self._marks | {tag.tag_id: tag.place_m for tag in tags}).items():
                self._ways.note(name, place)

    def _far(self, view: ExplorationView, grid: PlanGrid, reached: Array) -> FarFrontier | None:
        self._tried = [(place, until) for place, until in self._tried if until > view.now_s]
        ways, before = self._ways.ways(reached)
        order = self._ways.order
        tags = order[np.isfinite(ways[order]) & self._ways.known[order]]
        places = self.atlas.open_places()
        if len(tags) == 0 or len(places) == 0:
            return None
        by, ways_m = _over_tags(places, tags, self._ways.places_m, ways)
        total = ways_m - _STAYS_M * self._is_target(places)
        for index in np.argsort(total, kind="stable"):
            place, tag = (float(places[index, 0]), float(places[index, 1])), int(by[index])
            if any(apart(place, tried) < _TRIED_M for tried, _ in self._tried):
                continue
            step = self._step(view, grid, before, tag, reached, place)
            if step is None:  # it is there, and nothing is to be seen
                self._tried.append((place, view.now_s + _TRIED_S))
                continue
            self._target = place
            return FarFrontier(step, grid.centre_of(*step), 0.0, float(ways_m[index]), place)
        return None

    def _is_target(self, places: Array) -> Array:
        if self._target is None:
            return np.zeros(len(places))
        near: Array = (np.hypot(*(places - self._target).T) < _TRIED_M).astype(np.float64)
        return near

    def _step(
        self, view: ExplorationView, grid: PlanGrid, before: Index, tag: int, reached: Array, place: Place
    ) -> tuple[int, int] | None:
        """Return the cell to drive to next; None where the robot is as near to the place as it gets."""
        assert view.costs is not None
        here = view.pose.x, view.pose.y
        on_way, after = tag, -1
        while reached[on_way] == inf:
            on_way, after = int(before[on_way]), on_way
        at_m = float(self._ways.places_m[on_way, 0]), float(self._ways.places_m[on_way, 1])
        if after >= 0:
            between = self._ways.between(on_way, after)
            if apart(between, here) > _PASSED_M:
                cell = reachable_near(grid, view.costs, between)
                if cell is not None:
                    return cell
        elif reached[on_way] < _PASSED_M or apart(here, place) < apart(at_m, place):
            nearest = nearest_reachable(grid, view.costs, place)
            nearer = apart(grid.centre_of(*nearest), place) < apart(here, place) - _PASSED_M
            return nearest if nearer else None
        return reachable_near(grid, view.costs, at_m)


@njit(cache=True)
def _over_tags(places: Array, tags: Index, places_m: Array, ways: Array) -> tuple[Index, Array]:
    """Return the tag over which the way to each place is shortest, of equals the first, and that way."""
    by, totals = np.zeros(len(places), np.int64), np.full(len(places), inf)
    legs = np.empty(len(tags))
    for k in range(len(places)):
        for j in range(len(tags)):
            legs[j] = hypot(places[k, 0] - places_m[tags[j], 0], places[k, 1] - places_m[tags[j], 1])
        most = max(_LAST_LEG_M, legs.min())
        for j in range(len(tags)):
            leg = legs[j] if legs[j] <= _LAST_LEG_M else _DETOUR * legs[j]
            if legs[j] <= most and leg + ways[tags[j]] < totals[k]:
                by[k], totals[k] = tags[j], leg + ways[tags[j]]
    return by, totals
