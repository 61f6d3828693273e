"""When to drop a tag (Kleiner 2006 section III).

"The dropping of a tag occurs with higher probability if the tag density is low and the obstacle density on
the left and right hand side of the robot is high": doors and corridors, where someone will pass again.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import cos, exp, floor, hypot, sin
from typing import Literal

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robots.config import DeploymentConfig, MappingConfig
from robots.mapping.fused import FusedGrid
from robots.se2 import Array, Pose2

_OPEN_SHARE = 0.12  # of the full rate, in the open
_FALLS_S = 3.0  # a tag that the magazine still counts so long after it was to fall is stuck
_STUCK_M, _MOST_TRIES = 5.0, 4  # way until it is tried again, twice as far each time


def tag_density(x: float, y: float, tags: Iterable[tuple[float, float]], spacing_m: float) -> float:
    """Return the density of tags round a point, 1 at a tag, falling to 0.14 at the wanted spacing."""
    return sum(exp(-2.0 * ((x - tx) ** 2 + (y - ty) ** 2) / spacing_m**2) for tx, ty in tags)


def side_density(pose: Pose2, fused: FusedGrid, window_m: float, occupied: int) -> float:
    """Return the obstacle density left and right of the robot, 0..1.

    The product of the shares of blocked side rays.
    """
    ahead = np.linspace(-0.2, 0.2, 5)
    across = np.arange(0.2, window_m, fused.resolution_m / 2.0)  # half cells: no wall slips between two
    left, right = (
        _blocked(
            fused.cells, fused.origin, fused.resolution_m, pose.x, pose.y, pose.theta, ahead, side * across,
            occupied,
        )
        for side in (1.0, -1.0)
    )  # fmt: skip
    return float(left / len(ahead) * (right / len(ahead)))


@njit(cache=True)
def _blocked(
    cells: NDArray[np.int32],
    origin: tuple[float, float],
    resolution: float,
    x: float,
    y: float,
    theta: float,
    ahead: Array,
    across: Array,
    occupied: int,
) -> int:
    """Return how many of the rays to one side meet an obstacle."""
    rows, columns = cells.shape
    c, s = cos(theta), sin(theta)
    count = 0
    for a in ahead:
        for b in across:
            row = floor((y + a * s + b * c - origin[1]) / resolution)
            column = floor((x + a * c - b * s - origin[0]) / resolution)
            if 0 <= row < rows and 0 <= column < columns and cells[row, column] >= occupied:
                count += 1
                break
    return count


class TagDropper:
    """Decides, by a seeded draw for every bit of way, whether to drop a tag; counts the magazine."""

    def __init__(self, config: DeploymentConfig, mapping: MappingConfig, seed: int | Sequence[int]) -> None:
        self._config = config
        self._mapping = mapping
        self._rng = np.random.default_rng(seed)
        self._distance_m = 0.0
        self._waiting_until_m = 0.0
        self._falling: tuple[int, float | None, float] | None = None  # left before, since when, way driven
        self._times_stuck = 0
        self.left = config.magazine

    def should_drop(
        self,
        distance_m: float,
        pose: Pose2,
        fused: FusedGrid,
        tags: Iterable[tuple[float, float]],
        even_m: float = 0.0,
    ) -> bool:
        """Say whether to drop a tag here; ``distance_m`` is the way driven so far.

        ``even_m``: drop one wherever none lies within so far, unless the settings say how far.
        """
        moved = distance_m - self._distance_m
        if moved < 0.1 or self.left <= 0 or self._falling is not None or not fused.cells.size:
            return False
        self._distance_m = distance_m
        if distance_m < self._waiting_until_m:
            return False
        config = self._config
        even_m = config.even_m or even_m
        if even_m > 0.0:
            near = any(hypot(pose.x - x, pose.y - y) < even_m for x, y in tags)
            return not near and self.drop_here(distance_m)
        wanted = max(0.0, 1.0 - 2.0 * tag_density(pose.x, pose.y, tags, config.spacing_m))
        sides = side_density(pose, fused, config.side_window_m, self._mapping.occupied_logodds)
        rate = config.rate_per_m * wanted * (_OPEN_SHARE + (1.0 - _OPEN_SHARE) * sides)
        if self._rng.random() >= 1.0 - exp(-rate * moved):
            return False
        return self.drop_here(distance_m)

    def drop_here(self, distance_m: float) -> bool:
        """Take a tag out of the magazine, whatever lies here; say whether there was one."""
        if self.left <= 0 or self._falling is not None:
            return False
        self._falling = self.left, None, distance_m
        self.left -= 1
        self._waiting_until_m = distance_m + 0.5  # until the dropped tag has been read
        return True

    def magazine(self, tags_left: int | None, now_s: float) -> Literal["fell", "stuck"] | None:
        """Take over the magazine's own count; return what became of the tag that was to fall, once known.

        Where nobody counts it is taken to have fallen. One that is stuck is tried again some way on.
        """
        if tags_left is not None:
            self.left = max(0, tags_left)
        if self._falling is None:
            return None
        before, since_s, driven_m = self._falling
        if tags_left is None or tags_left < before:
            self._falling, self._times_stuck = None, 0
            return "fell"
        self._falling = before, now_s if since_s is None else since_s, driven_m
        if since_s is None or now_s - since_s < _FALLS_S:
            return None
        self._waiting_until_m = driven_m + _STUCK_M * 2.0 ** min(self._times_stuck, _MOST_TRIES)
        self._falling, self._times_stuck = None, self._times_stuck + 1
        return "stuck"
