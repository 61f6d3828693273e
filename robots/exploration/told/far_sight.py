"""Exploring with a map of a few metres and never trapped: what tags remember stands in for the large map.

Edges of the small map beyond which the ground is covered, by what tags say or the robot saw itself, are none.
Where no edge is left, the robot goes along tags to the ground that somebody saw to be open (``tag_ways``).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf

import numpy as np

from robots.exploration.frontiers import Frontier, find_frontiers
from robots.exploration.strategy import ExplorationView
from robots.exploration.told.atlas import Atlas
from robots.exploration.told.survey import Survey
from robots.exploration.told.tag_ways import Place, TagWays, apart, nearest_reachable, reachable_near
from robots.planning.plan_grid import OCCUPIED, UNKNOWN, PlanGrid
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
        self._tried: list[tuple[Place, float]] = []
        self._target: Place | None = None

    def survey(self) -> Survey:
        """Return what is covered, for weighing."""
        return self.atlas.survey()

    def candidates(self, view: ExplorationView) -> tuple[Frontier, ...]:
        """Return the edges of the small map that lead to new ground, else the next place on the way to it."""
        grid, costs = view.grid, view.costs
        if grid is None or costs is None:
            return view.frontiers
        self.atlas.draw(view.tags)
        self.atlas.see(grid)
        self.atlas.settle()
        here = view.pose.x, view.pose.y
        places = self._marks | {tag.tag_id: tag.place_m for tag in view.tags}
        if all(apart(here, place) > _MARK_M for place in places.values()):
            self._marks[f"#{len(self._marks)}"] = here
        near = {name: place for name, place in places.items() if grid.holds(*grid.cell_of(*place))}
        reached = self._ways.see(here, near, grid, costs)
        fresh = find_frontiers(self._with_covered(grid), costs, view.settings.min_frontier_m)
        if fresh:
            self._target = None
            return fresh
        far = self._far(view, grid, places, reached)
        return () if far is None else (far,)

    def _with_covered(self, grid: PlanGrid) -> PlanGrid:
        """Return the grid in which covered ground beyond its edge is no longer unknown."""
        rows, columns = grid.cells.shape
        x = np.arange(0.5, columns) * grid.cell_m + grid.origin[0]
        y = np.arange(0.5, rows) * grid.cell_m + grid.origin[1]
        covered = (grid.cells == UNKNOWN) & self.atlas.closed_at(x, y)
        return replace(grid, cells=np.where(covered, OCCUPIED, grid.cells).astype(np.uint8))

    def _far(
        self, view: ExplorationView, grid: PlanGrid, known: dict[str, Place], reached: dict[str, float]
    ) -> FarFrontier | None:
        self._tried = [(place, until) for place, until in self._tried if until > view.now_s]
        ways, before = self._ways.ways(reached)
        names = sorted(name for name in ways if name in known)
        places = self.atlas.open_places()
        if not names or len(places) == 0:
            return None
        at = np.array([known[name] for name in names])
        legs = np.hypot(*(places[:, None] - at[None]).transpose(2, 0, 1))
        nearest = legs <= np.maximum(_LAST_LEG_M, legs.min(axis=1, keepdims=True))
        legs = np.where(legs <= _LAST_LEG_M, legs, np.where(nearest, _DETOUR * legs, inf))
        totals = legs + np.array([ways[name] for name in names])
        by, total = totals.argmin(axis=1), totals.min(axis=1)
        total = total - _STAYS_M * self._is_target(places)
        for index in np.argsort(total, kind="stable"):
            place, name = (float(places[index, 0]), float(places[index, 1])), names[int(by[index])]
            if any(apart(place, tried) < _TRIED_M for tried, _ in self._tried):
                continue
            step = self._step(view, grid, known, before, name, reached, place)
            if step is None:  # it is there, and nothing is to be seen
                self._tried.append((place, view.now_s + _TRIED_S))
                continue
            self._target = place
            return FarFrontier(step, grid.centre_of(*step), 0.0, float(totals[index].min()), place)
        return None

    def _is_target(self, places: Array) -> Array:
        if self._target is None:
            return np.zeros(len(places))
        near: Array = (np.hypot(*(places - self._target).T) < _TRIED_M).astype(np.float64)
        return near

    def _step(
        self, view: ExplorationView, grid: PlanGrid, known: dict[str, Place], before: dict[str, str],
        name: str, reached: dict[str, float], place: Place,
    ) -> tuple[int, int] | None:  # fmt: skip
        """Return the cell to drive to next; None where the robot is as near to the place as it gets."""
        assert view.costs is not None
        here = view.pose.x, view.pose.y
        on_way, after = name, None
        while on_way not in reached:
            on_way, after = before[on_way], on_way
        if after is not None:
            between = self._ways.between(on_way, after)
            if apart(between, here) > _PASSED_M:
                cell = reachable_near(grid, view.costs, between)
                if cell is not None:
                    return cell
        elif reached[on_way] < _PASSED_M or apart(here, place) < apart(known[on_way], place):
            nearest = nearest_reachable(grid, view.costs, place)
            nearer = apart(grid.centre_of(*nearest), place) < apart(here, place) - _PASSED_M
            return nearest if nearer else None
        return reachable_near(grid, view.costs, known[on_way])
