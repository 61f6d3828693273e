"""Kleiner 2006 section V to the letter: eq. (6) to (8), Algorithms 1 and 2, slips included.

Not changed: eq. (7) rewards nearness to visited places and is not scaled by how many there are; a robot takes
frontiers off a tag that it has never seen itself (isFrontierCell asks its own map); Algorithm 2 writes
l_r - f and reads l_r + f, which mirrors a frontier through the tag. Only where the print divides by zero, the
age of a location that was added just now, one second is taken; and a location that comes from a tag is as old
as its reading, because a tag says nothing else.
Cells on tags are those of its memory: frontiers on the lattice of its coverage, visited places of 0.4 m; what
robots of other strategies call covered and closed is left as it is. V_r keeps the latest visits alone once
there are more than anybody would wait for.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from robots.exploration.strategies.kleiner import is_foreign
from robots.exploration.strategy import ExplorationView, goals_of, ways_of
from robots.planning.plan_grid import FREE, UNKNOWN, PlanGrid
from robots.se2 import Array
from robots.tags.memory import (
    CLOSED,
    OPEN,
    REACH,
    UNSEEN,
    VISITED_M,
    VISITED_REACH,
    TagMemory,
    cell_of,
    centred_phase,
    shift_of,
)
from robots.tags.window import joined

_LEAST_AGE_S = 1.0
_MOST_VISITS = 20_000
_CYCLE_M = 0.5  # between poses of the planned trajectory: as far as a robot drives from one plan to the next


class KleinerPrinted:
    """Weighs frontiers by eq. (6) to (8) and answers tags by Algorithms 1 and 2."""

    takes_the_best = True

    def __init__(self) -> None:
        self._visited: Array = np.zeros((0, 3))  # V_r: x, y, stamp, from each cycle and each tag
        self._foreign: Array = np.zeros((0, 2))  # F_o
        self._cycle_s: float | None = None

    def worths(self, view: ExplorationView) -> Array:
        """Return the value of eq. (6), (n,), in metres of way."""
        self._note(view)
        told = view.settings.kleiner
        k = is_foreign(view, self._foreign)  # (8)
        utility = k - told.printed_beta * pull(goals_of(view), self._visited, view.now_s)  # (7)
        worths: Array = utility / told.alpha - ways_of(view)  # (6)
        return worths

    def reason(self, view: ExplorationView, index: int) -> str:
        """Return whose frontier it is."""
        foreign = is_foreign(view, self._foreign)[index]
        return f"a frontier of {'another' if foreign else 'this'} robot, by Kleiner's printed utility"

    def answer(self, memory: TagMemory, view: ExplorationView, tag_m: tuple[float, float]) -> TagMemory:
        """Synchronise with a tag at a place in the map frame; return what its windows hold then."""
        if view.grid is None:
            return memory
        phase = memory.phase if memory.has_coverage else centred_phase(view.settings.tag_cell_m)
        place, tau_m, cell_m = np.array(tag_m), view.settings.kleiner.tau_m, cell_of(phase)
        visits = np.concatenate([view.trail[:, :2], self._visited[:, :2]])
        added, v_tag = synchronise_visited(visits, memory.visited_m, place, tau_m)
        stamps = np.full((len(added), 1), view.now_s)
        self._note_visits(np.hstack([added, stamps]))
        edges = frontier_cells(view.grid)
        found, f_tag = synchronise_frontiers(
            edges, memory.frontiers_m, place, tau_m, lambda at: near_any(at, edges, cell_m / 2.0)
        )
        self._foreign = np.unique(np.concatenate([self._foreign, found]), axis=0)
        return TagMemory(
            joined(
                _window(f_tag - np.array(shift_of(phase)), cell_m, REACH) * np.uint8(OPEN),
                np.where(memory.cells == CLOSED, CLOSED, UNSEEN).astype(np.uint8),
            ),
            visited=_window(v_tag, VISITED_M, VISITED_REACH),
            phase=phase,
        )

    def _note(self, view: ExplorationView) -> None:
        """Add the current pose and those planned, once each cycle."""
        if self._cycle_s == view.now_s:
            return
        self._cycle_s = view.now_s
        way = view.path_m
        along = np.concatenate([[0.0], np.hypot(*np.diff(way, axis=0).T).cumsum()]) if len(way) else way[:, 0]
        marks = np.arange(_CYCLE_M, along[-1] if len(along) else 0.0, _CYCLE_M)
        planned = (
            np.column_stack([np.interp(marks, along, way[:, k]) for k in (0, 1)]) if len(marks) else way[:0]
        )
        here = np.array([[view.pose.x, view.pose.y]])
        stamps = view.now_s + np.arange(len(planned) + 1.0)
        self._note_visits(np.column_stack([np.concatenate([here, planned]), stamps]))

    def _note_visits(self, visits: Array) -> None:
        self._visited = np.concatenate([self._visited, visits])[-_MOST_VISITS:]


def pull(places: Array, visits: Array, now_s: float) -> Array:
    """Return the sum of eq. (7), |f - l_t| / age(l_t), (n,), of places (n, 2) over visits (m, 3)."""
    apart = np.hypot(*(places[:, None] - visits[None, :, :2]).transpose(2, 0, 1))
    total: Array = (apart / np.maximum(now_s - visits[:, 2], _LEAST_AGE_S)).sum(axis=1)
    return total


def synchronise_visited(v_robot: Array, v_tag: Array, tag_m: Array, tau_m: float) -> tuple[Array, Array]:
    """Algorithm 1. Return what the robot adds to V_r, (m, 2), and the new V_tag, (k, 2), relative to the tag.

    ``v_robot`` (n, 2) in the map frame; ``v_tag`` (m, 2) relative to the tag at ``tag_m``.
    """
    added = v_tag + tag_m
    v_robot = np.concatenate([v_robot, added])
    near = v_robot[np.hypot(*(v_robot - tag_m).T) < tau_m]
    return added, np.concatenate([v_tag, near - tag_m])


def synchronise_frontiers(
    f_robot: Array,
    f_tag: Array,
    tag_m: Array,
    tau_m: float,
    is_frontier_cell: Callable[[Array], NDArray[np.bool_]],
) -> tuple[Array, Array]:
    """Algorithm 2. Return F_o, (m, 2) in the map frame, and the new F_tag, (k, 2), relative to the tag.

    ``f_robot`` (n, 2) in the map frame; ``is_frontier_cell`` tells it of places (n, 2) by the robot's map.
    """
    kept = is_frontier_cell(f_tag + tag_m)
    near = f_robot[np.hypot(*(f_robot - tag_m).T) < tau_m]
    return f_tag[kept] + tag_m, np.concatenate([f_tag[kept], tag_m - near])  # as printed: l_r - f_j


def frontier_cells(grid: PlanGrid) -> Array:
    """Return F_r: the centres of all cells that are free and neighbour an unknown one, (n, 2)."""
    unknown, edge = grid.cells == UNKNOWN, np.zeros(grid.cells.shape, bool)
    edge[1:-1, 1:-1] = (grid.cells == FREE)[1:-1, 1:-1] & (
        unknown[:-2, 1:-1] | unknown[2:, 1:-1] | unknown[1:-1, :-2] | unknown[1:-1, 2:]
    )
    return grid.centres_of(np.argwhere(edge))


def near_any(places: Array, others: Array, within_m: float) -> NDArray[np.bool_]:
    """Say of places (n, 2) whether any of the others (m, 2) is no farther along either axis."""
    if len(places) == 0 or len(others) == 0:
        return np.zeros(len(places), bool)
    near: NDArray[np.bool_] = (np.abs(places[:, None] - others[None]).max(axis=2) <= within_m).any(axis=1)
    return near


def _window(shifts_m: Array, cell_m: float, reach: int) -> NDArray[np.uint8]:
    """Return the cells round a tag, uint8 (2 reach + 1, same), that hold one of the shifts (n, 2)."""
    cells = np.zeros((2 * reach + 1, 2 * reach + 1), np.uint8)
    at = np.rint(shifts_m / cell_m).astype(np.int64) + reach
    at = at[((at >= 0) & (at < len(cells))).all(axis=1)]
    cells[at[:, 0], at[:, 1]] = 1
    return cells
