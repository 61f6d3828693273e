"""How a mission went: what was seen of what can be seen, how far that took, who was found."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from robots.se2 import Array
from robots.sim.rays import look_round
from robots.sim.world import Cells, Mask, World

_LOOK_EVERY_M = 0.25
_FIRST = 6  # so many times farther apart at first
_NOTE_EVERY_S = 1.0
FOUND_WITHIN_M = 1.0


@dataclass(frozen=True, slots=True)
class Score:
    """``coverage`` is explored / observable; ``score_m`` explored area per metre driven by the whole team."""

    explored_m2: float
    observable_m2: float
    coverage: float
    distance_m: float
    score_m: float
    victims_found: int
    victims_total: int


def observable(world: World, radius_m: float, range_max_m: float) -> Mask:
    """Return the free cells a laser can see from anywhere a robot of this radius gets to, bool (h, w)."""
    stride = max(1, round(_LOOK_EVERY_M / world.resolution_m))
    reachable = world.reachable(radius_m)
    seen: Mask = np.zeros_like(reachable)
    for step in (_FIRST * stride, stride):  # most is seen from few places; then only where something is left
        looked_from = np.zeros_like(reachable)
        looked_from[::step, ::step] = reachable[::step, ::step]
        left = ndimage.distance_transform_edt(~(world.free & ~seen)) * world.resolution_m
        rows, columns = np.nonzero(looked_from & (left <= range_max_m + 2.0 * world.resolution_m))
        if len(rows):
            seen |= look_round(world, rows, columns, range_max_m) > 0
    return seen & world.free


class CoverageLog:
    """How much of what can be seen was seen, second by second."""

    def __init__(self, observable_cells: Mask) -> None:
        self.observable = observable_cells
        self._total = max(1, int(observable_cells.sum()))
        self._clocks_s: list[float] = []
        self._shares: list[float] = []

    def note(self, clock_s: float, seen: Cells) -> None:
        """Note the share seen, (h, w), at most once a second."""
        if not self._clocks_s or clock_s >= self._clocks_s[-1] + _NOTE_EVERY_S:
            self._clocks_s.append(clock_s)
            self._shares.append(int(((seen > 0) & self.observable).sum()) / self._total)

    def reached_s(self, share: float) -> float | None:
        """Return when a share was reached first, in seconds; None when it was not."""
        return next(
            (s for s, known in zip(self._clocks_s, self._shares, strict=True) if known >= share), None
        )


def found(estimates_m: Array, victims_m: Array) -> int:
    """Return how many victims, (v, 2), have an estimate, (e, 2), within a metre of them."""
    if len(estimates_m) == 0 or len(victims_m) == 0:
        return 0
    gaps = np.hypot(*(victims_m[:, None] - estimates_m[None]).transpose(2, 0, 1))
    return int((gaps.min(axis=1) <= FOUND_WITHIN_M).sum())


def score(
    world: World, seen: Cells, observable_cells: Mask, distance_m: float, estimates_m: Array, victims_m: Array
) -> Score:
    """Return the score of a team that saw ``seen``, (h, w), and puts victims at ``estimates_m``, (e, 2)."""
    area = world.resolution_m**2
    explored = float(((seen > 0) & observable_cells).sum()) * area
    total = float(observable_cells.sum()) * area
    return Score(
        explored_m2=explored,
        observable_m2=total,
        coverage=explored / total if total > 0.0 else 0.0,
        distance_m=distance_m,
        score_m=explored / distance_m if distance_m > 0.0 else 0.0,
        victims_found=found(estimates_m, victims_m),
        victims_total=len(victims_m),
    )
