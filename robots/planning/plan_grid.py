"""The coarse grid that planning works on: free, occupied or unknown, and how far the next obstacle is."""

from __future__ import annotations

from dataclasses import dataclass
from math import floor

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robots.config import BodyConfig, MappingConfig, PlanningConfig
from robots.mapping.changes import Changes
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
    return PlanGrids(body, planning, mapping).of(fused, blocked)


class PlanGrids:
    """Makes the plan grids of a map, one after the other: only what changed meanwhile is worked out anew."""

    def __init__(self, body: BodyConfig, planning: PlanningConfig, mapping: MappingConfig) -> None:
        self._cell_m = planning.cell_m
        self._occupied, self._free = mapping.occupied_logodds, mapping.miss_logodds
        self._keep_off_m = body.radius_m + planning.clearance_m
        self._comfort_m = body.radius_m + planning.comfort_m
        self._cells: NDArray[np.uint8] = np.zeros((0, 0), np.uint8)
        self._steps: NDArray[np.uint8] = np.zeros((0, 0), np.uint8)
        self._squared: NDArray[np.float32] = np.zeros((0, 0), np.float32)
        self._changes: Changes | None = None  # of the map that the grid was made of,
        self._seen: tuple[tuple[int, ...], tuple[float, float], int] = (), (0.0, 0.0), 0  # as it was then

    def of(self, fused: FusedGrid, blocked: NDArray[np.float64]) -> PlanGrid:
        """Return the plan grid of the map as it is now.

        ``blocked`` (n, 3): x, y, radius of places put aside because driving there failed.
        """
        self._follow(fused)
        cell_m = fused.resolution_m * self._factor(fused)
        grid = PlanGrid(self._cells.copy(), self._steps.copy(), fused.origin, cell_m)
        for x, y, radius in blocked:
            row, column = grid.cell_of(x, y)
            reach = int(radius / grid.cell_m)
            rows = slice(max(0, row - reach), max(0, row + reach + 1))
            grid.steps[rows, max(0, column - reach) : max(0, column + reach + 1)] = 0
        return grid

    def _factor(self, fused: FusedGrid) -> int:
        return max(1, round(self._cell_m / fused.resolution_m))

    def _follow(self, fused: FusedGrid) -> None:
        shape, seen, factor = fused.cells.shape, self._seen, self._factor(fused)
        rows, columns = shape[0] // factor, shape[1] // factor
        changed = None
        if self._changes is fused.changes and seen[:2] == (shape, fused.origin):
            changed = fused.changes.since(seen[2])
        if changed is None:
            changed = (0, 0, *shape)
            self._cells = np.zeros((rows, columns), np.uint8)
            self._steps = np.zeros((rows, columns), np.uint8)
            self._squared = np.empty((rows, columns), np.float32)
        self._changes, self._seen = fused.changes, (shape, fused.origin, fused.changes.revision)
        top, left, bottom, right = changed
        # to the centre of an occupied cell of the fine map, which begins half a cell before it
        keep_off = self._keep_off_m / fused.resolution_m + 0.5
        if top < bottom and left < right:
            _update(
                fused.cells, self._cells, self._squared, self._steps, factor, self._occupied, self._free,
                keep_off, self._comfort_m / fused.resolution_m, top, left, bottom, right,
            )  # fmt: skip


@njit(cache=True)
def _update(
    fused: NDArray[np.int32],
    cells: NDArray[np.uint8],
    squared: NDArray[np.float32],
    steps: NDArray[np.uint8],
    factor: int,
    occupied: int,
    free: int,
    keep_off: float,
    comfort: float,
    top: int,
    left: int,
    bottom: int,
    right: int,
) -> None:
    """Bring cells, squared distances to obstacles and steps up to date with a change of the fine map."""
    height, width = fused.shape
    rows, columns = cells.shape
    reach = int(np.ceil(comfort / factor)) + 1
    top, left = max(0, top - 1) // factor, max(0, left - 1) // factor  # neighbours tell who lies inside
    bottom = min(rows, (min(height, bottom + 1) + factor - 1) // factor)
    right = min(columns, (min(width, right + 1) + factor - 1) // factor)
    _coarsen(fused, cells, factor, occupied, free, top, left, bottom, right)
    top, left = max(0, top - reach), max(0, left - reach)
    bottom, right = min(rows, bottom + reach), min(columns, right + reach)
    squared[top:bottom, left:right] = _FAR * _FAR
    for y in range(max(0, top - reach) * factor, min(height, (bottom + reach) * factor)):
        for x in range(max(0, left - reach) * factor, min(width, (right + reach) * factor)):
            if fused[y, x] >= occupied and not _is_inner(fused, y, x, occupied):
                _near(squared, y, x, factor, reach, top, left, bottom, right)
    _cost(cells, squared, steps, keep_off, comfort, top, left, bottom, right)


@njit(cache=True)
def _coarsen(
    fused: NDArray[np.int32],
    cells: NDArray[np.uint8],
    factor: int,
    occupied: int,
    free: int,
    top: int,
    left: int,
    bottom: int,
    right: int,
) -> None:
    for r in range(top, bottom):
        for c in range(left, right):
            state = UNKNOWN
            for y in range(r * factor, (r + 1) * factor):
                for x in range(c * factor, (c + 1) * factor):
                    v = fused[y, x]
                    if v >= occupied:
                        state = OCCUPIED
                    elif v <= -free and state == UNKNOWN:
                        state = FREE
            cells[r, c] = state


@njit(cache=True)
def _is_inner(fused: NDArray[np.int32], y: int, x: int, occupied: int) -> bool:
    """Whether the cells round an occupied one are occupied too, and so nearer to everything free."""
    height, width = fused.shape
    if not (0 < y < height - 1 and 0 < x < width - 1):
        return False
    return bool(
        fused[y - 1, x] >= occupied
        and fused[y + 1, x] >= occupied
        and fused[y, x - 1] >= occupied
        and fused[y, x + 1] >= occupied
    )


@njit(cache=True)
def _near(
    squared: NDArray[np.float32],
    y: int,
    x: int,
    factor: int,
    reach: int,
    top: int,
    left: int,
    bottom: int,
    right: int,
) -> None:
    """Lower the distances of the coarse cells near a fine one.

    Distances are measured on the fine map, in its cells: a door must not narrow by the coarse ones.
    """
    r, c = y // factor, x // factor
    for v in range(max(top, r - reach), min(bottom, r + reach + 1)):
        dy = (v + 0.5) * factor - (y + 0.5)
        for u in range(max(left, c - reach), min(right, c + reach + 1)):
            dx = (u + 0.5) * factor - (x + 0.5)
            squared[v, u] = min(squared[v, u], np.float32(dx * dx + dy * dy))


@njit(cache=True)
def _cost(
    cells: NDArray[np.uint8],
    squared: NDArray[np.float32],
    steps: NDArray[np.uint8],
    keep_off: float,
    comfort: float,
    top: int,
    left: int,
    bottom: int,
    right: int,
) -> None:
    """Cost of entering each cell: 5 in the open, up to 15 near obstacles, 0 where the body does not fit."""
    for r in range(top, bottom):
        for c in range(left, right):
            d = float(squared[r, c]) ** 0.5
            if cells[r, c] != FREE or d < keep_off:
                steps[r, c] = 0
            elif d >= comfort:
                steps[r, c] = 5
            else:
                steps[r, c] = 5 + int(10.0 * (comfort - d) / (comfort - keep_off + 1e-9))
