"""Running agents over a recording, as fast as they go, and solving their map at the end."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter

import numpy as np

from robots.agent import RobotAgent
from robots.config import AgentConfig, override
from robots.datasets.recording import Recording
from robots.se2 import Array
from robots.team import TeamMap, TeamRobot, TeamUpdate
from robots.trajectory import Trajectory, TrajectoryStep, edges_of, final_trajectory
from robots.types import AgentUpdate


@dataclass(frozen=True, slots=True, eq=False)
class RobotReplay:
    """One robot's day: estimates as they were made and after the last solve, on the recording's own clock."""

    robot_id: str
    online: Trajectory
    final: Trajectory
    distance_m: float
    sightings: int
    step_s: Array  # (n,) time each step took


@dataclass(frozen=True, slots=True, eq=False)
class ReplayResult:
    """What agents made of a recording."""

    robots: tuple[RobotReplay, ...]
    team: TeamUpdate


def replay(recording: Recording, on_step: Callable[[], None] = lambda: None) -> ReplayResult:
    """Run an agent per robot over the recording; ``on_step`` is called after each observation."""
    config = override(AgentConfig(), recording.settings)
    team = TeamMap(config.mapping.resolution_m)
    days = []
    for robot_id in recording.robots:
        team.add_robot(robot_id, None)
        day = _Day(recording, robot_id, config, on_step)
        team.put(robot_id, day.last)
        days.append(day)
    solved = team.solve()
    by_id = {robot.robot_id: robot for robot in solved.robots}
    return ReplayResult(tuple(day.result(by_id[day.robot_id]) for day in days), solved)


class _Day:
    def __init__(
        self, recording: Recording, robot_id: str, config: AgentConfig, on_step: Callable[[], None]
    ) -> None:
        agent = RobotAgent(robot_id, config)
        self.robot_id = robot_id
        self._stamps = recording.stamps_s(robot_id)
        self._steps: list[TrajectoryStep] = []
        self._online: list[Array] = []
        self._step_s: list[float] = []
        self._sightings = 0
        for observation in recording.observations(robot_id):
            began = perf_counter()
            update = agent.step(observation)
            self._step_s.append(perf_counter() - began)
            self._sightings += len(observation.tag_sightings)
            self._keep(update)
            on_step()
        self.last = agent.report()

    def _keep(self, update: AgentUpdate) -> None:
        stamp = float(self._stamps[len(self._steps)])
        self._steps.append(TrajectoryStep(stamp, update.anchor, update.anchor_from_base))
        self._online.append(update.pose.as_array())

    def result(self, solved: TeamRobot) -> RobotReplay:
        edges = edges_of(self.last.graph) if self.last.graph is not None else {}
        return RobotReplay(
            robot_id=self.robot_id,
            online=Trajectory(self._stamps, np.array(self._online).reshape(-1, 3)),
            final=final_trajectory(self._steps, solved.anchors, edges),
            distance_m=self.last.distance_m,
            sightings=self._sightings,
            step_s=np.array(self._step_s),
        )
