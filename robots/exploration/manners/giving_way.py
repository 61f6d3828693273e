"""Giving way: two robots that meet in a door block each other for ever if both only back off."""

from __future__ import annotations

import numpy as np

from robots.exploration.aim import Aim
from robots.exploration.ground import Ground
from robots.exploration.manners.recovery import spot_aside

_FOR_S = (5.0, 15.0)


def give_way(
    ground: Ground, place_m: tuple[float, float], rng: np.random.Generator
) -> tuple[Aim, float] | None:
    """Return the way to a free place, away from one where somebody wants to pass, and how long to wait (s).

    None where there is no such place.
    """
    spot = spot_aside(ground.grid, ground.costs, place_m, rng)
    path = None if spot is None else ground.path_to(spot)
    if path is None:
        return None
    aim = Aim("place", "exploring", "giving way: somebody may want to pass here", None, path)
    return aim, float(rng.uniform(*_FOR_S))
