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
_SECONDS = 40.0
_GROUPS = 8  # of each size that is smaller than the largest
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
    """Return the median cost in ms of processor time, by communication and number of robots.

    With tags only, robots of the largest team also explore in smaller ones, each from where it starts in the
    large one: what differs is the company. Teams take turns.
    """
    found: dict[str, Any] = {}
    for communication, sizes in teams.items():
        spent_ms: dict[int, list[float]] = {robots: [] for robots in sizes}
        whole = max(sizes) if communication == "tags" else 0  # who talks is one of a fixed team
        turns = [(first, n) for n in sizes for first in _firsts(n, whole or n)]
        for first, robots in sorted(turns):
            _play(communication, whole or robots, slice(first, first + robots), seconds, spent_ms[robots])
        found |= {f"{communication}_{robots}_robots_ms": _median(spent_ms[robots]) for robots in sizes}
    tags = [found[f"tags_{robots}_robots_ms"] for robots in teams["tags"]]
    return {**found, "tags_largest_by_smallest": max(tags) / min(tags)}


def _firsts(robots: int, whole: int) -> Sequence[int]:
    """Return where teams of so many begin in the list of all robots, spread over it."""
    firsts = range(0, whole - robots + 1, robots)
    return firsts[:: max(1, len(firsts) // _GROUPS)]


def _median(spent_ms: Sequence[float]) -> float:
    return float(np.median(spent_ms))


def _play(communication: str, robots: int, who: slice, seconds: float, spent_ms: list[float]) -> None:
    """Let some robots of a team explore without the others, and note what their decisions cost."""
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
    arena = Arena(ArenaConfig(scenario, "at once", limit_s=seconds), ground_of(scenario))
    arena.robots = arena.robots[who]
    for robot in arena.robots:
        robot.scout = _Timed(robot.robot_id, robot.scout.config, spent_ms)
    arena.play()
