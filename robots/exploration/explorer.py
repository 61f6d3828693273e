"""Deciding where to go and driving there: the loop of choose, plan, follow, and getting unstuck."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from math import hypot

import numpy as np
from numpy.typing import NDArray

from robots.config import AgentConfig, ConfigError
from robots.exploration.claims import Claims, PlaceOf
from robots.exploration.frontiers import Frontier, find_frontiers, find_shut_off
from robots.exploration.recovery import Recovery, place_ahead, spot_aside
from robots.exploration.strategies import STRATEGIES
from robots.exploration.strategy import ExplorationView, OwnCandidates, PlansLocally
from robots.exploration.trail import Trail, is_at_end, rest_of
from robots.mapping.fused import FusedGrid
from robots.planning.following import follow
from robots.planning.gaussian_costs import with_gaussian_costs
from robots.planning.plan_grid import FREE, PlanGrid, PlanGrids
from robots.planning.travel import UNREACHED, find_path, travel_costs
from robots.se2 import Array, Pose2
from robots.types import Activity, FloatArray32, LaserScan

_SAME_GOAL_M = 1.2  # a frontier this near to the old goal is what the old goal has become
_KEEP_UNLESS = 0.4  # the old goal is kept unless another is worth more by this share of the way to it
_BLOCKED_S = 40.0
_ARRIVED_M = 0.3
_LOOK_S = 4.0  # at a goal whose frontier does not vanish: so long it is looked at before it is put aside
_ASIDE_S = 60.0
_ASIDE_M = 0.7
_BLOCKED_RADIUS_M = 0.35
_HOME_M = 1.5  # near enough to where it started: others may stand there too
_GIVE_WAY_S = (5.0, 15.0)
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

    def __init__(self, config: AgentConfig, seed: Sequence[int] = (0,)) -> None:
        if config.planning.explore not in STRATEGIES:
            known = ", ".join(sorted(STRATEGIES))
            raise ConfigError(
                f"planning.explore: no strategy is called {config.planning.explore!r}; known are {known}"
            )
        self._config = config
        self._rng = np.random.default_rng(seed)
        self._strategy = STRATEGIES[config.planning.explore]()
        self.claims = Claims()
        self.grids = PlanGrids(config.body, config.planning, config.mapping)
        self.trail = Trail()
        self.explored_m2 = 0.0
        self._goal_m: tuple[float, float] | None = None
        self._reason = "waiting for the first scan"
        self._path: Array = np.zeros((0, 2))
        self._planned_s: float | None = None
        self._grid: PlanGrid | None = None
        self._blocked: list[tuple[float, float, float]] = []  # x, y, until: ground that cannot be driven
        self._aside: list[tuple[float, float, float]] = []  # x, y, until: unresolved frontiers
        self._arrived_s: float | None = None
        self._recovery = Recovery(config.planning.stuck_after_s)
        self._give_way_at: tuple[float, float] | None = None  # where somebody else seems to want to pass
        self._giving_way_until_s: float | None = None
        self._returning = False
        self._done = False

    @property
    def local_map_m(self) -> float:
        """The side of the square round the robot that it plans on; 0 where it plans on the whole map."""
        own = self._strategy.local_map_m if isinstance(self._strategy, PlansLocally) else 0.0
        return self._config.planning.local_map_m or own

    def replan(self) -> None:
        """Plan anew at the next decision: the map has moved."""
        self._planned_s = None

    def plan_is_due(self, now_s: float) -> bool:
        """Say whether the next decision plans anew and so needs the map as it is now."""
        every_s = _DONE_RECHECK_S if self._done else self._config.planning.replan_every_s
        return self._planned_s is None or now_s - self._planned_s >= every_s

    def decide(
        self,
        now_s: float,
        pose: Pose2,
        fused: FusedGrid,
        scan: LaserScan | None,
        bumped: bool,
        held: bool,
        place_of: PlaceOf = lambda tag_id: None,
        battery: float | None = None,
    ) -> Decision:
        """Return what to do now, from the pose in the map frame, the fused map and where tags are."""
        self.trail.note(now_s, pose)
        if held:
            self._recovery.rest()
            return Decision(0.0, 0.0, "holding", "held by an order", self._goal_m)
        recovery = self._recover(now_s, pose, bumped)
        if recovery is not None:
            return recovery
        if self.plan_is_due(now_s) and fused.cells.size:
            self._plan(now_s, pose, fused, place_of, 1.0 if battery is None else battery)
        if self._done:
            return Decision(0.0, 0.0, "done", self._reason)
        if self._grid is None:
            return Decision(0.0, 0.0, "starting", self._reason)
        if self._giving_way_until_s is not None and is_at_end(self._path, pose):
            self._recovery.rest()
            return Decision(0.0, 0.0, "exploring", self._reason)
        arrival = self._look_round(now_s, pose)
        if arrival is not None:
            return arrival
        linear, angular = follow(self._path, pose, self._grid, scan, self._config.body)
        activity: Activity = "returning" if self._returning else "exploring"
        return Decision(linear, angular, activity, self._reason, self._goal_m, self._path.astype(np.float32))

    def _plan(self, now_s: float, pose: Pose2, fused: FusedGrid, place_of: PlaceOf, battery: float) -> None:
        config = self._config
        self._planned_s = now_s
        self._blocked = [place for place in self._blocked if place[2] > now_s]
        self._aside = [place for place in self._aside if place[2] > now_s]
        if self._giving_way_until_s is not None:
            if now_s < self._giving_way_until_s:
                return
            self._giving_way_until_s = None
        grid = self._grid = self._plan_grid(fused)
        self.explored_m2 = float((grid.cells == FREE).sum()) * grid.cell_m**2
        start = grid.cell_of(pose.x, pose.y)
        costs = travel_costs(grid, *start)
        if self._give_way_at is not None and self._give_way(now_s, pose, grid, costs):
            return
        frontiers = self._worth_going(find_frontiers(grid, costs, config.planning.min_frontier_m))
        view = ExplorationView(
            pose=pose,
            frontiers=frontiers,
            survey=self.claims.survey(grid, place_of),
            now_s=now_s,
            grid=grid,
            costs=costs,
            trail=self.trail.points,
            path_m=rest_of(self._path, pose),
            tags=self.claims.tags(place_of),
            battery=battery,
            settings=config.planning,
        )
        goal = self._choose(self._with_candidates(view))
        if goal is None and self._blocked:  # ground that was put aside is tried again before giving up
            self._blocked = []
            self._planned_s = None
            return
        if goal is None:
            shut_off = self._worth_going(find_shut_off(grid, costs, config.planning.min_frontier_m))
            if shut_off:
                goal = shut_off[0], "look whether the way beyond is open by now"
        self._returning = goal is None
        if goal is None:
            self._go_home(pose, grid, costs)
            return
        self._done = False
        frontier, why = goal
        cells = find_path(grid, start, frontier.goal)
        if cells is None:
            self._path = np.zeros((0, 2))
            return
        self._goal_m = frontier.goal_m
        self._path = grid.centres_of(cells)
        self._reason = f"driving {frontier.cost_m:.0f} m to {why}"

    def _go_home(self, pose: Pose2, grid: PlanGrid, costs: NDArray[np.int32]) -> None:
        """Nothing is left to explore: return to where the map began, out of the others' way."""
        self._goal_m = None
        self._reason = "no edge of the unknown is left that I can reach"
        home = grid.cell_of(0.0, 0.0)
        if hypot(pose.x, pose.y) > _HOME_M and grid.holds(*home) and costs[home] != UNREACHED:
            cells = find_path(grid, grid.cell_of(pose.x, pose.y), home)
            if cells is not None:
                self._path, self._done = grid.centres_of(cells), False
                return
        self._path, self._done = np.zeros((0, 2)), True

    def _with_candidates(self, view: ExplorationView) -> ExplorationView:
        """Return the view with the strategy's own candidates, where it has any."""
        if not isinstance(self._strategy, OwnCandidates):
            return view
        own = self._worth_going(self._strategy.candidates(view))
        return replace(view, frontiers=own) if own else replace(view, frontiers=view.frontiers[:1])

    def _worth_going(self, frontiers: tuple[Frontier, ...]) -> tuple[Frontier, ...]:
        return tuple(f for f in frontiers if not _near(f.goal_m, self._aside, _ASIDE_M))

    def _plan_grid(self, fused: FusedGrid) -> PlanGrid:
        blocked = np.array([(x, y, _BLOCKED_RADIUS_M) for x, y, _ in self._blocked]).reshape(-1, 3)
        grid = self.grids.of(fused, blocked)
        local = isinstance(self._strategy, PlansLocally)
        return with_gaussian_costs(grid, self._config.planning.ziparo) if local else grid

    def _choose(self, view: ExplorationView) -> tuple[Frontier, str] | None:
        """Return the frontier that is worth most and why, None where there is none.

        The old goal is kept while its frontier is still there and nothing much better has come up.
        """
        if not view.frontiers:
            return None
        worths = self._strategy.worths(view)
        best = int(np.argmax(worths))
        if self._goal_m is not None:
            x, y = self._goal_m
            far = [hypot(f.goal_m[0] - x, f.goal_m[1] - y) for f in view.frontiers]
            same = int(np.argmin(far))
            gained = worths[best] - worths[same]
            if far[same] < _SAME_GOAL_M and gained <= _KEEP_UNLESS * view.frontiers[same].cost_m:
                best = same
        return view.frontiers[best], self._strategy.reason(view, best)

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
        self._recovery.rest()
        turn = self._config.body.max_turn_radps
        return Decision(0.0, turn, "exploring", "looking round at the edge of the unknown", goal)

    def _put_aside(self, goal: tuple[float, float], now_s: float) -> None:
        self._aside.append((*goal, now_s + _ASIDE_S))
        self._goal_m, self._arrived_s, self._planned_s = None, None, None
        self._path = np.zeros((0, 2))

    def _recover(self, now_s: float, pose: Pose2, bumped: bool) -> Decision | None:
        """Back off when driving leads nowhere, and put the place ahead aside for a while."""
        if self._done or self._grid is None:
            self._recovery.rest()
            return None
        backing = self._recovery.active
        if not backing and self._recovery.begins(now_s, pose, bumped):
            self._note_obstruction(now_s, pose)
        velocities = self._recovery.velocities(now_s)
        if velocities is not None:
            return Decision(*velocities, "stuck", "backing off: something holds me", self._goal_m)
        if backing:
            self._planned_s = None
        return None

    def _note_obstruction(self, now_s: float, pose: Pose2) -> None:
        goal = self._goal_m
        if goal is not None and hypot(goal[0] - pose.x, goal[1] - pose.y) < 2.0 * _ARRIVED_M:
            self._put_aside(goal, now_s)  # as good as there, and it cannot be had
        place = place_ahead(pose, self._config.body.radius_m + 0.25)
        self._blocked.append((*place, now_s + _BLOCKED_S))
        if self._recovery.keeps_failing:
            self._give_way_at = place

    def _give_way(self, now_s: float, pose: Pose2, grid: PlanGrid, costs: NDArray[np.int32]) -> bool:
        """Plan to a free place aside and wait there a while; say whether there is one.

        Two robots that meet in a door block each other for ever if both only back off and come again.
        """
        place, self._give_way_at = self._give_way_at, None
        self._recovery.forget()
        if place is None:
            return False
        spot = spot_aside(grid, costs, place, self._rng)
        if spot is None:
            return False
        cells = find_path(grid, grid.cell_of(pose.x, pose.y), spot)
        if cells is None:
            return False
        self._path = grid.centres_of(cells)
        self._goal_m = None
        self._giving_way_until_s = now_s + float(self._rng.uniform(*_GIVE_WAY_S))
        self._reason = "giving way: somebody may want to pass here"
        return True


def _near(point: tuple[float, float], places: list[tuple[float, float, float]], within_m: float) -> bool:
    return any(hypot(point[0] - x, point[1] - y) < within_m for x, y, _ in places)
