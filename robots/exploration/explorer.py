"""Deciding where to go and driving there: the loop of choose, plan, follow, and getting unstuck."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import cos, hypot, sin

import numpy as np
from numpy.typing import NDArray

from robots.config import AgentConfig, ConfigError
from robots.exploration.frontiers import Frontier, find_frontiers
from robots.exploration.strategies import STRATEGIES
from robots.exploration.strategy import Choice, ExplorationView
from robots.mapping.fused import FusedGrid
from robots.planning.following import follow
from robots.planning.plan_grid import FREE, PlanGrid, plan_grid
from robots.planning.travel import find_path, travel_costs
from robots.se2 import Array, Pose2, wrap
from robots.types import Activity, FloatArray32, LaserScan

_SAME_GOAL_M = 1.2  # a frontier this near to the old goal is what the old goal has become
_KEEP_UNLESS = 0.6  # the old goal is kept unless another costs less than this share of it
_BLOCKED_S = 40.0
_ARRIVED_M = 0.3
_LOOK_S = 4.0  # at a goal whose frontier does not vanish: so long it is looked at before it is put aside
_ASIDE_S = 90.0
_ASIDE_M = 0.7
_BLOCKED_RADIUS_M = 0.35
_BACK_OFF_S = 1.4
_DONE_RECHECK_S = 5.0


@dataclass(frozen=True, slots=True, eq=False)
class Decision:
    """Velocities for the body, and what the robot is doing in words.

    ``goal_m`` and ``path_m`` (n, 2) in the map frame.
    """

    linear_mps: float
    angular_radps: float
    activity: Activity
    reason: str
    goal_m: tuple[float, float] | None = None
    path_m: FloatArray32 = field(default_factory=lambda: np.zeros((0, 2), np.float32))


class Explorer:
    """Goal, path and progress of one robot in its map frame."""

    def __init__(self, config: AgentConfig) -> None:
        if config.planning.explore not in STRATEGIES:
            known = ", ".join(sorted(STRATEGIES))
            raise ConfigError(
                f"planning.explore: no strategy is called {config.planning.explore!r}; known are {known}"
            )
        self._config = config
        self._strategy = STRATEGIES[config.planning.explore]()
        self.explored_m2 = 0.0
        self._goal_m: tuple[float, float] | None = None
        self._reason = "waiting for the first scan"
        self._path: Array = np.zeros((0, 2))
        self._planned_s: float | None = None
        self._grid: PlanGrid | None = None
        self._blocked: list[tuple[float, float, float]] = []  # x, y, until: ground that cannot be driven
        self._aside: list[tuple[float, float, float]] = []  # x, y, until: unresolved frontiers
        self._arrived_s: float | None = None
        self._anchor_pose: Pose2 | None = None  # where progress was last seen
        self._anchor_s = 0.0
        self._back_off_until_s: float | None = None
        self._recoveries = 0
        self._done = False

    def replan(self) -> None:
        """Plan anew at the next decision: the map has moved."""
        self._planned_s = None

    def plan_is_due(self, now_s: float) -> bool:
        """Say whether the next decision plans anew and so needs the map as it is now."""
        every_s = _DONE_RECHECK_S if self._done else self._config.planning.replan_every_s
        return self._planned_s is None or now_s - self._planned_s >= every_s

    def decide(
        self, now_s: float, pose: Pose2, fused: FusedGrid, scan: LaserScan | None, bumped: bool, held: bool
    ) -> Decision:
        """Return what to do now, from the pose in the map frame and the fused map."""
        if held:
            self._anchor_pose = None
            return Decision(0.0, 0.0, "holding", "held by an order", self._goal_m)
        recovery = self._recover(now_s, pose, bumped)
        if recovery is not None:
            return recovery
        if self.plan_is_due(now_s) and fused.cells.size:
            self._plan(now_s, pose, fused)
        if self._done:
            return Decision(0.0, 0.0, "done", self._reason)
        if self._grid is None:
            return Decision(0.0, 0.0, "starting", self._reason)
        arrival = self._look_round(now_s, pose)
        if arrival is not None:
            return arrival
        linear, angular = follow(self._path, pose, self._grid, scan, self._config.body)
        return Decision(
            linear, angular, "exploring", self._reason, self._goal_m, self._path.astype(np.float32)
        )

    def _plan(self, now_s: float, pose: Pose2, fused: FusedGrid) -> None:
        config = self._config
        self._planned_s = now_s
        self._blocked = [place for place in self._blocked if place[2] > now_s]
        self._aside = [place for place in self._aside if place[2] > now_s]
        grid = self._grid = self._plan_grid(fused)
        self.explored_m2 = float((grid.cells == FREE).sum()) * grid.cell_m**2
        start = grid.cell_of(pose.x, pose.y)
        frontiers = find_frontiers(grid, travel_costs(grid, *start), config.planning.min_frontier_m)
        frontiers = tuple(f for f in frontiers if not _near(f.goal_m, self._aside, _ASIDE_M))
        choice = self._strategy.choose(ExplorationView(pose, frontiers))
        if choice is None and self._blocked:  # ground that was put aside is tried again before giving up
            self._blocked = []
            self._planned_s = None
            return
        self._done = choice is None
        if choice is None:
            self._goal_m, self._path = None, np.zeros((0, 2))
            self._reason = "no edge of the unknown is left that I can reach"
            return
        choice = self._steady(choice, frontiers)
        cells = find_path(grid, start, choice.frontier.goal)
        if cells is None:
            self._path = np.zeros((0, 2))
            return
        self._goal_m = choice.frontier.goal_m
        self._path = _points(grid, cells)
        self._reason = f"driving {choice.frontier.cost_m:.0f} m to {choice.reason}"

    def _plan_grid(self, fused: FusedGrid) -> PlanGrid:
        blocked = np.array([(x, y, _BLOCKED_RADIUS_M) for x, y, _ in self._blocked]).reshape(-1, 3)
        return plan_grid(fused, self._config.body, self._config.planning, self._config.mapping, blocked)

    def _steady(self, choice: Choice, frontiers: tuple[Frontier, ...]) -> Choice:
        """Keep the goal while its frontier is still there and nothing much cheaper has come up."""
        if self._goal_m is None:
            return choice
        x, y = self._goal_m
        near = [f for f in frontiers if hypot(f.goal_m[0] - x, f.goal_m[1] - y) < _SAME_GOAL_M]
        if not near:
            return choice
        same = min(near, key=lambda f: hypot(f.goal_m[0] - x, f.goal_m[1] - y))
        if choice.frontier.cost_m < _KEEP_UNLESS * same.cost_m:
            return choice
        return Choice(same, f"an edge of the unknown, {same.length_m:.1f} m wide")

    def _look_round(self, now_s: float, pose: Pose2) -> Decision | None:
        """At the goal, turn to see what lies there; a frontier that stays is put aside for a while."""
        goal = self._goal_m
        if goal is None or hypot(goal[0] - pose.x, goal[1] - pose.y) > _ARRIVED_M:
            self._arrived_s = None
            return None
        if self._arrived_s is None:
            self._arrived_s = now_s
        if now_s - self._arrived_s > _LOOK_S:
            self._put_aside(goal, now_s)
            return None
        self._anchor_pose = None
        turn = self._config.body.max_turn_radps
        return Decision(0.0, turn, "exploring", "looking round at the edge of the unknown", goal)

    def _put_aside(self, goal: tuple[float, float], now_s: float) -> None:
        self._aside.append((*goal, now_s + _ASIDE_S))
        self._goal_m, self._arrived_s, self._planned_s = None, None, None
        self._path = np.zeros((0, 2))

    def _recover(self, now_s: float, pose: Pose2, bumped: bool) -> Decision | None:
        """Notice that driving leads nowhere, and get away.

        Back off, turn away, and put the place ahead aside for a while.
        """
        if self._back_off_until_s is not None:
            if now_s < self._back_off_until_s:
                side = 1.0 if self._recoveries % 2 else -1.0
                return Decision(-0.15, 0.6 * side, "stuck", "backing off: something holds me", self._goal_m)
            self._back_off_until_s = None
            self._anchor_pose, self._planned_s = None, None
        if self._anchor_pose is None or self._done:
            self._anchor_pose, self._anchor_s = pose, now_s
            return None
        moved = (
            self._anchor_pose.distance(pose) > 0.15 or abs(wrap(pose.theta - self._anchor_pose.theta)) > 0.5
        )
        if moved:
            self._anchor_pose, self._anchor_s = pose, now_s
            return None if not bumped else self._back_off(now_s, pose)
        if bumped or now_s - self._anchor_s > self._config.planning.stuck_after_s:
            return self._back_off(now_s, pose)
        return None

    def _back_off(self, now_s: float, pose: Pose2) -> Decision:
        goal = self._goal_m
        if goal is not None and hypot(goal[0] - pose.x, goal[1] - pose.y) < 2.0 * _ARRIVED_M:
            self._put_aside(goal, now_s)  # as good as there, and it cannot be had
        ahead = self._config.body.radius_m + 0.25
        place = (pose.x + ahead * cos(pose.theta), pose.y + ahead * sin(pose.theta))
        self._blocked.append((*place, now_s + _BLOCKED_S))
        self._back_off_until_s = now_s + _BACK_OFF_S
        self._recoveries += 1
        return Decision(-0.15, 0.0, "stuck", "backing off: something holds me", self._goal_m)


def _near(point: tuple[float, float], places: list[tuple[float, float, float]], within_m: float) -> bool:
    return any(hypot(point[0] - x, point[1] - y) < within_m for x, y, _ in places)


def _points(grid: PlanGrid, cells: NDArray[np.int32]) -> Array:
    """Return the centres of the cells, (n, 2) metres in the map frame."""
    return np.column_stack(
        [
            grid.origin[0] + (cells[:, 1] + 0.5) * grid.cell_m,
            grid.origin[1] + (cells[:, 0] + 0.5) * grid.cell_m,
        ]
    )
