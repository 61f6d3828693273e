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

    def centres_of(self, cells: NDArray[np.integer]) -> NDArray[np.float64]:
        """Return the centres (n, 2), x and y in the map frame, of cells (n, 2), row and column."""
        centres: NDArray[np.float64] = np.array(self.origin) + (cells[:, ::-1] + 0.5) * self.cell_m
        return centres

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
    # to the centre of an occupied cell of the fine map, which begins half a cell before it
    keep_off_m = body.radius_m + planning.clearance_m + fused.resolution_m / 2.0
    comfort_m = body.radius_m + planning.comfort_m
    steps = _step_costs(
        fused.cells,
        cells,
        factor,
        mapping.occupied_logodds,
        keep_off_m / fused.resolution_m,
        comfort_m / fused.resolution_m,
    )
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
def _step_costs(
    fused: NDArray[np.int32],
    cells: NDArray[np.uint8],
    factor: int,
    occupied: int,
    keep_off: float,
    comfort: float,
) -> NDArray[np.uint8]:
    """Cost of entering each cell: 5 in the open, up to 15 next to obstacles, 0 where the body does not fit.

    Distances are measured on the fine map, in its cells: a door must not narrow by the coarse ones.
    """
    rows, columns = cells.shape
    height, width = fused.shape
    squared = np.full((rows, columns), _FAR * _FAR, np.float32)
    reach = int(np.ceil(comfort / factor)) + 1
    for y in range(height):
        for x in range(width):
            if fused[y, x] < occupied:
                continue
            inner = (
                0 < y < height - 1
                and 0 < x < width - 1
                and fused[y - 1, x] >= occupied
                and fused[y + 1, x] >= occupied
                and fused[y, x - 1] >= occupied
                and fused[y, x + 1] >= occupied
            )
            if inner:  # the cells round it are nearer to everything free
                continue
            r, c = y // factor, x // factor
            for v in range(max(0, r - reach), min(rows, r + reach + 1)):
                dy = (v + 0.5) * factor - (y + 0.5)
                for u in range(max(0, c - reach), min(columns, c + reach + 1)):
                    dx = (u + 0.5) * factor - (x + 0.5)
                    d = dx * dx + dy * dy
                    if d < squared[v, u]:
                        squared[v, u] = d
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
