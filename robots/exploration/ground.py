"""The ground as a robot can drive it: the plan grid and what it costs to get everywhere from here."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import hypot

import numpy as np
from numpy.typing import NDArray

from robots.planning.plan_grid import PlanGrid
from robots.planning.travel import UNREACHED, find_path, travel_costs
from robots.se2 import Array, Pose2

_PER_CELL = 5.0  # cost of a cell in the open
_ALONG_M, _ASIDE = 0.2, 2  # how near is along a place; what a cell costs more that is not


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
        cells = np.argwhere(self.costs != UNREACHED)
        if len(cells) == 0:
            return None
        gaps = self.grid.centres_of(cells) - np.array([x, y])
        far: Array = np.round(np.hypot(gaps[:, 0], gaps[:, 1]), 3)
        at = int(np.lexsort((self.costs[cells[:, 0], cells[:, 1]], far))[0])
        return None if far[at] > within_m else (int(cells[at, 0]), int(cells[at, 1]))

    def path_to(self, cell: tuple[int, int], along_m: Array | None = None) -> Array | None:
        """Return the way to a cell, (n, 2) points in the map frame; None where there is none.

        ``along_m`` (k, 2): places through which it rather leads, a little longer if need be.
        """
        grid = self.grid if along_m is None or len(along_m) == 0 else self._rather_along(along_m)
        cells = find_path(grid, grid.cell_of(self.pose.x, self.pose.y), cell)
        return None if cells is None else grid.centres_of(cells)

    def _rather_along(self, places_m: Array) -> PlanGrid:
        grid, steps = self.grid, self.grid.steps
        aside = np.ones(steps.shape, bool)
        reach = round(_ALONG_M / grid.cell_m)
        middle = np.floor((places_m[:, ::-1] - np.array(grid.origin[::-1])) / grid.cell_m).astype(np.int64)
        for r in range(-reach, reach + 1):
            for c in range(-reach, reach + 1):
                cells = middle + np.array([r, c])
                cells = cells[((cells >= 0) & (cells < steps.shape)).all(axis=1)]
                aside[cells[:, 0], cells[:, 1]] = False
        return replace(grid, steps=np.where(aside & (steps > 0), steps + _ASIDE, steps).astype(np.uint8))

    def distance_m(self, x: float, y: float) -> float:
        """Return how far (m) a point of the map frame is as the crow flies."""
        return hypot(x - self.pose.x, y - self.pose.y)
