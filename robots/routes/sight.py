"""Whether one place can be seen from another on the fused map."""

from __future__ import annotations

import numpy as np

from robots.team import TeamGrid

OCCUPIED_FROM = 65  # per cent, as ROS's map_server
_NEAR_END_M = 0.6  # a victim often lies against something


def is_clear(grid: TeamGrid, start: tuple[float, float], end: tuple[float, float]) -> bool:
    """Say whether no wall stands between two points of the world frame, the last half metre left out."""
    dx, dy = end[0] - start[0], end[1] - start[1]
    far = max(0.0, float(np.hypot(dx, dy)) - _NEAR_END_M)
    steps = np.arange(0.0, far, grid.resolution_m / 2.0) / max(float(np.hypot(dx, dy)), 1e-9)
    columns = np.floor((start[0] + dx * steps - grid.origin_m[0]) / grid.resolution_m).astype(int)
    rows = np.floor((start[1] + dy * steps - grid.origin_m[1]) / grid.resolution_m).astype(int)
    height, width = grid.cells.shape
    inside = (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width)
    return not bool((grid.cells[rows[inside], columns[inside]] >= OCCUPIED_FROM).any())
