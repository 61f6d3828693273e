"""What deciding where to go costs a robot, by the number of robots in its team."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from robots.config import AgentConfig, PlanningConfig
from robots.exploration.scout import Intent, Scout, Situation
from robots.overrides import override
from robots.sim.arena.config import ArenaConfig
from robots.sim.arena.ground import ground_of
from robots.sim.arena.run import Arena
from robots.sim.scenario import ScenarioConfig

TEAMS: Mapping[str, Sequence[int]] = {"tags": (1, 5, 20, 50), "full": (1, 5, 20)}
_SECONDS = 60.0
_SETTLED_S = 20.0  # the first decisions are about next to nothing


class _Timed(Scout):
    """A scout that notes the processor time (ms) of steps in which it plans."""

    def __init__(self, robot_id: str, config: AgentConfig, spent_ms: list[float]) -> None:
        super().__init__(robot_id, config)
        self._spent_ms = spent_ms

    def step(self, now: Situation) -> Intent:
        plans = self.plan_is_due(now.stamp_s) and now.stamp_s > _SETTLED_S
        began = time.process_time()
        intent = super().step(now)
        if plans:
            self._spent_ms.append(1e3 * (time.process_time() - began))
        return intent


def measure(teams: Mapping[str, Sequence[int]] = TEAMS, seconds: float = _SECONDS) -> dict[str, Any]:
    """Return the median cost in ms of processor time, by communication and number of robots."""
    found: dict[str, Any] = {}
    for communication, sizes in teams.items():
        for robots in sizes:
            found[f"{communication}_{robots}_robots_ms"] = _cost_ms(communication, robots, seconds)
    tags = [found[f"tags_{robots}_robots_ms"] for robots in teams["tags"]]
    return {**found, "tags_largest_by_smallest": max(tags) / min(tags)}


def _cost_ms(communication: str, robots: int, seconds: float) -> float:
    planning = override(PlanningConfig(coordinate="hungarian"), {"communication": communication})
    scenario = ScenarioConfig(
        map="office:1240",
        robots=robots,
        seed=1,
        poses="truth",
        start="spread",
        victims=0,
        agent_config=AgentConfig(planning=planning),
    )
    config = ArenaConfig(scenario, "at once", limit_s=seconds)
    arena = Arena(config, ground_of(scenario))
    spent_ms: list[float] = []
    for robot in arena.robots:
        robot.scout = _Timed(robot.robot_id, robot.scout.config, spent_ms)
    arena.play()
    return float(np.median(spent_ms))
