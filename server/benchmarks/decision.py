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
_TIMED = 12  # robots at most, of the largest team
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

    With tags only, the very same robots of the largest team are timed in all sizes, each from where it starts
    in the large one: what differs is the company. Teams take turns.
    """
    found: dict[str, Any] = {}
    for communication, sizes in teams.items():
        spent_ms: dict[int, list[float]] = {robots: [] for robots in sizes}
        if communication == "tags":
            timed = _timed(sizes)
            turns = sorted({(k // n * n, n) for k in timed for n in sizes})
            for first, n in turns:
                _play(communication, max(sizes), range(first, first + n), timed, seconds, spent_ms[n])
        else:  # who talks is one of a fixed team
            for n in sizes:
                _play(communication, n, range(n), range(n), seconds, spent_ms[n])
        found |= {f"{communication}_{robots}_robots_ms": _median(spent_ms[robots]) for robots in sizes}
    tags = [found[f"tags_{robots}_robots_ms"] for robots in teams["tags"]]
    return {**found, "tags_largest_by_smallest": max(tags) / min(tags)}


def _timed(sizes: Sequence[int]) -> range:
    """Return which robots to time: some, spread over those that are in a whole team of every size."""
    most = max(sizes)
    return range(0, min(most // n * n for n in sizes), max(1, most // _TIMED))


def _median(spent_ms: Sequence[float]) -> float:
    return float(np.median(spent_ms))


def _play(
    communication: str, robots: int, who: range, timed: range, seconds: float, spent_ms: list[float]
) -> None:
    """Let some robots of a team explore without the others, and note what decisions of the timed cost."""
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
    for robot in (arena.robots[k] for k in timed if k in who):
        robot.scout = _Timed(robot.robot_id, robot.scout.config, spent_ms)
    arena.robots = arena.robots[who.start : who.stop]
    arena.play()
