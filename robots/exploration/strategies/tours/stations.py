"""A lattice of stations in the ground that a robot can drive, what joins them, and what each has in sight."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, cos, floor, hypot, pi, sin

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robots.planning.plan_grid import UNKNOWN, PlanGrid
from robots.planning.travel import UNREACHED
from robots.se2 import Array, Pose2

EVERY_M = 1.0  # between stations
WALL, SAFE, NEW = 0, 1, 2  # kinds of coarse cells
MOST_NEIGHBOURS = 8
_CROWDED = 0.3  # how much of the dearness of ground near obstacles counts
_OPEN = 5  # the cost of entering a cell in the open
Kinds = NDArray[np.uint8]
Indices = NDArray[np.int32]


@dataclass(frozen=True, slots=True, eq=False)
class Stations:
    """``places`` (n, 2) in the map frame, the last of them where the robot is.

    ``ends`` (n, 8): the stations that a straight way leads to, -1 where there is none, ``ways_m`` (n, 8) what
    it costs. ``first`` (n + 1,) and ``seen``: the new coarse cells, by their flat index, in sight of station
    k are ``seen[first[k]:first[k + 1]]``.
    """

    places: Array
    ends: Indices
    ways_m: Array
    first: NDArray[np.int64]
    seen: Indices


def stations_of(
    grid: PlanGrid, costs: NDArray[np.int32], pose: Pose2, kinds: Kinds, coarse_m: float, reach_m: float
) -> Stations:
    """Return the stations of the ground that can be reached.

    Args:
        grid: the plan grid.
        costs: of driving to its cells from ``pose``, int32 (h, w), UNREACHED where it cannot.
        pose: where the robot is, in the map frame.
        kinds: WALL, SAFE or NEW, (v, u), of coarse cells from the corner of the plan grid on.
        coarse_m: the side of a coarse cell.
        reach_m: the range within which ground is made safe.
    """
    stride = max(1, round(EVERY_M / grid.cell_m))
    rows, columns = (-(-side // stride) for side in grid.cells.shape)
    cells = _place(grid.steps, costs != UNREACHED, stride, rows, columns)
    places = np.full((rows * columns + 1, 2), np.nan)
    there = cells[:, 0] >= 0
    places[:-1][there] = grid.centres_of(cells[there])
    places[-1] = pose.x, pose.y
    ends, ways_m = _join(grid.steps, grid.origin, grid.cell_m, places, rows, columns)
    first, seen = _look(kinds, grid.origin, coarse_m, places, reach_m)
    return Stations(places, ends, ways_m, first, seen)


def without_ghosts(grid: PlanGrid, kinds: Kinds, coarse_m: float, looked_m: Array, reach_m: float) -> Kinds:
    """Return the kinds in which what stayed unknown though it was looked at is as good as safe.

    ``looked_m`` (k, 2): from where. Such cells would be driven to for ever.
    """
    factor, (rows, columns) = round(coarse_m / grid.cell_m), kinds.shape
    blocks = grid.cells[: rows * factor, : columns * factor].reshape(rows, factor, columns, factor)
    _, seen = _look(kinds, grid.origin, coarse_m, np.ascontiguousarray(looked_m), reach_m)
    looked_at = np.zeros(kinds.size, bool)
    looked_at[seen] = True
    ghosts = looked_at.reshape(kinds.shape) & (blocks == UNKNOWN).all(axis=(1, 3))
    return np.where(ghosts, SAFE, kinds).astype(np.uint8)


@njit(cache=True)
def _place(
    steps: NDArray[np.uint8], reached: NDArray[np.bool_], stride: int, rows: int, columns: int
) -> NDArray[np.int64]:
    """Return the cell (row, column) of each station: the most open one near a lattice point, -1 for none."""
    cells = np.full((rows * columns, 2), -1)
    half = stride // 2
    for i in range(rows):
        for j in range(columns):
            least = 2**30
            for r in range(max(0, i * stride), min(steps.shape[0], (i + 1) * stride)):
                for c in range(max(0, j * stride), min(steps.shape[1], (j + 1) * stride)):
                    if steps[r, c] == 0 or not reached[r, c]:
                        continue
                    off = (r - i * stride - half) ** 2 + (c - j * stride - half) ** 2
                    off += 4 * (steps[r, c] - _OPEN)
                    if off < least:
                        least = off
                        cells[i * columns + j] = r, c
    return cells


@njit(cache=True)
def _join(
    steps: NDArray[np.uint8], origin: tuple[float, float], cell: float, places: Array, rows: int, columns: int
) -> tuple[Indices, Array]:
    """Join each station to the eight round it, and the robot's place to those it stands among."""
    ends = np.full((len(places), MOST_NEIGHBOURS), -1, np.int32)
    ways = np.zeros((len(places), MOST_NEIGHBOURS))
    last = len(places) - 1
    away = np.hypot(places[:last, 0] - places[last, 0], places[:last, 1] - places[last, 1])
    away[np.isnan(away)] = np.inf
    near = np.argsort(away, kind="mergesort")[:MOST_NEIGHBOURS] if last > 0 else np.zeros(0, np.int64)
    for k in range(len(near)):
        if away[near[k]] < 3.0 * EVERY_M:
            way = way_between(steps, origin, cell, places[last], places[near[k]])
            if way >= 0.0:
                ends[last, k], ways[last, k] = near[k], way
    for i in range(rows):
        for j in range(columns):
            at, d = i * columns + j, 0
            for v in range(i - 1, i + 2):
                for u in range(j - 1, j + 2):
                    if (v == i and u == j) or v < 0 or u < 0 or v >= rows or u >= columns:
                        continue
                    to = v * columns + u
                    if np.isnan(places[at, 0]) or np.isnan(places[to, 0]):
                        continue
                    way = way_between(steps, origin, cell, places[at], places[to])
                    if way >= 0.0:
                        ends[at, d], ways[at, d] = to, way
                        d += 1
    return ends, ways


