"""Ways that something shuts: where to look whether it has gone by now.

What shuts a way may be a robot that stood there when it was last seen, and a robot that looks elsewhere keeps
it in its map for ever. So it goes as far as it can on the way that would be best if things could go and looks
there. Ground that it drove before is likelier to be open again than other ground, and that than a wall.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from robots.exploration.frontiers import Frontier, find_shut_off
from robots.exploration.ground import Ground
from robots.planning.plan_grid import OCCUPIED, PlanGrid
from robots.planning.travel import UNREACHED, find_path
from robots.se2 import Array

SHUT = "look whether the way beyond is open by now"
_TIGHT = 15  # fifths of a cell: entering what is too near to obstacles
_JUMP_M = 0.6
_DRIVEN, _NARROW, _WALL = 20, 60, 250  # fifths of a cell: entering what cannot be driven on as it is


def squeezed(ground: Ground, trail: Array) -> Ground:
    """Return the ground where a robot may also go where it drove before, unless something stands there.

    A body that came through a gap fits, though the map may have it narrower by now. ``trail`` (k, 2 or more):
    x, y in the map frame of where it was, in order.
    """
    grid = ground.grid
    steps = np.where(_driven(grid, trail) & (grid.cells != OCCUPIED) & (grid.steps == 0), _TIGHT, grid.steps)
    return Ground.of(replace(grid, steps=steps.astype(np.uint8)), ground.pose)


def hopeful(grid: PlanGrid, trail: Array) -> PlanGrid:
    """Return the grid in which everything can be driven over, at a price; ``trail`` as in ``squeezed``."""
    shut = np.where(grid.cells == OCCUPIED, _WALL, _NARROW)
    shut = np.where(ndimage.binary_dilation(_driven(grid, trail), np.ones((3, 3), np.bool_)), _DRIVEN, shut)
    return replace(grid, steps=np.where(grid.steps > 0, grid.steps, shut).astype(np.uint8))


def _driven(grid: PlanGrid, trail: Array) -> NDArray[np.bool_]:
    """Return the cells, (h, w), that the robot drove over."""
    places = trail[:, :2]
    if len(places) > 1:  # between points of the trail too, but not where the map jumped
        before, after = places[:-1], places[1:]
        on = np.hypot(*(after - before).T) < _JUMP_M
        shares = np.arange(0.0, 1.0, 0.125)[:, None, None]
        places = np.concatenate([places, (before[on] + shares * (after - before)[on]).reshape(-1, 2)])
    cells = np.floor((places[:, ::-1] - grid.origin[::-1]) / grid.cell_m).astype(int)
    cells = cells[((cells >= 0) & (cells < grid.cells.shape)).all(axis=1)]
    driven = np.zeros(grid.cells.shape, np.bool_)
    driven[cells[:, 0], cells[:, 1]] = True
    return driven


def as_far_as_it_goes(ground: Ground, hope: PlanGrid, place: tuple[int, int]) -> tuple[int, int] | None:
    """Return the last cell (row, column) that can be reached on the way to one that cannot.

    ``hope`` as ``hopeful`` gives it. None where the place lies outside the grid.
    """
    way = find_path(hope, ground.grid.cell_of(ground.pose.x, ground.pose.y), place)
    if way is None:
        return None
    reached = np.flatnonzero(ground.costs[way[:, 0], way[:, 1]] != UNREACHED)
    row, column = way[reached[-1]]
    return int(row), int(column)


def shut_off(ground: Ground, trail: Array, min_length_m: float) -> tuple[Frontier, ...]:
    """Return the frontiers that cannot be reached, nearest first.

    The goal of each is as far as the way there can be driven; ``trail`` as in ``hopeful``.
    """
    found = find_shut_off(ground.grid, ground.costs, min_length_m)
    hope = hopeful(ground.grid, trail) if found else ground.grid
    frontiers = []
    for place, length_m in found:
        goal = as_far_as_it_goes(ground, hope, place)
        if goal is not None:
            frontiers.append(Frontier(goal, ground.grid.centre_of(*goal), length_m, ground.cost_m(goal)))
    return tuple(sorted(frontiers, key=lambda frontier: (frontier.cost_m, frontier.goal)))
