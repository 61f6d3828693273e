"""What lies round a place on the fused map: how far one sees in every direction, doors taken as shut."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, pi, sin

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy import ndimage

from robots.routes.sight import OCCUPIED_FROM
from robots.se2 import Array
from robots.team import TeamGrid

RAYS = 240
ANGLES = 2.0 * pi * np.arange(RAYS) / RAYS
FREE, WALL, UNKNOWN, THING = range(4)  # of a cell, and of what ends a ray (free: nothing within reach)
REACH_M = 12.0
_THING_M = 2.0  # what stands free and is no larger is furniture, a pillar, debris
_CHINK_M = 0.3  # as much unknown on the way is no end of it
_ROUND = np.ones((3, 3))

Kinds = NDArray[np.uint8]


@dataclass(frozen=True, slots=True)
class Plan:
    """A fused map as ``cells`` (h, w): free, wall, unknown, or a thing, past which one looks."""

    cells: Kinds
    origin_m: tuple[float, float]
    resolution_m: float


@dataclass(frozen=True, slots=True)
class Outlook:
    """The isovist (Benedikt 1979) of a place: ``ranges_m`` and ``ends`` (240,) of rays, from x to y."""

    ranges_m: Array
    ends: Kinds

    @property
    def corners_m(self) -> Array:
        """The ends (240, 2) of the rays, from the place."""
        corners: Array = self.ranges_m[:, None] * np.column_stack([np.cos(ANGLES), np.sin(ANGLES)])
        return corners


def plan_of(grid: TeamGrid) -> Plan:
    """Return the cells of a fused map as free, wall, unknown, or of a thing that stands free."""
    occupied = grid.cells >= OCCUPIED_FROM
    walls = _large(occupied, grid.resolution_m)
    unknown = _large((grid.cells < 0) & ~walls, grid.resolution_m)
    cells = np.select([walls, occupied, unknown], [WALL, THING, UNKNOWN], FREE).astype(np.uint8)
    return Plan(cells, grid.origin_m, grid.resolution_m)


def _large(mask: NDArray[np.bool_], resolution_m: float) -> NDArray[np.bool_]:
    """Return a mask without its connected parts that are no larger than a thing that stands free."""
    labels, _ = ndimage.label(mask, _ROUND)
    most = _THING_M / resolution_m + 1e-6
    large = [max(side.stop - side.start for side in box) > most for box in ndimage.find_objects(labels)]
    kept: NDArray[np.bool_] = np.array([False, *large])[labels]
    return kept


def outlook(plan: Plan, place_m: Array, door_m: float = 0.0) -> Outlook:
    """Return what is seen from a place (2,) of the world frame, gaps between walls up to so wide shut."""
    cell = plan.resolution_m
    column, row = (place_m - plan.origin_m) / cell
    ranges, ends = _rays(plan.cells, column, row, round(REACH_M / cell), round(_CHINK_M / cell))
    ranges_m = ranges * cell
    if door_m > 0.0 and ranges.min() > 0.0:
        ranges_m, ends = _shut(ranges_m, ends, door_m)
    return Outlook(ranges_m, ends)


@njit(cache=True)
def _rays(cells: Kinds, column: float, row: float, reach: int, chink: int) -> tuple[Array, Kinds]:
    """Return how far (cells) each ray goes, in steps of half a cell, and what ends it."""
    height, width = cells.shape
    ranges, ends = np.full(RAYS, float(reach)), np.full(RAYS, FREE, np.uint8)
    for k in range(RAYS):
        dx, dy = 0.5 * cos(2.0 * pi * k / RAYS), 0.5 * sin(2.0 * pi * k / RAYS)
        unknown = 0
        for step in range(2 * reach):
            i, j = int(np.floor(row + step * dy)), int(np.floor(column + step * dx))
            kind = cells[i, j] if 0 <= i < height and 0 <= j < width else UNKNOWN
            if kind == WALL:
                ranges[k], ends[k] = 0.5 * step, WALL
                break
            unknown = unknown + 1 if kind == UNKNOWN else 0
            if unknown > 2 * chink:
                ranges[k], ends[k] = 0.5 * (step - unknown + 1), UNKNOWN
                break
    return ranges, ends


@njit(cache=True)
def _shut(open_m: Array, ends: Kinds, door_m: float) -> tuple[Array, Kinds]:
    """Return rays that end in each gap between two walls that is no wider than a door."""
    ranges_m, shut = open_m.copy(), ends.copy()
    half = RAYS // 2
    cosines, sines = np.cos(ANGLES[:half]), np.sin(ANGLES[:half])
    for i in range(RAYS):
        if ends[i] != WALL:
            continue
        for span in range(2, half):
            j = (i + span) % RAYS
            a, b = open_m[i], open_m[j]
            if ends[j] != WALL or a * a + b * b - 2.0 * a * b * cosines[span] > door_m * door_m:
                continue
            for step in range(1, span):
                k = (i + step) % RAYS
                # where the ray meets the line from one end to the other: areas of triangles add up
                across_m = a * b * sines[span] / (a * sines[step] + b * sines[span - step])
                if across_m < ranges_m[k]:
                    ranges_m[k], shut[k] = across_m, WALL
    return ranges_m, shut
