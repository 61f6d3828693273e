"""One simulated mission as an agent saw it, and logs made by hand."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

from robots.agent import RobotAgent
from robots.config import AgentConfig
from robots.sim.runner import run
from robots.sim.scenario import ScenarioConfig
from robots.types import AgentUpdate, Observation, Odometry, TagSighting

MISSION = ScenarioConfig(map="office:100", robots=1, minutes=2.0, seed=4, noise_level=3, victims=2)
Log = tuple[Observation, ...]


class Listener:
    """An agent that keeps what it was told."""

    def __init__(self, robot_id: str, config: AgentConfig) -> None:
        self.agent = RobotAgent(robot_id, config)
        self.heard: list[Observation] = []

    def step(self, observation: Observation) -> AgentUpdate:
        self.heard.append(observation)
        return self.agent.step(observation)

    def smoothed(self) -> AgentUpdate:
        return self.agent.smoothed()


@lru_cache(maxsize=4)
def mission_log(imu: bool) -> tuple[Log, AgentConfig]:
    listeners: list[Listener] = []

    def listener(robot_id: str, config: AgentConfig) -> Listener:
        listeners.append(Listener(robot_id, config))
        return listeners[-1]

    scenario = replace(MISSION, imu=imu)
    run(scenario, listener)
    return tuple(listeners[0].heard), scenario.agent_of("r1")


def replayed(log: Sequence[Observation], config: AgentConfig, robot_id: str = "r1") -> list[AgentUpdate]:
    agent = RobotAgent(robot_id, config)
    return [agent.step(observation) for observation in log]


@lru_cache(maxsize=4)
def mission_updates(imu: bool) -> tuple[AgentUpdate, ...]:
    return tuple(replayed(*mission_log(imu)))


def driving(
    steps: int, odometry: Odometry, tags: dict[int, str] | None = None, start: int = 0
) -> list[Observation]:
    """A log without a laser: the same odometry ``steps`` times, at 5 Hz, with tags at some of them."""
    return [
        Observation(
            seq=seq,
            stamp_s=seq * 0.2,
            odometry=odometry,
            tag_sightings=(TagSighting(tags[seq]),) if tags and seq in tags else (),
        )
        for seq in range(start, start + steps)
    ]
