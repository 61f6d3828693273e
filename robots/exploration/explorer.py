"""Deciding where to go and driving there: the loop of choose, plan, follow, and getting unstuck."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import hypot

import numpy as np

from robots.config import AgentConfig
from robots.exploration.aim import Aim, Decision
from robots.exploration.frontiers import Frontier
from robots.exploration.goals import Choice, Goals
from robots.exploration.ground import Ground
from robots.exploration.last_looks import BEHIND_GLASS, gaps, unproved
from robots.exploration.manners.errands import Errands
from robots.exploration.manners.giving_way import GivingWay
from robots.exploration.manners.homing import Homing
from robots.exploration.manners.recovery import Blocked, Recovery, place_ahead
from robots.exploration.manners.shut_ways import SHUT, shut_off
from robots.exploration.manners.suspects import Suspects
from robots.exploration.strategy import ExplorationView, PlansLocally
from robots.exploration.team.communication import Communication
from robots.exploration.team.shared_grids import SharedGrids
from robots.exploration.told.claims import Claims, LateSurvey, PlaceOf
from robots.exploration.trail import Trail, is_at_end, rest_of
from robots.mapping.fused import FusedGrid
from robots.orders import Methods, OrderReport, RobotOrder
from robots.planning.following import follow
from robots.planning.gaussian_costs import with_gaussian_costs
from robots.planning.plan_grid import PlanGrid
from robots.se2 import Pose2
from robots.types import FrontierReport, LaserScan, Suspect

_ARRIVED_M = 0.3
_LOOK_S = 4.0  # at a goal whose frontier does not vanish: so long it is looked at before it is put aside
_REST_RECHECK_S = 5.0


class Explorer:
    """Goal, path and progress of one robot in its map frame.

    Raises:
        ConfigError: a setting of ``config`` names something that does not exist.
    """

    def __init__(
        self, config: AgentConfig, seed: Sequence[int] = (0,), communication: Communication | None = None
    ) -> None:
        self._config = config
        communication = communication or Communication("", config)
        self._giving_way = GivingWay(seed)
        self.claims = Claims()
        self.grids = SharedGrids(config, communication)
        self.trail = Trail()
        self.homing = Homing(config.planning, config.body)
        told = config.planning
        self.errands = Errands(Methods(told.explore, told.coordinate, told.communication))
        self.goals = Goals(config.planning, communication)
        self._suspects = Suspects()
        self._recovery = Recovery(config.planning.stuck_after_s)
        self._aim: Aim | None = None
        self._planned_s: float | None = None
        self._grid: PlanGrid | None = None
        self._map: FusedGrid | None = None
        self._blocked = Blocked()
        self._arrived_s: float | None = None

    @property
    def frontiers(self) -> tuple[FrontierReport, ...]:
        """The edges of the unknown it could go to at the last plan, best first."""
        return self.goals.reports

    @property
    def local_map_m(self) -> float:
        """The side of the square round the robot that it plans on; 0 where it plans on the whole map."""
        own: float = getattr(self.goals.strategy, "local_map_m", 0.0)  # isinstance of a protocol is slow
        return self._config.planning.local_map_m or own

    def replan(self) -> None:
        """Plan anew at the next decision: the map has moved."""
        self._planned_s = None

    def take(self, order: RobotOrder, tags_left: int) -> None:
        """Take an operator's order; see ``order_reports`` for what becomes of it."""
        self.errands.take(order, tags_left)
        changed, self.errands.changed = self.errands.changed, Methods()
        self.goals.change(changed)
        if order.kind not in ("methods", "drop_tag"):
            self._giving_way.stop()
        self.replan()

    def order_reports(self) -> tuple[OrderReport, ...]:
        """Return what became of orders since this was last asked."""
        return self.errands.take_reports()

    def plan_is_due(self, now_s: float) -> bool:
        """Say whether the next decision plans anew and so needs the map as it is now."""
        rests = self._aim is not None and self._aim.kind == "rest"
        every_s = _REST_RECHECK_S if rests else self._config.planning.replan_every_s
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
        *,
        battery: float | None = None,
        suspects: Sequence[Suspect] = (),
    ) -> Decision:
        """Return what to do now, from the pose in the map frame, the fused map and where tags are."""
        self.homing.observe(now_s, pose, battery)
        self.trail.note(now_s, pose)
        if held or self.errands.holds:
            self._recovery.rest()
            why = "held by an order" if held else f"standing still, {self.errands.by}"
            return Decision(0.0, 0.0, "holding", why, drop_tag=self.errands.tag_wanted)
        if self._suspects.observe(now_s, pose, suspects, self.claims.victims(place_of) if suspects else ()):
            self.replan()
        recovery = self._recover(now_s, pose, bumped)
        if recovery is not None:
            return recovery
        if self.plan_is_due(now_s) and fused.cells.size:
            self._plan(now_s, pose, fused, place_of)
        return self._drive(now_s, pose, scan)

    def _drive(self, now_s: float, pose: Pose2, scan: LaserScan | None) -> Decision:
        """Follow the aim's path, and do at its end what it is for."""
        aim, tag = self._aim, self.errands.tag_wanted
        if aim is None or self._grid is None:
            return Decision(0.0, 0.0, "starting", "waiting for the first scan", drop_tag=tag)
        at_end = is_at_end(aim.path, pose)
        if aim.kind == "rest" or (aim.kind == "place" and at_end):
            self._recovery.rest()
            turn_radps = self._config.body.max_turn_radps if aim.looks else 0.0
            return Decision(0.0, turn_radps, aim.activity, aim.reason, aim.goal_m, drop_tag=tag)
        turn = self._look(now_s, pose, aim, at_end)
        if turn is not None:
            self._recovery.rest()
            return Decision(0.0, turn, aim.activity, aim.looking, aim.goal_m, drop_tag=tag)
        linear, angular = follow(aim.path, pose, self._grid, scan, self._config.body)
        if self._recovery.blocked(now_s, linear, angular):
            self._note_obstruction(now_s, pose)
        path = aim.path.astype(np.float32)
        return Decision(linear, angular, aim.activity, aim.reason, aim.goal_m, path, tag)

    def _plan(self, now_s: float, pose: Pose2, fused: FusedGrid, place_of: PlaceOf) -> None:
        self._planned_s, self._map = now_s, fused
        if self._giving_way.goes_on(now_s):
            return
        grid = self.grids.of(fused, self._blocked.discs(now_s))
        local = isinstance(self.goals.strategy, PlansLocally)
        ground = Ground.of(with_gaussian_costs(grid, self._config.planning.ziparo) if local else grid, pose)
        for narrower in self._narrower(ground, now_s) if self.homing.is_shut(ground) else ():
            ground = narrower if self.homing.is_shut(ground) else ground
        self._grid = ground.grid
        self._aim = self._giving_way.aim(now_s, ground) or self._next(now_s, ground, place_of)
        if self._aim.kind == "edge":
            self.homing.leave()
        else:
            self._arrived_s = None

    def _next(self, now_s: float, ground: Ground, place_of: PlaceOf) -> Aim:
        """Return what to do: go back when it has to, then orders, a possible victim, the unknown."""
        self.goals.reports = ()
        why = self.homing.due(now_s, ground)
        if why is not None:
            self.errands.overruled(why)
        if why is not None or self.errands.returns:
            aim = self.homing.aim(ground, why or self.errands.by, self.trail.points)
            if aim.kind == "rest" and aim.activity == "done":
                self.errands.home(aim.reason.rpartition("; ")[2])
                aim = aim if why else replace(aim, activity="holding")
            return aim
        edges = self.goals.edges(ground, self._config.planning.min_frontier_m, now_s)
        aim_ = self.errands.aim(now_s, ground, edges) or self._suspects.aim(ground)
        return aim_ or self._explore(now_s, ground, self.errands.near(edges), place_of)

    def _explore(self, now_s: float, ground: Ground, edges: tuple[Frontier, ...], place_of: PlaceOf) -> Aim:
        """Head for the edge that is worth most; where none is left, back to the base."""
        goals, shortest_m = self.goals, self._config.planning.min_frontier_m

        def choose(ground: Ground, edges: tuple[Frontier, ...]) -> Choice | None:
            return goals.choose(self._view(now_s, ground, goals.worth_going(edges, now_s), place_of))

        choice = choose(ground, edges)
        if choice is None and self._blocked.clear():  # ground left alone is tried before giving up
            self._planned_s = None
            return self._aim or Aim("rest", "exploring", "looking for a way")
        left, tried, narrower = edges, [ground], self._narrower(ground, now_s)
        while choice is None and (way := next(narrower, None)) is not None:
            tried.append(way)
            left = self.errands.near(goals.edges(way, shortest_m, now_s))
            choice = choose(way, (*left, *goals.untried(gaps(way, shortest_m))))
        ground = tried[-1] if choice is not None else tried[1]
        self._grid = ground.grid
        if choice is None:
            doubted = unproved(ground, self._map, self.trail.points, self._config.mapping.miss_logodds)
            left, choice = (*left, *doubted), goals.look_at(doubted, now_s, BEHIND_GLASS)
        if choice is None:
            shut = shut_off(ground, self.trail.points, shortest_m)
            left = (*left, *shut)
            choice = None if self.homing.is_shut(ground) else goals.look_at(shut, now_s, SHUT)
        path = None if choice is None else ground.way_to(choice.frontier)
        if choice is not None and path is not None:
            goals.goal_m, known = choice.frontier.goal_m, self._suspects.known_to_others(now_s)
            reason = f"driving {choice.frontier.cost_m:.0f} m to {choice.why}{known}"
            return Aim("edge", "exploring", reason, goals.goal_m, path)
        return self._finish(ground, left, now_s)

    def _view(
        self, now_s: float, ground: Ground, edges: tuple[Frontier, ...], place_of: PlaceOf
    ) -> ExplorationView:
        battery, tags = self.homing.battery, self.claims.tags(place_of)
        return ExplorationView(
            pose=ground.pose,
            frontiers=edges,
            survey_of=LateSurvey(self.claims, ground.grid, tags),
            now_s=now_s,
            grid=ground.grid,
            costs=ground.costs,
            trail=self.trail.points,
            path_m=np.zeros((0, 2)) if self._aim is None else rest_of(self._aim.path, ground.pose),
            tags=tags,
            tag_reach_m=self.claims.reach_m,
            battery=1.0 if battery is None else battery,
            settings=self._config.planning,
        )

    def _narrower(self, ground: Ground, now_s: float) -> Iterator[Ground]:
        assert self._map is not None
        return self.grids.narrower(ground, self._map, self._blocked.discs(now_s), self.trail.points)

    def _finish(self, ground: Ground, left: tuple[Frontier, ...], now_s: float) -> Aim:
        """Nothing is left to go to now: return to the base, out of the others' way."""
        self.goals.goal_m = None
        why, again = self.goals.left_over(left, now_s)
        aim = self.homing.aim(ground, why, self.trail.points)
        return replace(aim, activity="holding" if aim.kind == "rest" else "returning") if again else aim

    def _look(self, now_s: float, pose: Pose2, aim: Aim, at_end: bool) -> float | None:
        """Return how fast to turn (rad/s) to see what lies at the goal, None while driving there.

        A frontier that stays is put aside for a while.
        """
        turn = self._config.body.max_turn_radps
        if aim.kind == "suspect":
            bearing = self._suspects.turn_to(pose) if at_end else None
            return None if bearing is None else max(-turn, min(turn, 2.5 * bearing))
        goal = aim.goal_m
        if goal is None or hypot(goal[0] - pose.x, goal[1] - pose.y) > _ARRIVED_M:
            self._arrived_s = None
            return None
        self._arrived_s = now_s if self._arrived_s is None else self._arrived_s
        if now_s - self._arrived_s > _LOOK_S:
            self._put_aside(goal, now_s)
        return turn

    def _put_aside(self, goal: tuple[float, float], now_s: float, hindered: bool = False) -> None:
        self.goals.put_aside(goal, now_s, hindered)
        self._arrived_s, self._planned_s = None, None

    def _recover(self, now_s: float, pose: Pose2, bumped: bool) -> Decision | None:
        """Back off when driving leads nowhere, and put the place ahead aside for a while."""
        if self._aim is None or self._aim.kind == "rest" or self._grid is None:
            self._recovery.rest()
            return None
        backing = self._recovery.active
        if not backing and self._recovery.begins(now_s, pose, bumped):
            self._note_obstruction(now_s, pose)
        velocities = self._recovery.velocities(now_s)
        if velocities is not None:
            goal = None if self._aim is None else self._aim.goal_m
            return Decision(*velocities, "stuck", "backing off: something holds me", goal)
        if backing:
            self._planned_s = None
        return None

    def _note_obstruction(self, now_s: float, pose: Pose2) -> None:
        aim = self._aim
        goal = None if aim is None else aim.goal_m
        fails = self._recovery.keeps_failing  # else as good as there, and it cannot be had
        there = goal is not None and hypot(goal[0] - pose.x, goal[1] - pose.y) < 2.0 * _ARRIVED_M
        if aim and goal and (fails or there):
            if aim.kind == "edge":
                self._put_aside(goal, now_s, hindered=not there)
            elif aim.kind == "suspect":
                self._suspects.give_up()
        self._giving_way.stop()  # where it stepped aside to cannot be had either
        place = place_ahead(pose, self._config.body.radius_m + 0.25)
        self._blocked.add(place, now_s)
        if fails:
            self._recovery.forget()
            self._giving_way.ask(place)
