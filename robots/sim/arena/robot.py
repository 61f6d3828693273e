"""A robot of the arena: a scout told its true pose, its laser's map and the tags it reads."""

from __future__ import annotations

from dataclasses import replace
from math import floor, hypot

import numpy as np

from robots.exploration.aim import Decision
from robots.exploration.scout import Intent, Scout, Situation
from robots.mapping.scan_map import ScanMap
from robots.planning.following import free_ahead
from robots.se2 import Array, Pose2
from robots.sim.arena.config import STEP_M, ArenaConfig
from robots.sim.arena.ground import Ground
from robots.sim.arena.kernels import edge_is_left, walk, way_is_clear
from robots.sim.arena.reader import BelievedPlaces, FieldReader
from robots.sim.body import inside_solid
from robots.sim.sensors import Laser
from robots.sim.simulation import DRIVE_LIFE_M, IDLE_LIFE_S
from robots.sim.tags import Magazine, TagField
from robots.sim.world import Cells
from robots.types import TagSighting

_EDGE_WITHIN_M = 0.7  # of the goal: there the frontier is that the robot drives to
_LOOK_AHEAD_M = 2.0
_PLAN_AGAIN_S = 1.0  # at the soonest, for what tags say
_REST_S = 5.0  # a robot that is done looks round so often
_FELT_M = 0.08
_GRAZE_M = 0.02  # a body may come so much nearer to a wall than its radius: maps are coarse
_WAY_M, _STUCK_S = 0.15, 60.0


