"""What one robot leaves in tags: the ground it knows, where it drove, how often it passed and where it went.

Only what it saw itself; what others wrote stays in the tag by merging. Counts and serials grow, so no clock
has to agree with another.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import hypot

import numpy as np
from numpy.typing import NDArray

from robots.exploration.frontiers import edges_of
from robots.planning.plan_grid import PlanGrid
from robots.se2 import Array
from robots.tags.marks import VictimMark, goal_mark, merged_marks, victim_mark
from robots.tags.memory import TagMemory, cell_of, phase_of
from robots.tags.observed import observed_memory, visited_window
from robots.victims import KnownVictim

_ANEW_S = 20.0  # not read for so long: it is passed once more
_OTHER_GOAL_M = 2.0
_MOST = 255
_VICTIMS_WITHIN_M = 20.0  # of a tag: farther off, another tag is nearer
Place = tuple[float, float]


class Witness:
    """Of one robot, in its map frame."""

    def __init__(self, robot_id: str, min_frontier_m: float, cell_m: float = 1.0) -> None:
        self._robot_id = robot_id
        self._min_frontier_m = min_frontier_m
        self._cell_m = cell_m  # of coverage
        self._corner: Place | None = None  # of a cell of the lattice that this robot found, or began
        self._passes: dict[str, tuple[int, int, float, Place]] = {}  # count, serial, last read, goal
        self._edge: tuple[PlanGrid, NDArray[np.bool_]] | None = None  # of the grid last told of

    def phase_at(self, place: Place, said: TagMemory) -> int:
        """Return the lattice on which a tag at a place is told: its own, one found elsewhere, or begun."""
        if said.has_coverage:
            if self._corner is None:
                self._corner, self._cell_m = _corner(place, said.phase), said.cell_m
            return said.phase
        half_m = self._cell_m / 2.0
        self._corner = self._corner or (place[0] - half_m, place[1] - half_m)
        return phase_of(*place, self._corner, self._cell_m)

    def about(
        self,
        tag_id: str,
        place: Place,
        said: TagMemory,
        grid: PlanGrid,
        trail_m: Array,
        goal_m: Place | None,
        now_s: float,
    ) -> TagMemory:
        """Return what to merge into a tag at a place, given what it says already.

        Args:
            tag_id: the tag's.
            place: where it lies in the map frame.
            said: what it holds.
            grid: what the robot knows, in the map frame.
            trail_m: (n, 2) or wider, where it was.
            goal_m: where it drives.
            now_s: by its own clock.
        """
        phase = self.phase_at(place, said)
        count, serial, goal = self._pass(tag_id, goal_m or place, now_s)
        return replace(
            observed_memory(grid, *place, phase, self._min_frontier_m, said.cells, self._edge_of(grid)),
            passes=(goal_mark(self._robot_id, count, serial, goal[0] - place[0], goal[1] - place[1]),),
            visited=visited_window(trail_m, *place),
        )

    def _edge_of(self, grid: PlanGrid) -> NDArray[np.bool_]:
        """Return the cells of the frontiers of a grid, worked out once for all the tags read there."""
        if self._edge is None or self._edge[0] is not grid:
            self._edge = grid, edges_of(grid, self._min_frontier_m)
        return self._edge[1]

    def _pass(self, tag_id: str, goal: Place, now_s: float) -> tuple[int, int, Place]:
        """Count a passage of a tag, or that the goal is another one during it."""
        count, serial, last_s, before = self._passes.get(tag_id, (0, 0, -_ANEW_S, goal))
        if now_s - last_s >= _ANEW_S:
            count, serial = min(count + 1, _MOST), 0
        elif (goal[0] - before[0]) ** 2 + (goal[1] - before[1]) ** 2 > _OTHER_GOAL_M**2:
            serial = min(serial + 1, _MOST)
        else:
            goal = before
        self._passes[tag_id] = count, serial, now_s, goal
        return count, serial, goal


def victims_near(victims: Sequence[KnownVictim], place: Place) -> tuple[VictimMark, ...]:
    """Return what to tell a tag at a place of the victims near it, all in the map frame."""
    offsets = [(victim, victim.place_m[0] - place[0], victim.place_m[1] - place[1]) for victim in victims]
    return merged_marks(
        *(
            victim_mark(victim.victim_id, victim.confidence, victim.last_seen_s, north, west)
            for victim, north, west in offsets
            if hypot(north, west) < _VICTIMS_WITHIN_M
        )
    )


def _corner(place: Place, phase: int) -> Place:
    cell_m = cell_of(phase)
    return place[0] - (phase & 15) / 16.0 * cell_m, place[1] - (phase >> 4 & 15) / 16.0 * cell_m