@njit(cache=True)
def way_between(
    steps: NDArray[np.uint8], origin: tuple[float, float], cell: float, start: Array, end: Array
) -> float:
    """Return what the straight way between two points costs, in metres of open ground; -1 where it is shut.

    The start itself may be too near to something.
    """
    length = hypot(end[0] - start[0], end[1] - start[1])
    count = max(1, ceil(length / (0.5 * cell)))
    total = 0.0
    for k in range(1, count + 1):
        r = floor((start[1] + (end[1] - start[1]) * k / count - origin[1]) / cell)
        c = floor((start[0] + (end[0] - start[0]) * k / count - origin[0]) / cell)
        if r < 0 or c < 0 or r >= steps.shape[0] or c >= steps.shape[1]:
            return -1.0
        if steps[r, c] == 0 and k > 2:
            return -1.0
        total += max(_OPEN, steps[r, c])
    return length * (1.0 + _CROWDED * (total / count / _OPEN - 1.0))


@njit(cache=True)
def _look(
    kinds: Kinds, origin: tuple[float, float], cell: float, places: Array, reach: float
) -> tuple[NDArray[np.int64], Indices]:
    """Return the new cells in sight of each place, one list after the other, and where each begins."""
    rows, columns = kinds.shape
    marks = np.full((rows, columns), -1, np.int32)
    first = np.zeros(len(places) + 1, np.int64)
    found = np.empty(1024, np.int32)
    count = 0
    rays, steps = ceil(3.0 * pi * reach / cell), int(2.0 * reach / cell)
    for k in range(len(places)):
        for ray in range(0 if np.isnan(places[k, 0]) else rays):
            along, across = cos(2.0 * pi * ray / rays), sin(2.0 * pi * ray / rays)
            for step in range(steps + 1):
                r = floor((places[k, 1] - origin[1]) / cell + 0.5 * step * across)
                c = floor((places[k, 0] - origin[0]) / cell + 0.5 * step * along)
                if r < 0 or c < 0 or r >= rows or c >= columns or kinds[r, c] == WALL:
                    break
                if kinds[r, c] == NEW and marks[r, c] != k:
                    marks[r, c] = k
                    if count == len(found):
                        grown = np.empty(2 * count, np.int32)
                        grown[:count] = found
                        found = grown
                    found[count] = r * columns + c
                    count += 1
        first[k + 1] = count
    return first, found[:count]
