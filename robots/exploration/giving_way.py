"""Giving way: two robots that meet in a door block each other for ever if both only back off."""

from __future__ import annotations

import numpy as np

from robots.exploration.aim import Aim
from robots.exploration.ground import Ground
from robots.planning.travel import UNREACHED

_OPEN_STEP = 5  # cost of a cell with nothing near
_FROM_M, _TO_M = 1.0, 5.0  # how far to go
_FOR_S = (5.0, 15.0)


def give_way(
    ground: Ground, place_m: tuple[float, float], rng: np.random.Generator
) -> tuple[Aim, float] | None:
    """Return the way to a free place, away from one where somebody wants to pass, and how long to wait (s).

    None where there is no such place.
    """
    grid, costs = ground.grid, ground.costs
    cost_m = costs / 5.0 * grid.cell_m
    free = (costs != UNREACHED) & (grid.steps == _OPEN_STEP) & (cost_m > _FROM_M) & (cost_m < _TO_M)
    rows, columns = np.nonzero(free)
    if len(rows) == 0:
        return None
    x = grid.origin[0] + (columns + 0.5) * grid.cell_m
    y = grid.origin[1] + (rows + 0.5) * grid.cell_m
    far = np.hypot(x - place_m[0], y - place_m[1])
    choices = np.argsort(-far, kind="stable")[: max(1, len(far) // 4)]
    at = int(choices[rng.integers(len(choices))])
    path = ground.path_to((int(rows[at]), int(columns[at])))
    if path is None:
        return None
    aim = Aim("place", "exploring", "giving way: somebody may want to pass here", None, path)
    return aim, float(rng.uniform(*_FOR_S))