class ArenaRobot:
    """One robot; ``pose`` is its true pose in the world, ``seen`` uint8 (h, w) what its laser truly saw."""

    def __init__(
        self,
        config: ArenaConfig,
        ground: Ground,
        field: TagField,
        index: int,
        start: Pose2,
        shared: ScanMap | None,
    ) -> None:
        scenario = config.scenario
        self.robot_id = scenario.robot_ids[index]
        told = replace(config.agent_of(self.robot_id), start=(start.x, start.y, start.theta))
        self.scout = Scout(self.robot_id, told)
        self.start = self.pose = start
        self.map = self._begin_map(ground, shared)
        self.places = BelievedPlaces(field, self.start, config.tag_error_m, (scenario.seed, 30, index))
        self.seen: Cells = np.zeros_like(ground.world.cells)
        self.driven_m = 0.0
        self.steps = 0
        self.times_stuck = 0
        self.decision = self.scout.decision
        self._config = config
        self._reads = self.scout.config.planning.communication != "none"
        self._world = ground.world
        self._field = field
        self._radius_m = self.scout.config.body.radius_m
        self._laser = Laser(ground.world, scenario.laser, np.random.default_rng([scenario.seed, 12, index]))
        self._reader = FieldReader(config, ground.world, field)
        self._magazine = Magazine(self.robot_id, self.scout.config.deployment.magazine)
        self._before = self.pose
        self._began_s = 0.0
        self._bumped = False
        self._heard: dict[str, bytes] = {}
        self._unheard: tuple[bytes, ...] = ()  # messages of the team
        self._news_s: float | None = None  # since when something read waits for a plan
        self._planned_s = 0.0
        self._wakes_s = 0.0
        self._way: tuple[float, float, float] | None = None  # where and when it last made way

    def step(self, clock_s: float, others_m: Array, heard: tuple[bytes, ...] = ()) -> bytes | None:
        """Look, read tags, decide, and move on for one step; return what to tell the team.

        ``others_m`` (k, 2): the others' places where they count; ``heard``: what the team told.
        """
        self._unheard += heard
        if clock_s < self._wakes_s:
            return None
        if self.steps == 0:
            self._began_s = clock_s
        self.steps += 1
        pose = Pose2(self.pose.x - self.start.x, self.pose.y - self.start.y, self.pose.theta)
        scan = self._laser.scan(self.pose, others_m, self._radius_m, self.seen)
        if not self.scout.explorer.local_map_m:
            self.map.add_scan(pose, scan)
        if self._bumped and free_ahead(scan, self._radius_m) >= 0.25:
            ahead = pose @ Pose2(self._radius_m + _FELT_M, 0.0, 0.0)
            self.map.add_obstacle(ahead.x, ahead.y, _FELT_M)
        read = self._read(clock_s)
        if self._unheard and self._news_s is None:
            self._news_s = clock_s
        if self._must_plan(clock_s, pose):
            self.scout.replan()
            self._planned_s, self._news_s = clock_s, None
        intent = self.scout.step(
            Situation(
                stamp_s=clock_s,
                pose=pose,
                fused=self.map,
                distance_m=self.driven_m,
                seq=self.steps - 1,
                scan=scan,
                bumper=self._bumped,
                battery=max(
                    0.0, 1.0 - (clock_s - self._began_s) / IDLE_LIFE_S - self.driven_m / DRIVE_LIFE_M
                ),
                tags_left=self._magazine.left,
                read=read,
                heard=self._unheard,
                tag_place=self.places.of,
                tag_sd_m=self._config.tag_error_m,
                tag_places=self.places.all,
            )
        )
        self._unheard = ()
        self._handle_tags(intent)
        self.decision = intent.decision
        thinking_s = self._config.plan_cost_s * self.scout.explorer.goals.take_planned()
        if thinking_s > 0.0:
            self._wakes_s = clock_s + thinking_s
            return intent.say
        if self.decision.activity == "done":
            self._wakes_s = clock_s + _REST_S
        self._move(self.decision, others_m)
        self._watch(clock_s)
        return intent.say

    def _begin_map(self, ground: Ground, shared: ScanMap | None) -> ScanMap:
        """Return a map in this robot's frame, of its own or with the cells of one that all share."""
        world = ground.world
        low = world.origin_m[0] - self.start.x, world.origin_m[1] - self.start.y
        rows, columns = world.cells.shape
        high = low[0] + columns * world.resolution_m, low[1] + rows * world.resolution_m
        if shared is not None:
            own = shared.seen_from(self.start.x, self.start.y)
        else:
            own = ScanMap(self.scout.config.mapping, low, high)
        own.add_free(Pose2(), self.scout.config.body.radius_m)
        return own

    def _battery(self, clock_s: float) -> float:
        return max(0.0, 1.0 - (clock_s - self._began_s) / IDLE_LIFE_S - self.driven_m / DRIVE_LIFE_M)

    def _read(self, clock_s: float) -> tuple[TagSighting, ...]:
        if not self._reads:
            return ()
        read = self._reader.sightings(self._before, self.pose, clock_s)
        if self._config.own_tags_only:
            read = tuple(sighting for sighting in read if sighting.tag_id.startswith(f"{self.robot_id}-"))
        for sighting in read:
            self.places.learn(sighting.tag_id)
            known = self._heard.get(sighting.tag_id)
            if known is None or not sighting.memory.startswith(known):
                self._heard[sighting.tag_id] = sighting.memory
                self._news_s = clock_s if self._news_s is None else self._news_s
        return read

    def _must_plan(self, clock_s: float, pose: Pose2) -> bool:
        """Say whether what was planned is overtaken: by news, an edge that is gone, or a way that is shut."""
        if self._news_s is not None and clock_s >= self._planned_s + _PLAN_AGAIN_S and self._news_s < clock_s:
            return True
        if self.scout.explorer.local_map_m:  # what it drives to lies at the edge of a map that goes along
            return clock_s >= self._planned_s + _PLAN_AGAIN_S
        decision, config = self.decision, self.scout.config
        if decision.goal_m is None or decision.activity not in ("exploring", "returning"):
            return False
        cells, origin, cell_m = self.map.cells, self.map.origin, self.map.resolution_m
        occupied, free = config.mapping.occupied_logodds, config.mapping.miss_logodds
        x, y = decision.goal_m
        row, column = floor((y - origin[1]) / cell_m), floor((x - origin[0]) / cell_m)
        if cells[row, column] > -free:  # a goal on ground that others told of: their word is not checked here
            return False
        if not edge_is_left(cells, origin, cell_m, x, y, _EDGE_WITHIN_M, occupied, free):
            return True
        return not way_is_clear(
            cells, origin, cell_m, decision.path_m, pose.x, pose.y, _LOOK_AHEAD_M, self._radius_m, occupied
        )

    def _handle_tags(self, intent: Intent) -> None:
        for write in intent.writes:
            if self._field.write(write.tag_id, write.memory, self.pose.x, self.pose.y, self._reader.reaches):
                self._heard[write.tag_id] = write.memory
        if intent.drop:
            tag_id = self._magazine.take()
            if tag_id is not None:
                self._field.drop(tag_id, self.pose.x, self.pose.y)

    def _move(self, decision: Decision, others_m: Array) -> None:
        """Go a step along the way planned, or as the velocities say where there is none."""
        self._before, self._bumped = self.pose, False
        pose = self.pose
        if len(decision.path_m) and decision.activity in ("exploring", "returning"):
            here_x, here_y = pose.x - self.start.x, pose.y - self.start.y
            x, y, theta, gone = walk(decision.path_m, here_x, here_y, pose.theta, STEP_M)
            to = Pose2(x + self.start.x, y + self.start.y, theta)
        else:
            dt = self._config.step_s
            to = pose @ Pose2.exp(np.array([decision.linear_mps * dt, 0.0, decision.angular_radps * dt]))
            gone = abs(decision.linear_mps) * dt
        if gone > 0.0 and not self._fits(to, others_m):
            self.pose, self._bumped = Pose2(pose.x, pose.y, to.theta), True
            return
        self.pose = to
        self.driven_m += gone

    def _fits(self, pose: Pose2, others_m: Array) -> bool:
        if inside_solid(self._world, pose.x, pose.y, self._radius_m - _GRAZE_M):
            return False
        for x, y in others_m:
            gap_m = hypot(x - pose.x, y - pose.y)
            if gap_m < 2.0 * self._radius_m and gap_m < hypot(x - self.pose.x, y - self.pose.y):
                return False
        return True

    def _watch(self, clock_s: float) -> None:
        """Count how often it made no way for a minute while it meant to."""
        way, pose = self._way, self.pose
        meant_to = self.decision.activity in ("exploring", "returning", "stuck")
        if way is None or not meant_to or hypot(pose.x - way[0], pose.y - way[1]) > _WAY_M:
            self._way = pose.x, pose.y, clock_s
        elif clock_s - way[2] > _STUCK_S:
            self.times_stuck += 1
            self._way = pose.x, pose.y, clock_s
