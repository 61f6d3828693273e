"""Of what kind a place is, by the walls round it on the fused map; nothing where the map does not tell."""

from __future__ import annotations

from typing import Literal

import numpy as np

from robots.routes.corridor import is_corridor
from robots.routes.doorway import is_doorway
from robots.routes.outlook import REACH_M, WALL, Outlook, Plan, outlook, plan_of
from robots.se2 import Array
from robots.team import TeamGrid

PlaceKind = Literal["", "doorway", "corridor", "room", "open_area"]

_SHUT_M, _SHUT = 2.2, 0.75  # so wide a gap is a door, if no wider than this share of the place itself
_OPEN_M = 10.0  # as long and wide as that
_COMPACT = 0.75  # of its rectangle is within it
_WALLED = 0.9  # of what surrounds it are walls
_STEP_M, _STEPS = 0.2, 8  # away from walls, to look round
_AROUND_M = REACH_M + 3.0  # of the map that is looked at


def around(grid: TeamGrid, x_m: float, y_m: float) -> TeamGrid:
    """Return the part of a fused map that tells of what kind the place at a point of the world frame is."""
    reach = round(_AROUND_M / grid.resolution_m)
    column = int(np.floor((x_m - grid.origin_m[0]) / grid.resolution_m))
    row = int(np.floor((y_m - grid.origin_m[1]) / grid.resolution_m))
    left, bottom = max(0, column - reach), max(0, row - reach)
    cells = grid.cells[bottom : max(0, row + reach + 1), left : max(0, column + reach + 1)]
    origin_m = grid.origin_m[0] + left * grid.resolution_m, grid.origin_m[1] + bottom * grid.resolution_m
    return TeamGrid(cells, origin_m, grid.resolution_m, grid.version)


def kind_of(grid: TeamGrid, x_m: float, y_m: float) -> PlaceKind:
    """Return of what kind the place at a point of the world frame is, "" where the map does not tell.

    A doorway parts what is wider on both sides; in a corridor walls run along on both sides; a room is
    compact and closed but for doors; an open area is 10 m long and wide, however it ends.
    """
    near, place_m = around(grid, x_m, y_m), np.array([x_m, y_m])
    if not near.cells.size:
        return ""
    plan = plan_of(near)
    here = outlook(plan, place_m)
    if here.ranges_m.min() <= 0.0:  # in a wall, or where nobody has looked
        return ""
    if is_doorway(plan, place_m, here):
        return "doorway"
    place_m, here = _away_from_walls(plan, place_m, here)
    if is_corridor(plan, place_m):
        return "corridor"
    seen = outlook(plan, place_m, min(_SHUT_M, _SHUT * 2.0 * float(here.ranges_m.min())))
    width_m, compact = _rectangle(seen.corners_m)
    if compact < _COMPACT:
        return ""
    if width_m >= _OPEN_M:
        return "open_area"
    return "room" if (seen.ends == WALL).mean() >= _WALLED else ""


def _away_from_walls(plan: Plan, place_m: Array, here: Outlook) -> tuple[Array, Outlook]:
    """Return a place near by with more room round it: in a corner, walls near by hide the rest."""
    for _ in range(_STEPS):
        near = here.ranges_m <= here.ranges_m.min() + plan.resolution_m
        towards = here.corners_m[near].mean(axis=0)
        next_m = place_m - _STEP_M * towards / max(float(np.hypot(*towards)), 1e-9)
        there = outlook(plan, next_m)
        if there.ranges_m.min() <= here.ranges_m.min():
            break
        place_m, here = next_m, there
    return place_m, here


def _rectangle(corners: Array) -> tuple[float, float]:
    """Return the width (m) of the rectangle with a polygon's moments, and the share filled.

    A rectangle a x b has variances a^2 / 12 and b^2 / 12 along its sides.
    """
    after = np.roll(corners, -1, axis=0)
    both = corners + after
    areas = (corners[:, 0] * after[:, 1] - corners[:, 1] * after[:, 0]) / 2.0
    area = max(float(areas.sum()), 1e-9)
    middle = areas @ both / (3.0 * area)
    # integral of x x^T over each triangle (0, a, b): area / 12 (a a^T + b b^T + (a + b)(a + b)^T)
    moments = sum((p.T * areas) @ p for p in (corners, after, both)) / (12.0 * area)
    values = np.linalg.eigvalsh(moments - np.outer(middle, middle))
    width_m, length_m = np.sqrt(12.0 * np.maximum(values, 1e-12))
    return float(width_m), area / float(length_m * width_m)
