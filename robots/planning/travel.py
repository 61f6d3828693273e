"""Travel costs from the robot to everywhere it can reach, and shortest paths.

Dial's buckets for the costs; A* for the path to one goal.
"""

from __future__ import annotations

from heapq import heappop, heappush

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robots.planning.plan_grid import FREE, PlanGrid

UNREACHED = 2**31 - 1
_LEAVE_M = 0.3  # round the start
_BUCKETS = 32  # more than the dearest single move: 15 * 7 / 5 = 21


def travel_costs(grid: PlanGrid, row: int, column: int) -> NDArray[np.int32]:
    """Return the cost of driving from a cell to every other, int32 (h, w), in fifths of a cell.

    UNREACHED where it cannot. The start need not be passable: a robot that finds itself too close to
    something may leave.
    """
    return np.asarray(_flood(grid.steps, grid.cells, row, column, _leave(grid)))


def find_path(grid: PlanGrid, start: tuple[int, int], goal: tuple[int, int]) -> NDArray[np.int32] | None:
    """Return the cheapest cells from start to goal, (n, 2) of row and column, by A*.

    None where there is no way.
    """
    cells = _a_star(grid.steps, grid.cells, start[0], start[1], goal[0], goal[1], _leave(grid))
    return cells if len(cells) else None


def _leave(grid: PlanGrid) -> int:
    return max(1, int(_LEAVE_M / grid.cell_m + 1e-6))


@njit(cache=True)
def _passable(
    steps: NDArray[np.uint8],
    cells: NDArray[np.uint8],
    r: int,
    c: int,
    start_r: int,
    start_c: int,
    leave: int,
) -> int:
    """Cost of entering a cell, 0 where it cannot be entered.

    Near the start also free cells too close to an obstacle count, dearly, so that the robot can leave. Where
    even the start is not free, the map is wrong about the place the robot stands on, and any cell counts.
    """
    s = int(steps[r, c])
    may_leave = cells[r, c] == FREE or cells[start_r, start_c] != FREE
    if s == 0 and may_leave and abs(r - start_r) <= leave and abs(c - start_c) <= leave:
        return 15
    return s


@njit(cache=True)
def _flood(
    steps: NDArray[np.uint8], cells: NDArray[np.uint8], start_r: int, start_c: int, leave: int
) -> NDArray[np.int32]:
    rows, columns = steps.shape
    cost = np.full((rows, columns), UNREACHED, np.int32)
    if start_r < 0 or start_c < 0 or start_r >= rows or start_c >= columns:
        return cost
    buckets = [np.empty(1024, np.int32) for _ in range(_BUCKETS)]
    sizes = np.zeros(_BUCKETS, np.int64)
    cost[start_r, start_c] = 0
    buckets[0][0] = start_r * columns + start_c
    sizes[0] = 1
    level, pending = 0, 1
    while pending > 0:
        b = level % _BUCKETS
        while sizes[b] > 0:
            sizes[b] -= 1
            pending -= 1
            cell = buckets[b][sizes[b]]
            r, c = cell // columns, cell % columns
            if cost[r, c] != level:
                continue  # reached more cheaply meanwhile
            for dr in range(-1, 2):
                for dc in range(-1, 2):
                    y, x = r + dr, c + dc
                    if (dr == 0 and dc == 0) or y < 0 or x < 0 or y >= rows or x >= columns:
                        continue
                    s = _passable(steps, cells, y, x, start_r, start_c, leave)
                    if s == 0:
                        continue
                    new = level + (s * 7 // 5 if dr != 0 and dc != 0 else s)
                    if new < cost[y, x]:
                        cost[y, x] = new
                        k = new % _BUCKETS
                        if sizes[k] == len(buckets[k]):
                            grown = np.empty(2 * len(buckets[k]), np.int32)
                            grown[: sizes[k]] = buckets[k]
                            buckets[k] = grown
                        buckets[k][sizes[k]] = y * columns + x
                        sizes[k] += 1
                        pending += 1
        level += 1
    return cost


@njit(cache=True)
def _a_star(
    steps: NDArray[np.uint8],
    cells: NDArray[np.uint8],
    start_r: int,
    start_c: int,
    goal_r: int,
    goal_c: int,
    leave: int,
) -> NDArray[np.int32]:
    rows, columns = steps.shape
    none = np.empty((0, 2), np.int32)
    for r, c in ((start_r, start_c), (goal_r, goal_c)):
        if r < 0 or c < 0 or r >= rows or c >= columns:
            return none
    cost = np.full((rows, columns), UNREACHED, np.int32)
    parent = np.full((rows, columns), -1, np.int32)
    heap = [(0, start_r * columns + start_c)]
    cost[start_r, start_c] = 0
    goal = goal_r * columns + goal_c
    while len(heap) > 0:
        estimate, cell = heappop(heap)
        r, c = cell // columns, cell % columns
        if cell == goal:
            break
        far, near = max(abs(r - goal_r), abs(c - goal_c)), min(abs(r - goal_r), abs(c - goal_c))
        if estimate > cost[r, c] + 5 * (far - near) + 7 * near:
            continue  # an older, dearer entry
        for dr in range(-1, 2):
            for dc in range(-1, 2):
                y, x = r + dr, c + dc
                if (dr == 0 and dc == 0) or y < 0 or x < 0 or y >= rows or x >= columns:
                    continue
                s = _passable(steps, cells, y, x, start_r, start_c, leave)
                if s == 0:
                    continue
                new = cost[r, c] + (s * 7 // 5 if dr != 0 and dc != 0 else s)
                if new < cost[y, x]:
                    cost[y, x] = new
                    parent[y, x] = cell
                    far, near = max(abs(y - goal_r), abs(x - goal_c)), min(abs(y - goal_r), abs(x - goal_c))
                    heappush(heap, (new + 5 * (far - near) + 7 * near, y * columns + x))
    if cost[goal_r, goal_c] == UNREACHED:
        return none
    count = 1
    cell = goal
    while parent[cell // columns, cell % columns] >= 0:
        cell = parent[cell // columns, cell % columns]
        count += 1
    path = np.empty((count, 2), np.int32)
    cell = goal
    for k in range(count - 1, -1, -1):
        path[k, 0], path[k, 1] = cell // columns, cell % columns
        cell = parent[cell // columns, cell % columns]
    return path
