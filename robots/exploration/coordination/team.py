"""The team as one of its robots sees it when frontiers are shared out.

Every robot makes the same of the same: what a frontier is worth to each is worked out on one's own map from
the poses that the others told, and robots are taken in the order of their names. Nobody asks anybody.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import hypot
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from robots.exploration.strategy import ExplorationView, Strategy, TakesTheBest, goals_of, ways_of
from robots.planning.travel import UNREACHED, travel_costs
from robots.se2 import Array, Pose2

NEVER = -np.inf  # the worth of what cannot be reached
SAME_GOAL_M = 1.2  # a frontier this near to an old goal is what the goal has become
KEEP_UNLESS = 0.4  # an old goal is kept unless another is worth more by this share of the way to it


@dataclass(frozen=True, slots=True)
class Mate:
    """A robot as it was heard last: pose, and goal (x, y), in one map frame."""

    robot_id: str
    pose: Pose2
    goal_m: tuple[float, float] | None


class Team:
    """Robots in the order of their names, this one among them, and what n frontiers are worth to each.

    ``me`` is this robot's row; ``goals_m`` (x, y) or None, of each, in its map frame; ``reach_m`` how far a
    laser sees; ``seed`` of what is left to chance. ``planned`` counts the ways that had to be planned.
    """

    def __init__(
        self,
        robot_id: str,
        view: ExplorationView,
        strategy: Strategy,
        goal_m: tuple[float, float] | None,
        mates: Sequence[Mate] = (),
        reach_m: float = 4.0,
        seed: int = 0,
    ) -> None:
        everybody = sorted([Mate(robot_id, view.pose, goal_m), *mates], key=lambda mate: mate.robot_id)
        self.ids = tuple(mate.robot_id for mate in everybody)
        self.me = self.ids.index(robot_id)
        self.view = view
        self.frontiers_m = goals_of(view)
        self.goals_m = tuple(mate.goal_m for mate in everybody)
        self.reach_m = reach_m
        self.seed = seed
        self.planned = 0
        self._strategy = strategy
        self._poses: tuple[Pose2, ...] = tuple(mate.pose for mate in everybody)
        self._ways: dict[int, Array] = {self.me: ways_of(view)}
        self._worths: dict[int, Array] = {}

    def __len__(self) -> int:
        return len(self.ids)

    @property
    def floods(self) -> int:
        """From how many of the robots the map was flooded, this one always among them."""
        return len(self._ways)

    @property
    def own(self) -> Array:
        """What the frontiers are worth to this robot, (n,)."""
        return self.worths_of(self.me)

    @property
    def worths(self) -> Array:
        """What the frontiers are worth to everybody by their ways, (m, n); NEVER where there is no way."""
        return np.array([self.worths_of(robot) for robot in range(len(self))])

    @property
    def ways(self) -> Array:
        """What driving to the frontiers costs everybody, (m, n) in metres; inf where there is no way."""
        return np.array([self.ways_of(robot) for robot in range(len(self))])

    def ways_of(self, robot: int) -> Array:
        """Return what driving to the frontiers costs a robot, (n,) in metres; inf where there is no way."""
        if robot not in self._ways:
            self._ways[robot] = self._flood(robot)
        return self._ways[robot]

    def worths_of(self, robot: int) -> Array:
        """Return what the frontiers are worth to a robot by its ways, (n,)."""
        if robot not in self._worths:
            ways = self.ways_of(robot)
            can = np.isfinite(ways)
            worths = self.worths_by(robot, np.where(can, ways, self.straight(robot)))
            self._worths[robot] = np.where(can, worths, NEVER)
        return self._worths[robot]

    def straight(self, robot: int) -> Array:
        """Return the straight distances of a robot to the frontiers, (n,) in metres."""
        pose = self._poses[robot]
        away: Array = np.hypot(self.frontiers_m[:, 0] - pose.x, self.frontiers_m[:, 1] - pose.y)
        return away

    def worths_by(self, robot: int, ways_m: Array) -> Array:
        """Return what the frontiers are worth to a robot if the ways to them were so long, (n,) in metres.

        What it is on its way to already is worth a share of the way more, so that it is not given up lightly,
        unless the strategy is printed otherwise.
        """
        view = self.view if robot == self.me else replace(
            self.view, pose=self._poses[robot], trail=np.zeros((0, 4)), path_m=np.zeros((0, 2))
        )  # fmt: skip
        worths: Array = np.array(self._strategy.worths(view.with_ways(ways_m)), np.float64)
        same = self.heading_for(robot)
        if same is not None and not isinstance(self._strategy, TakesTheBest):
            worths[same] += KEEP_UNLESS * ways_m[same]
        return worths

    def heading_for(self, robot: int) -> int | None:
        """Return the frontier that a robot is on its way to, None where it is none of these."""
        goal = self.goals_m[robot]
        if goal is None or len(self.frontiers_m) == 0:
            return None
        away = np.hypot(*(self.frontiers_m - np.array(goal)).T)
        nearest = int(np.argmin(away))
        return nearest if away[nearest] < SAME_GOAL_M else None

    def _flood(self, robot: int) -> Array:
        view, pose = self.view, self._poses[robot]
        ways = np.full(len(view.frontiers), np.inf)
        if view.grid is None:
            return ways
        costs = travel_costs(view.grid, *view.grid.cell_of(pose.x, pose.y))
        for k, frontier in enumerate(view.frontiers):
            if costs[frontier.goal] != UNREACHED:
                ways[k] = float(costs[frontier.goal]) / 5.0 * view.grid.cell_m
        return ways


class Coordination(Protocol):
    """Chooses this robot's frontier in view of the others.

    ``why``, in words after a comma, it is not the one worth most to this robot.
    """

    why: str

    def choose(self, team: Team) -> int:
        """Return the frontier to go to; there is at least one. Alone it is the one worth most."""
        ...


class Selfish:
    """No coordination: everybody takes what is worth most to it (Amigoni 2013, "no coordination")."""

    why = ""

    def choose(self, team: Team) -> int:
        """Return the frontier worth most."""
        return int(np.argmax(team.own))


def greedy_pairs(worths: Array) -> NDArray[np.int64]:
    """Return a frontier for each robot, (m,), -1 where none is left: again and again the pair worth most.

    Between equals the robot, then the frontier, that comes first.
    """
    left = worths.copy()
    chosen = np.full(len(left), -1)
    while left.size and left.max() > NEVER:
        robot, frontier = np.unravel_index(int(np.argmax(left)), left.shape)
        chosen[robot] = frontier
        left[robot, :] = NEVER
        left[:, frontier] = NEVER
    return chosen


def near(a: tuple[float, float], points_m: Array, within_m: float) -> NDArray[np.bool_]:
    """Return which of the points, (n, 2), lie within so many metres of another."""
    return np.array([hypot(a[0] - x, a[1] - y) < within_m for x, y in points_m], bool)
