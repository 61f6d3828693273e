"""The coarse grid that planning works on: free, occupied or unknown, and how far the next obstacle is."""

from __future__ import annotations

from dataclasses import dataclass
from math import floor

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robots.config import BodyConfig, MappingConfig, PlanningConfig
from robots.mapping.fused import FusedGrid

UNKNOWN, FREE, OCCUPIED = 0, 1, 2
_FAR = 200  # cells: farther than any clearance that matters


@dataclass(frozen=True, slots=True, eq=False)
class PlanGrid:
    """The ground as planning sees it, and what it costs to drive there.

    ``cells`` uint8 (h, w) of UNKNOWN, FREE, OCCUPIED; ``steps`` uint8 (h, w), the cost in fifths of a cell of
    entering a cell (0: not for this body). Cell (0, 0) has its lower left corner at ``origin`` (x, y) in the
    map frame, metres.
    """

    cells: NDArray[np.uint8]
    steps: NDArray[np.uint8]
    origin: tuple[float, float]
    cell_m: float

    def cell_of(self, x: float, y: float) -> tuple[int, int]:
        """Return (row, column) of a point in the map frame; it may lie outside the grid."""
        return floor((y - self.origin[1]) / self.cell_m), floor((x - self.origin[0]) / self.cell_m)

    def centre_of(self, row: int, column: int) -> tuple[float, float]:
        """Return the centre (x, y) of a cell in the map frame."""
        return self.origin[0] + (column + 0.5) * self.cell_m, self.origin[1] + (row + 0.5) * self.cell_m

    def holds(self, row: int, column: int) -> bool:
        """Say whether the cell lies in the grid."""
        rows, columns = self.cells.shape
        return bool(0 <= row < rows and 0 <= column < columns)


def plan_grid(
    fused: FusedGrid,
    body: BodyConfig,
    planning: PlanningConfig,
    mapping: MappingConfig,
    blocked: NDArray[np.float64],
) -> PlanGrid:
    """Make the plan grid of a fused map.

    ``blocked`` (n, 3): x, y, radius of places put aside because driving there failed.
    """
    factor = max(1, round(planning.cell_m / fused.resolution_m))
    cells = _coarsen(fused.cells, factor, mapping.occupied_logodds, mapping.miss_logodds)
    cell_m = fused.resolution_m * factor
    keep_off = body.radius_m + planning.clearance_m
    steps = _step_costs(cells, keep_off / cell_m, (body.radius_m + planning.comfort_m) / cell_m)
    grid = PlanGrid(cells, steps, fused.origin, cell_m)
    for x, y, radius in blocked:
        row, column = grid.cell_of(x, y)
        reach = int(radius / cell_m)
        rows = slice(max(0, row - reach), max(0, row + reach + 1))
        grid.steps[rows, max(0, column - reach) : max(0, column + reach + 1)] = 0
    return grid


@njit(cache=True)
def _coarsen(fused: NDArray[np.int32], factor: int, occupied: int, free: int) -> NDArray[np.uint8]:
    rows, columns = fused.shape[0] // factor, fused.shape[1] // factor
    cells = np.zeros((rows, columns), np.uint8)
    for r in range(rows):
        for c in range(columns):
            state = UNKNOWN
            for y in range(r * factor, (r + 1) * factor):
                for x in range(c * factor, (c + 1) * factor):
                    v = fused[y, x]
                    if v >= occupied:
                        state = OCCUPIED
                    elif v <= -free and state == UNKNOWN:
                        state = FREE
            cells[r, c] = state
    return cells


@njit(cache=True)
def _step_costs(cells: NDArray[np.uint8], keep_off: float, comfort: float) -> NDArray[np.uint8]:
    """Return the cost of entering each cell.

    5 in the open, up to 15 next to obstacles, 0 where the body does not fit.
    """
    rows, columns = cells.shape
    squared = np.full((rows, columns), _FAR * _FAR, np.int32)
    reach = int(np.ceil(comfort))
    for r in range(rows):
        for c in range(columns):
            if cells[r, c] != OCCUPIED:
                continue
            inner = (
                0 < r < rows - 1 and 0 < c < columns - 1
                and cells[r - 1, c] == OCCUPIED and cells[r + 1, c] == OCCUPIED
                and cells[r, c - 1] == OCCUPIED and cells[r, c + 1] == OCCUPIED
            )  # fmt: skip
            if inner:  # the cells round it are nearer to everything free
                squared[r, c] = 0
                continue
            for y in range(max(0, r - reach), min(rows, r + reach + 1)):
                for x in range(max(0, c - reach), min(columns, c + reach + 1)):
                    d = (y - r) * (y - r) + (x - c) * (x - c)
                    if d < squared[y, x]:
                        squared[y, x] = d
    steps = np.zeros((rows, columns), np.uint8)
    for r in range(rows):
        for c in range(columns):
            if cells[r, c] != FREE:
                continue
            d = float(squared[r, c]) ** 0.5
            if d < keep_off:
                continue
            steps[r, c] = 5 if d >= comfort else 5 + int(10.0 * (comfort - d) / (comfort - keep_off + 1e-9))
    return steps
