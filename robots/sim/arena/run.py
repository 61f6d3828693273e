"""Playing a run of the arena."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf

import numpy as np

from robots.mapping.scan_map import ScanMap
from robots.se2 import Array
from robots.sim.arena.config import ArenaConfig
from robots.sim.arena.ground import Ground, ground_of
from robots.sim.arena.kernels import absorb
from robots.sim.arena.result import ArenaResult, claimed_share, leaves_a_hole
from robots.sim.arena.robot import ArenaRobot
from robots.sim.tags import BASE_TAG, TagField
from robots.sim.team_radio import TeamRadio
from robots.sim.world import Cells

_NOBODY = np.zeros((0, 2))


@dataclass(slots=True)
class _Log:
    stamps_s: list[float] = field(default_factory=list)
    cells: list[int] = field(default_factory=list)
    driven_m: list[float] = field(default_factory=list)


class Arena:
    """A run being played."""

    def __init__(self, config: ArenaConfig, ground: Ground) -> None:
        self.config = config
        self.ground = ground
        scenario, world = config.scenario, ground.world
        self.field = TagField(scenario.memory_bits, scenario.chip)
        shared = None
        if config.one_map:
            rows, columns = world.cells.shape
            x, y = world.origin_m
            high = x + columns * world.resolution_m, y + rows * world.resolution_m
            shared = ScanMap(config.agent_of(scenario.robot_ids[0]).mapping, world.origin_m, high)
        if scenario.base_tag:
            self.field.drop(BASE_TAG, ground.starts[0].x, ground.starts[0].y)
        together = scenario.start == "same" and not config.collide
        self.robots = [
            ArenaRobot(config, ground, self.field, index, ground.starts[0 if together else index], shared)
            for index in range(scenario.robots)
        ]
        base_m = ground.starts[0].x, ground.starts[0].y
        self._radio = TeamRadio(scenario, world, base_m)
        self.seen: Cells = np.zeros_like(world.cells)
        self.clock_s = 0.0
        self._count = 0
        self._log = _Log()
        self._reach = int(scenario.laser.range_max_m / world.resolution_m) + 2
        self._enough = config.until * float(ground.observable.sum())
        self._false_ends: set[str] = set()
        self._claimed: list[float | None] = []

    def play(self) -> ArenaResult:
        """Play to the end."""
        if self.config.in_order == "sequence":
            self._in_sequence()
        else:
            self._at_once()
        return self._result()

    def _in_sequence(self) -> None:
        config = self.config
        for robot in self.robots:
            ends_s = self.clock_s + config.limit_s
            while robot.driven_m < config.budget_m - 1e-6 and self.clock_s < ends_s:
                self._step(robot, _NOBODY)
                self._note()
                self.clock_s += config.step_s
                if robot.decision.activity == "done":
                    break
            self._claimed.append(claimed_share(robot, self.seen, self.ground))

    def _at_once(self) -> None:
        config = self.config
        budgets_m = config.budget_m * len(self.robots)
        while self.clock_s < config.limit_s and self._count < self._enough:
            for robot in self.robots:
                self._step(robot, self._others(robot))
            self._note()
            self.clock_s += config.step_s
            if not self._claimed and self._log.driven_m[-1] >= budgets_m:
                self._note_claims()
            if all(robot.decision.activity == "done" for robot in self.robots):
                break
        if not self._claimed:
            self._note_claims()

    def _note_claims(self) -> None:
        self._claimed = [claimed_share(robot, self.seen, self.ground) for robot in self.robots]

    def _poses(self) -> Array:
        return np.array([(robot.pose.x, robot.pose.y, robot.pose.theta) for robot in self.robots])

    def _others(self, robot: ArenaRobot) -> Array:
        if not self.config.collide:
            return _NOBODY
        return np.array([(o.pose.x, o.pose.y) for o in self.robots if o is not robot]).reshape(-1, 2)

    def _step(self, robot: ArenaRobot, others_m: Array) -> None:
        was_done = robot.decision.activity == "done"
        row, column = self.ground.world.cell(robot.pose.x, robot.pose.y)
        index = self.robots.index(robot)
        heard = self._radio.take(index, self._poses(), self.clock_s) if self._radio.talks else ()
        said = robot.step(self.clock_s, others_m, heard)
        if said is not None:
            self._radio.say(index, said, self._poses(), self.clock_s)
        rows, columns = self.seen.shape
        self._count += absorb(
            robot.seen, self.seen, self.ground.observable,
            max(0, row - self._reach), max(0, column - self._reach),
            min(rows, row + self._reach + 1), min(columns, column + self._reach + 1),
        )  # fmt: skip
        if robot.decision.activity == "done" and not was_done:
            alone = robot.scout.config.planning.communication in ("none", "tags") and not self.config.one_map
            if leaves_a_hole(robot.seen if alone else self.seen, self.ground):
                self._false_ends.add(robot.robot_id)

    def _note(self) -> None:
        self._log.stamps_s.append(self.clock_s)
        self._log.cells.append(self._count)
        self._log.driven_m.append(sum(robot.driven_m for robot in self.robots))

    def _result(self) -> ArenaResult:
        area_m2 = self.ground.world.resolution_m**2
        covered, driven = np.array(self._log.cells) * area_m2, np.array(self._log.driven_m)
        budgets_m = self.config.budget_m * len(self.robots)
        spent = driven >= budgets_m if self.config.in_order == "at once" and budgets_m < inf else driven < 0.0
        at = int(spent.argmax()) if spent.any() else len(driven) - 1
        claimed = [share for share in self._claimed if share is not None]
        return ArenaResult(
            observable_m2=self.ground.observable_m2,
            stamps_s=np.array(self._log.stamps_s),
            covered_m2=covered,
            driven_m=driven,
            score=float(covered[at] / driven[at]) if driven[at] > 0.0 else 0.0,
            steps=sum(robot.steps for robot in self.robots),
            times_stuck=sum(robot.times_stuck for robot in self.robots),
            false_ends=len(self._false_ends),
            tags=len(self.field.tags),
            claimed_share=float(np.mean(claimed)) if claimed else None,
        )


def play(config: ArenaConfig) -> ArenaResult:
    """Play a run.

    Raises:
        WorldError, ScenarioError: it cannot be played; the message says why.
    """
    return Arena(config, ground_of(config.scenario)).play()
