"""Where to stand when there is nothing to do: where others still get past."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from robots.exploration.ground import Ground
from robots.planning.travel import UNREACHED, travel_costs
from robots.se2 import Array

_LOST_M2 = 0.5  # of ground that nobody gets to any more: less is a corner
_LATTICE_M = 0.4  # between places that are tried
_MOST = 60
_IN_DOORS = 9  # fifths of a cell: what it costs at least to enter the cells of a door 1 m wide


def parking_place(
    ground: Ground, place_m: tuple[float, float], rings_m: tuple[float, ...], apart_m: float
) -> tuple[int, int] | None:
    """Return the cell nearest by way where a body that stands shuts no way, None where there is none.

    ``rings_m``: distances from a place (map frame); the first within which there is one counts, in the open
    before doors and the like. ``apart_m``:
    so near to the body no other one's middle gets.
    """
    grid = ground.grid
    stride = max(1, round(_LATTICE_M / grid.cell_m))
    here = grid.cell_of(ground.pose.x, ground.pose.y)
    cells = np.argwhere(ground.costs != UNREACHED)
    cells = cells[np.all((cells - here) % stride == 0, axis=1)]
    off_m: Array = np.hypot(*(grid.centres_of(cells) - place_m).T)
    ring = np.searchsorted(rings_m, off_m)
    order = np.lexsort(
        (ground.costs[cells[:, 0], cells[:, 1]], ring, _narrow(ground)[cells[:, 0], cells[:, 1]])
    )
    for row, column in cells[order[ring[order] < len(rings_m)][:_MOST]].tolist():
        if not _shuts(ground, row, column, apart_m):
            return row, column
    return None


def _narrow(ground: Ground) -> NDArray[np.bool_]:
    """Return the cells, (h, w), so near to obstacles that they may lie in a door."""
    narrow: NDArray[np.bool_] = ground.grid.steps > _IN_DOORS
    return narrow


def _shuts(ground: Ground, row: int, column: int, apart_m: float) -> bool:
    """Say whether standing there cuts ground off from the rest."""
    grid = ground.grid
    rows, columns = np.arange(grid.cells.shape[0])[:, None], np.arange(grid.cells.shape[1])
    taken = (rows - row) ** 2 + (columns - column) ** 2 < (apart_m / grid.cell_m) ** 2
    left = (ground.costs != UNREACHED) & ~taken & (grid.steps > 0)
    if not left.any():
        return False
    farthest = divmod(int(np.where(left, ground.costs, -1).argmax()), left.shape[1])
    others = replace(grid, steps=np.where(taken, 0, grid.steps).astype(np.uint8))
    got_to = travel_costs(others, *farthest) != UNREACHED
    return float((left & ~got_to).sum()) * grid.cell_m**2 > _LOST_M2
