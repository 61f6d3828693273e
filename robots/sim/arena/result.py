"""What came of a run of the arena."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from robots.exploration.told.survey import LATTICE_M
from robots.sim.arena.ground import Ground
from robots.sim.arena.robot import ArenaRobot
from robots.sim.world import Cells, Mask
from robots.tags.memory import CLOSED

_HOLE_M2 = 1.0  # of ground in one piece that a robot which says "done" must not have left unseen


@dataclass(frozen=True, slots=True, eq=False)
class ArenaResult:
    """One run. ``stamps_s``, ``covered_m2``, ``driven_m`` (k,): time, area the team saw, way of all robots.

    ``score``: area per metre when the team had driven its budgets, or all it drove. ``steps`` of all robots;
    ``times_stuck``: a minute without way; ``false_ends``: robots that were done though ground they could have
    seen was left. ``claimed_share``: of the ground nobody saw, how much the tags claimed when the score was
    taken, None where no robot believed any.
    """

    observable_m2: float
    stamps_s: NDArray[np.float64]
    covered_m2: NDArray[np.float64]
    driven_m: NDArray[np.float64]
    score: float
    steps: int
    times_stuck: int
    false_ends: int
    tags: int
    claimed_share: float | None

    def reached_s(self, share: float) -> float | None:
        """Return when a share of what can be seen had been seen, None where it never was."""
        reached = self.covered_m2 >= share * self.observable_m2 - 1e-9
        return float(self.stamps_s[int(reached.argmax())]) if reached.any() else None

    @property
    def coverage(self) -> float:
        """Share of what can be seen that was seen in the end."""
        return float(self.covered_m2[-1]) / self.observable_m2


def leaves_a_hole(seen: Cells, ground: Ground) -> bool:
    """Say whether ground in one piece that can be seen is left out of ``seen``, (h, w)."""
    labels, count = ndimage.label(ground.observable & (seen == 0))
    if count == 0:
        return False
    largest = int(np.bincount(labels.ravel())[1:].max())
    return largest * ground.world.resolution_m**2 > _HOLE_M2


def claimed_share(robot: ArenaRobot, team_seen: Cells, ground: Ground) -> float | None:
    """Return how much of the ground that nobody saw is claimed by what a robot believes of tags.

    None where all was seen or no tag was read.
    """
    world = ground.world
    rows, columns = np.nonzero(ground.observable & (team_seen == 0))
    if len(rows) == 0 or not robot.places.all():
        return None
    grid = robot.scout.explorer.grids.own.of(robot.map, np.zeros((0, 3)))
    claims = robot.scout.explorer.claims
    survey = claims.survey(grid, claims.tags(robot.places.of))
    x = world.origin_m[0] + (columns + 0.5) * world.resolution_m - robot.start.x - survey.origin[0]
    y = world.origin_m[1] + (rows + 0.5) * world.resolution_m - robot.start.y - survey.origin[1]
    r, c = np.floor(y / LATTICE_M).astype(int), np.floor(x / LATTICE_M).astype(int)
    height, width = survey.claimed.shape
    inside: Mask = (r >= 0) & (c >= 0) & (r < height) & (c < width)
    return float((survey.claimed[r[inside], c[inside]] == CLOSED).sum()) / len(rows)
