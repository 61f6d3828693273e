"""Safe, free and cleared ground, and where one borders on the other (Amigoni 2013, section 3.1).

Free is what the whole reach of the laser showed to be free; safe the part of it that lay within a small range
in sight of a place where a robot was; cleared the part of that which a camera looking ahead has seen.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robots.exploration.frontiers import Frontier
from robots.exploration.strategies.sight import Mask, Sight
from robots.planning.plan_grid import FREE, PlanGrid
from robots.planning.travel import UNREACHED
from robots.se2 import Array

_PIECE_M = 3.0  # a boundary that reaches all round a robot is many places to go to, not one
_LEAST_CELLS = 5  # of a boundary; fewer are noise of the map


@dataclass(frozen=True, slots=True, eq=False)
class ThreeGrids:
    """Ground by how well it is known, bool (h, w) each in the cells of a plan grid."""

    safe: Mask
    free: Mask
    cleared: Mask


@dataclass(frozen=True, slots=True)
class Candidate(Frontier):
    """The middle of the free ground beyond a boundary of the safe; ``area_m2``: how much there is."""

    area_m2: float = 0.0


def three_grids(grid: PlanGrid, trail: Array, safe_m: float, sight: Sight | None = None) -> ThreeGrids:
    """Return what is safe, free and cleared.

    Args:
        grid: the plan grid.
        trail: x, y, heading of where robots were, (k, 3 or more).
        safe_m: the small range.
        sight: what was in sight of the trail when this was last asked; saves looking again.
    """
    safe, cleared = (sight or Sight()).look(grid, trail, safe_m)
    return ThreeGrids(safe, grid.cells == FREE, cleared)


def find_candidates(grid: PlanGrid, costs: NDArray[np.int32], grids: ThreeGrids) -> tuple[Candidate, ...]:
    """Return the places to go to, nearest first; those that cannot be reached are left out.

    Free ground belongs to the piece of boundary from which it is nearest by way of free ground.
    """
    beyond = grids.free & ~grids.safe
    piece = max(1, round(_PIECE_M / grid.cell_m))
    owners, lengths = _share_out(grids.safe, beyond, piece)
    count = len(lengths)
    rows, columns = np.nonzero(owners >= 0)
    owner = owners[rows, columns]
    sizes = np.bincount(owner, minlength=count)
    with np.errstate(invalid="ignore"):
        middles = [np.bincount(owner, weights, count) / sizes for weights in (rows, columns)]
    off = (rows - middles[0][owner]) ** 2 + (columns - middles[1][owner]) ** 2
    off[costs[rows, columns] == UNREACHED] = np.inf
    best = np.lexsort((off, owner))
    first = best[np.unique(owner[best], return_index=True)[1]]
    found = []
    for at in first[np.isfinite(off[first])]:
        k, cell = int(owner[at]), (int(rows[at]), int(columns[at]))
        if lengths[k] >= _LEAST_CELLS:
            found.append(
                Candidate(
                    goal=cell,
                    goal_m=grid.centre_of(*cell),
                    length_m=float(lengths[k]) * grid.cell_m,
                    cost_m=float(costs[cell]) / 5.0 * grid.cell_m,
                    area_m2=float(sizes[k]) * grid.cell_m**2,
                )
            )
    return tuple(sorted(found, key=lambda candidate: (candidate.cost_m, candidate.goal)))


@njit(cache=True)
def _share_out(safe: Mask, beyond: Mask, piece: int) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Number the pieces of boundary beyond the safe cells, and give each cell beyond to the nearest.

    Returns owners (h, w), -1 where there is none, and the cells of each piece of boundary (n,).
    """
    rows, columns = safe.shape
    owners = np.full((rows, columns), -1, np.int32)
    for r in range(1, rows - 1):
        for c in range(1, columns - 1):
            if beyond[r, c] and (safe[r - 1, c] or safe[r + 1, c] or safe[r, c - 1] or safe[r, c + 1]):
                owners[r, c] = -2
    queue = np.empty(rows * columns, np.int32)
    stack = np.empty(rows * columns, np.int32)
    lengths = np.zeros(rows * columns, np.int32)
    count = tail = 0
    for r in range(rows):
        for c in range(columns):
            if owners[r, c] != -2:
                continue
            owners[r, c] = count
            stack[0] = r * columns + c
            size = 1
            while size > 0:
                size -= 1
                y, x = stack[size] // columns, stack[size] % columns
                queue[tail] = stack[size]
                tail += 1
                lengths[count] += 1
                for v in range(max(0, y - 1), min(rows, y + 2)):
                    for u in range(max(0, x - 1), min(columns, x + 2)):
                        if owners[v, u] == -2 and v // piece == r // piece and u // piece == c // piece:
                            owners[v, u] = count
                            stack[size] = v * columns + u
                            size += 1
            count += 1
    head = 0
    while head < tail:
        y, x = queue[head] // columns, queue[head] % columns
        head += 1
        for v, u in ((y - 1, x), (y + 1, x), (y, x - 1), (y, x + 1)):
            if 0 <= v < rows and 0 <= u < columns and beyond[v, u] and owners[v, u] == -1:
                owners[v, u] = owners[y, x]
                queue[tail] = v * columns + u
                tail += 1
    return owners, lengths[:count]
