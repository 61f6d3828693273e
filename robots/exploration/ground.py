"""The ground as a robot can drive it: the plan grid and what it costs to get everywhere from here."""

from __future__ import annotations

from dataclasses import dataclass
from math import floor, hypot

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robots.exploration.frontiers import Frontier, Leg
from robots.planning.plan_grid import PlanGrid
from robots.planning.travel import UNREACHED, find_path, travel_costs
from robots.se2 import Array, Pose2

_FARTHEST_M = 1e6
_PER_CELL = 5.0  # cost of a cell in the open


@dataclass(frozen=True, slots=True, eq=False)
class Ground:
    """The plan grid, and ``costs`` int32 (h, w) of driving to its cells from ``pose`` in the map frame."""

    grid: PlanGrid
    costs: NDArray[np.int32]
    pose: Pose2

    @classmethod
    def of(cls, grid: PlanGrid, pose: Pose2) -> Ground:
        """Return the ground of a grid as it is from a pose."""
        return cls(grid, travel_costs(grid, *grid.cell_of(pose.x, pose.y)), pose)

    def cost_m(self, cell: tuple[int, int]) -> float:
        """Return what it costs to get to a cell that can be reached, in metres of open ground."""
        return float(self.costs[cell]) / _PER_CELL * self.grid.cell_m

    def nearest(self, x: float, y: float, within_m: float) -> tuple[int, int] | None:
        """Return the reachable cell (row, column) nearest to a point (map frame), None where all are farther.

        Of those equally near the one that is cheapest to reach.
        """
        grid = self.grid
        row, column = _nearest(self.costs, grid.origin, grid.cell_m, x, y, min(within_m, _FARTHEST_M))
        return None if row < 0 else (row, column)

    def path_to(self, cell: tuple[int, int]) -> Array | None:
        """Return the way to a cell, (n, 2) points in the map frame; None where there is none."""
        grid = self.grid
        cells = find_path(grid, grid.cell_of(self.pose.x, self.pose.y), cell)
        return None if cells is None else grid.centres_of(cells)

    def way_to(self, frontier: Frontier) -> Array | None:
        """Return the way to a frontier, (n, 2) points in the map frame, by its stations if it has any."""
        if isinstance(frontier, Leg):
            return np.array(frontier.way_m)
        return self.path_to(frontier.goal)

    def distance_m(self, x: float, y: float) -> float:
        """Return how far (m) a point of the map frame is as the crow flies."""
        return hypot(x - self.pose.x, y - self.pose.y)


@njit(cache=True)
def _nearest(
    costs: NDArray[np.int32], origin: tuple[float, float], cell_m: float, x: float, y: float, within: float
) -> tuple[int, int]:
    rows, columns = costs.shape
    best, best_cost, best_row, best_column = within, UNREACHED, -1, -1
    low, left = floor((y - within - origin[1]) / cell_m) - 1, floor((x - within - origin[0]) / cell_m) - 1
    high, right = floor((y + within - origin[1]) / cell_m) + 2, floor((x + within - origin[0]) / cell_m) + 2
    for r in range(max(0, low), min(rows, high)):
        for c in range(max(0, left), min(columns, right)):
            if costs[r, c] == UNREACHED:
                continue
            away = hypot(origin[0] + (c + 0.5) * cell_m - x, origin[1] + (r + 0.5) * cell_m - y)
            far = np.rint(1000.0 * away) / 1000.0
            if far < best or (far == best and costs[r, c] < best_cost):
                best, best_cost, best_row, best_column = far, costs[r, c], r, c
    return best_row, best_column
