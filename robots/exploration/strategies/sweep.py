"""Making ground safe where the laser sees much farther than ground is safe (the grids of Amigoni 2013).

A goal is worth the ground that driving there would make safe: free or unknown, not safe yet, within the small
range in sight of the way, and not of anybody else's. By the marginal value theorem (Charnov 1976) a square
metre is worth the way that one takes on the whole; so long lanes through new ground are worth more than
places at the rim of the old.
"""

from __future__ import annotations

from math import ceil, cos, floor, hypot, pi, sin

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robots.exploration.frontiers import Frontier, Leg
from robots.exploration.strategies.sight import Mask, Sight
from robots.exploration.strategies.three_grids import three_grids
from robots.exploration.strategies.tours.stations import NEW, SAFE, WALL, Kinds
from robots.exploration.strategies.tours.tour import Tours
from robots.exploration.strategy import ExplorationView, goals_of, ways_of
from robots.planning.plan_grid import OCCUPIED, PlanGrid
from robots.planning.travel import UNREACHED
from robots.se2 import Array

_CELL_M = 0.4  # of the coarse grid that looks are worked out on
_LATTICE_M = 2.0  # between goals in free ground
_LOOK_EVERY_M = 2.0  # along the way
_WORTH_M = 0.27  # of way, of a square metre: 3.7 m2 a metre are made safe on the whole


class Sweep:
    """Candidates and worths of ground to be made safe; knows the grids of the last candidates."""

    def __init__(self) -> None:
        self._sight, self._tours = Sight(), Tours()
        self._kinds: Kinds = np.zeros((0, 0), np.uint8)
        self._origin, self._cell_m = (0.0, 0.0), _CELL_M

    def candidates(self, view: ExplorationView) -> tuple[Frontier, ...]:
        """Return the leg of a tour that the robot is on, or begins; where none gains anything, ``places``."""
        grid, costs = view.grid, view.costs
        if grid is None or costs is None:
            return view.frontiers
        leg = self._tours.kept(view)
        if leg is None:
            self._kinds = kinds_of(grid, self._safe(view, grid))
            self._origin, self._cell_m = grid.origin, grid.cell_m * _factor(grid)
            leg = self._tours.plan(view, self._kinds, self._cell_m)
        return (leg,) if leg is not None else self.places(view, grid, costs)

    def places(self, view: ExplorationView, grid: PlanGrid, costs: NDArray[np.int32]) -> tuple[Frontier, ...]:
        """Return the edges of the unknown, and places in the free ground that is not safe yet."""
        stride = max(1, round(_LATTICE_M / grid.cell_m))
        cells = np.argwhere((costs != UNREACHED) & ~self._safe(view, grid))
        places = [
            Frontier(
                (row, column), grid.centre_of(row, column), 0.0, float(costs[row, column]) / 5.0 * grid.cell_m
            )
            for row, column in cells[(cells % stride == 0).all(axis=1)].tolist()
        ]
        return tuple(sorted([*view.frontiers, *places], key=lambda place: (place.cost_m, place.goal)))

    def _safe(self, view: ExplorationView, grid: PlanGrid) -> Mask:
        """Return what is safe, (h, w): what others make safe on their way is as good as done."""
        trails = np.concatenate([view.trail[:, :3], view.mates_trail[:, :3], view.mates_ways])
        return three_grids(grid, trails, view.settings.safe.safe_m, self._sight).safe

    def areas(self, view: ExplorationView, goals_m: Array) -> Array:
        """Return the ground, (n,) in m2, that driving straight to goals, (n, 2), would make safe.

        As it was when candidates were last asked for and no leg was kept.
        """
        seen = _areas(
            self._kinds, self._origin, self._cell_m, view.pose.x, view.pose.y, goals_m,
            view.settings.safe.safe_m, _LOOK_EVERY_M,
        )  # fmt: skip
        areas: Array = seen * self._cell_m**2
        return areas

    def worths(self, view: ExplorationView) -> Array:
        """Return what the goals are worth, (n,) in metres of way."""
        worths: Array = _WORTH_M * self.gains(view) - ways_of(view)
        return worths

    def gains(self, view: ExplorationView) -> Array:
        """Return the ground, (n,) in m2, that going to the candidates would make safe."""
        if len(view.frontiers) == 1 and isinstance(view.frontiers[0], Leg):
            return np.array([view.frontiers[0].area_m2])
        return self.areas(view, goals_of(view))


def kinds_of(grid: PlanGrid, safe: NDArray[np.bool_]) -> Kinds:
    """Return of coarse cells, (h, w), whether they are walls, safe, or still to be made safe."""
    factor = _factor(grid)
    rows, columns = (side // factor * factor for side in grid.cells.shape)

    def blocks(cells: NDArray[np.bool_]) -> NDArray[np.bool_]:
        shape = rows // factor, factor, columns // factor, factor
        found: NDArray[np.bool_] = np.asarray(cells[:rows, :columns].reshape(shape).any(axis=(1, 3)))
        return found

    kinds = np.where(blocks(safe), SAFE, NEW)
    return np.where(blocks(grid.cells == OCCUPIED), WALL, kinds).astype(np.uint8)


def _factor(grid: PlanGrid) -> int:
    return max(1, round(_CELL_M / grid.cell_m))


@njit(cache=True)
def _areas(
    kinds: Kinds, origin: tuple[float, float], cell: float, x0: float, y0: float, goals: Array, reach: float,
    every: float,
) -> NDArray[np.int64]:  # fmt: skip
    """Return how many new cells are in sight within reach of points on the straight line to each goal."""
    rows, columns = kinds.shape
    marks = np.zeros((rows, columns), np.int32)
    counts = np.zeros(len(goals), np.int64)
    rays, steps = ceil(2.0 * pi * reach / cell), int(reach / cell)
    along = np.array([cos(2.0 * pi * ray / rays) for ray in range(rays)])
    across = np.array([sin(2.0 * pi * ray / rays) for ray in range(rays)])
    for k in range(len(goals)):
        dx, dy = goals[k, 0] - x0, goals[k, 1] - y0
        looks = int(hypot(dx, dy) / every) + 1
        for look in range(1, looks + 1):
            x, y = x0 + dx * look / looks, y0 + dy * look / looks
            for ray in range(rays):
                for step in range(steps + 1):
                    r = floor((y - origin[1]) / cell + step * across[ray])
                    c = floor((x - origin[0]) / cell + step * along[ray])
                    if r < 0 or c < 0 or r >= rows or c >= columns or kinds[r, c] == WALL:
                        break
                    if kinds[r, c] == NEW and marks[r, c] != k + 1:
                        marks[r, c] = k + 1
                        counts[k] += 1
    return counts
