"""Frontiers (Yamauchi 1997): where the space a robot can reach borders on what nobody of its map has seen."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robots.planning.plan_grid import FREE, OCCUPIED, UNKNOWN, PlanGrid
from robots.planning.travel import UNREACHED


@dataclass(frozen=True, slots=True)
class Frontier:
    """A connected border to the unknown: where to drive to see it, its length and the cost of going there.

    ``goal`` (row, column) in the plan grid is the cell of it that is cheapest to reach; ``goal_m`` (x, y) in
    the map frame; ``length_m`` and ``cost_m`` in metres.
    """

    goal: tuple[int, int]
    goal_m: tuple[float, float]
    length_m: float
    cost_m: float


@dataclass(frozen=True, slots=True)
class Leg(Frontier):
    """A way planned as one through many stations, ``way_m`` (x, y) each, to the goal at its end.

    ``area_m2``: the ground that driving it makes safe; ``begun``: the robot is on it already.
    """

    way_m: tuple[tuple[float, float], ...] = ()
    area_m2: float = 0.0
    begun: bool = False


def find_frontiers(grid: PlanGrid, costs: NDArray[np.int32], min_length_m: float) -> tuple[Frontier, ...]:
    """Return the frontiers of at least ``min_length_m`` that can be reached, nearest first.

    A frontier's cells are free and touch unknown cells; where the body does not fit right up to them, the
    goal is the nearest cell within ``_APPROACH`` cells that it can reach and see them from.
    """
    labels, count = _label(grid.cells)
    if count == 0:
        return ()
    sizes, best_cost, best_row, best_column = _nearest_access(grid.cells, labels, count, costs)
    frontiers = []
    for k in range(count):
        length = float(sizes[k]) * grid.cell_m
        if length < min_length_m or best_cost[k] == UNREACHED:
            continue
        goal = (int(best_row[k]), int(best_column[k]))
        cost_m = float(best_cost[k]) / 5.0 * grid.cell_m
        frontiers.append(Frontier(goal, grid.centre_of(*goal), length, cost_m))
    frontiers.sort(key=lambda frontier: (frontier.cost_m, frontier.goal))
    return tuple(frontiers)


def find_shut_off(
    grid: PlanGrid, costs: NDArray[np.int32], min_length_m: float
) -> tuple[tuple[tuple[int, int], float], ...]:
    """Return the middle cell (row, column) and the length (m) of each frontier that cannot be reached."""
    labels, count = _label(grid.cells)
    if count == 0:
        return ()
    sizes, best_cost, _, _ = _nearest_access(grid.cells, labels, count, costs)
    shut_off = []
    for k in np.flatnonzero((best_cost == UNREACHED) & (sizes * grid.cell_m >= min_length_m)):
        cells = np.argwhere(labels == k)
        row, column = cells[((cells - cells.mean(axis=0)) ** 2).sum(axis=1).argmin()]
        shut_off.append(((int(row), int(column)), float(sizes[k]) * grid.cell_m))
    return tuple(shut_off)


def edges_of(grid: PlanGrid, min_length_m: float) -> NDArray[np.bool_]:
    """Return the cells of all frontiers of at least this length, reachable or not, (h, w)."""
    labels, count = _label(grid.cells)
    sizes = np.bincount(labels[labels >= 0], minlength=count)
    found: NDArray[np.bool_] = np.append(sizes * grid.cell_m >= min_length_m, False)[labels]
    return found


_APPROACH = 5


@njit(cache=True)
def _label(cells: NDArray[np.uint8]) -> tuple[NDArray[np.int32], int]:
    """Number the 8-connected groups of free cells that touch unknown ones; -1 elsewhere."""
    rows, columns = cells.shape
    labels = np.full((rows, columns), -1, np.int32)
    for r in range(1, rows - 1):
        for c in range(1, columns - 1):
            if cells[r, c] == FREE and (
                cells[r - 1, c] == UNKNOWN or cells[r + 1, c] == UNKNOWN
                or cells[r, c - 1] == UNKNOWN or cells[r, c + 1] == UNKNOWN
            ):  # fmt: skip
                labels[r, c] = -2
    stack = np.empty(rows * columns, np.int32)
    count = 0
    for r in range(rows):
        for c in range(columns):
            if labels[r, c] != -2:
                continue
            labels[r, c] = count
            stack[0] = r * columns + c
            size = 1
            while size > 0:
                size -= 1
                y, x = stack[size] // columns, stack[size] % columns
                for v in range(max(0, y - 1), min(rows, y + 2)):
                    for u in range(max(0, x - 1), min(columns, x + 2)):
                        if labels[v, u] == -2:
                            labels[v, u] = count
                            stack[size] = v * columns + u
                            size += 1
            count += 1
    return labels, count


@njit(cache=True)
def _nearest_access(
    cells: NDArray[np.uint8], labels: NDArray[np.int32], count: int, costs: NDArray[np.int32]
) -> tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.int32], NDArray[np.int32]]:
    rows, columns = labels.shape
    sizes = np.zeros(count, np.int32)
    best = np.full(count, UNREACHED, np.int32)
    best_row = np.zeros(count, np.int32)
    best_column = np.zeros(count, np.int32)
    for r in range(rows):
        for c in range(columns):
            k = labels[r, c]
            if k < 0:
                continue
            sizes[k] += 1
            for reach in range(_APPROACH + 1):  # the cell itself, else the nearest ring with one to look from
                found = False
                for y in range(max(0, r - reach), min(rows, r + reach + 1)):
                    for x in range(max(0, c - reach), min(columns, c + reach + 1)):
                        if max(abs(y - r), abs(x - c)) != reach or costs[y, x] == UNREACHED:
                            continue
                        if not _is_open_between(cells, r, c, y, x):
                            continue
                        found = True
                        if costs[y, x] < best[k]:
                            best[k], best_row[k], best_column[k] = costs[y, x], y, x
                if found:
                    break
    return sizes, best, best_row, best_column


@njit(cache=True)
def _is_open_between(cells: NDArray[np.uint8], r: int, c: int, y: int, x: int) -> bool:
    """Whether no obstacle lies on the straight line between two cells: through a wall nothing is seen."""
    count = max(abs(y - r), abs(x - c))
    for k in range(1, count):
        if cells[r + round(k * (y - r) / count), c + round(k * (x - c) / count)] == OCCUPIED:
            return False
    return True
