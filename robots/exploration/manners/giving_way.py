"""Giving way: two robots that meet in a door block each other for ever if both only back off."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robots.exploration.aim import Aim
from robots.exploration.ground import Ground
from robots.exploration.manners.recovery import spot_aside

_FOR_S = (5.0, 15.0)


class GivingWay:
    """Goes aside and waits there, for a time drawn from ``seed``."""

    def __init__(self, seed: Sequence[int]) -> None:
        self._rng = np.random.default_rng(seed)
        self._place_m: tuple[float, float] | None = None  # where somebody else seems to want to pass
        self._until_s: float | None = None

    def ask(self, place_m: tuple[float, float]) -> None:
        """Give way at the next plan to somebody who wants to pass at a place (map frame)."""
        self._place_m = place_m

    def stop(self) -> None:
        """Go on with what there is to do."""
        self._until_s = None

    def goes_on(self, now_s: float) -> bool:
        """Say whether the robot is still on its way aside or waiting there."""
        if self._until_s is not None and now_s >= self._until_s:
            self._until_s = None
        return self._until_s is not None

    def aim(self, now_s: float, ground: Ground) -> Aim | None:
        """Return the way to a free place, away from where somebody wants to pass; None where nobody does."""
        place, self._place_m = self._place_m, None
        spot = None if place is None else spot_aside(ground.grid, ground.costs, place, self._rng)
        path = None if spot is None else ground.path_to(spot)
        if path is None:
            return None
        self._until_s = now_s + float(self._rng.uniform(*_FOR_S))
        return Aim("place", "exploring", "giving way: somebody may want to pass here", None, path)
