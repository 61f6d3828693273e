"""What one robot has to tell a tag: the ground it knows round it, and where it drove."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robots.exploration.frontiers import edges_of
from robots.planning.plan_grid import UNKNOWN, PlanGrid
from robots.se2 import Array
from robots.tags.memory import (
    CENTRED,
    CLOSED,
    OPEN,
    REACH,
    SIDE,
    VISITED_M,
    VISITED_REACH,
    TagMemory,
    cell_of,
    shift_of,
)
from robots.tags.window import no_cells, resized, trimmed

_KNOWN_SHARE = 0.25  # walls fill much of a cell; what is free in it is closed all the same


def observed_memory(
    grid: PlanGrid,
    tag_x: float,
    tag_y: float,
    phase: int = CENTRED,
    min_frontier_m: float = 0.0,
    told: NDArray[np.uint8] | None = None,
    edge: NDArray[np.bool_] | None = None,
) -> TagMemory:
    """Return what a robot's plan grid (map frame, x north) knows round a tag at (x, y).

    ``phase``: the lattice of its cells. A cell is open while a frontier of ``min_frontier_m`` or more lies in
    it, and else closed once some of it is known: there is no way from a closed cell to one nobody has seen.
    ``told`` (s, s), on the same lattice: what was called open is closed once no frontier is left and anything
    of it is known, or strips along walls stay open for ever. ``edge`` (h, w): the cells of those frontiers,
    where they are known already.
    """
    if not grid.cells.size:
        return TagMemory.empty()
    edge = edges_of(grid, min_frontier_m) if edge is None else edge
    shift = shift_of(phase)
    cell_m = cell_of(phase)
    x_edges = _edges(tag_x + shift[0], grid.origin[0], grid.cell_m, cell_m)
    y_edges = _edges(tag_y + shift[1], grid.origin[1], grid.cell_m, cell_m)
    least = _KNOWN_SHARE * (cell_m / grid.cell_m) ** 2
    told = no_cells() if told is None else told
    cells = _states(grid.cells, edge, x_edges, y_edges, least, resized(told, SIDE))
    return TagMemory(trimmed(cells), phase=phase if cells.any() else CENTRED)


def visited_window(trail_m: Array, tag_x: float, tag_y: float) -> NDArray[np.uint8]:
    """Return the cells round a tag that a trail, (n, 2) or wider in the map frame, leads through.

    1 where it came once, 2 where it left and came again.
    """
    cells = _entered(np.asarray(trail_m, np.float64), tag_x, tag_y)
    return trimmed(cells) if cells.any() else no_cells()


@njit(cache=True)
def _entered(trail: Array, x: float, y: float) -> NDArray[np.uint8]:
    """Return how often, at most twice, the trail came into each cell round a point."""
    side = 2 * VISITED_REACH + 1
    cells = np.zeros((side, side), np.uint8)
    last_r, last_c = -1, -1
    for k in range(len(trail)):
        r = int(np.rint((trail[k, 0] - x) / VISITED_M)) + VISITED_REACH
        c = int(np.rint((trail[k, 1] - y) / VISITED_M)) + VISITED_REACH
        if (k == 0 or r != last_r or c != last_c) and 0 <= r < side and 0 <= c < side:
            cells[r, c] = min(2, cells[r, c] + 1)
        last_r, last_c = r, c
    return cells


def _edges(middle: float, origin: float, grid_m: float, cell_m: float) -> NDArray[np.int64]:
    """Return where the cells of a window begin and end along an axis, (SIDE + 1,), in cells of the grid."""
    edges: NDArray[np.int64] = np.rint(
        (middle + (np.arange(SIDE + 1) - REACH - 0.5) * cell_m - origin) / grid_m
    ).astype(np.int64)
    return edges


@njit(cache=True)
def _states(
    cells: NDArray[np.uint8],
    edge: NDArray[np.bool_],
    x: NDArray[np.int64],
    y: NDArray[np.int64],
    least: float,
    told: NDArray[np.uint8],
) -> NDArray[np.uint8]:
    """Return the state of each cell of a window (rows along x), of a grid (rows along y)."""
    rows, columns = cells.shape
    states = np.zeros(told.shape, np.uint8)
    for i in range(len(x) - 1):
        for j in range(len(y) - 1):
            known = 0
            is_open = False
            for r in range(max(0, y[j]), min(rows, y[j + 1])):
                for c in range(max(0, x[i]), min(columns, x[i + 1])):
                    known += cells[r, c] != UNKNOWN
                    is_open |= edge[r, c]
            if is_open:
                states[i, j] = OPEN
            elif known >= least or (known > 0 and told[i, j] == OPEN):
                states[i, j] = CLOSED
    return states
