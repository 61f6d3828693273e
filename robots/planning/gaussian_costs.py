"""Dearer ways near obstacles, by widening these with a Gaussian (Ziparo 2007 eq. 6)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy import ndimage

from robots.exploration.settings import ZiparoConfig
from robots.planning.plan_grid import OCCUPIED, PlanGrid

_OPEN, _DEAREST = 5, 15  # fifths of a cell; travel costs know nothing dearer


def with_gaussian_costs(grid: PlanGrid, told: ZiparoConfig) -> PlanGrid:
    """Return the grid with the costs of eq. (6): the length times 1 + alpha occ, occ after the convolution.

    Where the body does not fit it still does not; the dearest cells cost three times those in the open.
    """
    occupied = (grid.cells == OCCUPIED).astype(np.float64)
    occ = ndimage.gaussian_filter(occupied, told.obstacle_sd_m / grid.cell_m, mode="constant")
    steps = np.minimum(np.rint(_OPEN * (1.0 + told.alpha * occ)), _DEAREST)  # (6)
    return replace(grid, steps=np.where(grid.steps > 0, steps, 0).astype(np.uint8))
