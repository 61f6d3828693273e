"""A real robot's log, and mission control with its real agents to send it to."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import pytest

from robots.agent import RobotAgent, merge_commands
from robots.config import AgentConfig
from robots.overrides import override
from robots.sim.scenario import ScenarioConfig
from robots.sim.simulation import Order, Simulation
from robots.sim.wire import command_to_wire, observation_to_wire, pose_to_wire
from robots.types import AgentUpdate, Observation
from tests.server.control import CONFIG, Control, Json, Line, wait_until

_SECONDS = 24


@dataclass(frozen=True)
class Drive:
    """What a robot of the simulator observed, and what an agent that is never interrupted makes of it."""

    batches: tuple[tuple[Observation, ...], ...]
    updates: tuple[tuple[AgentUpdate, ...], ...]
    agent: RobotAgent

    @cached_property
    def wires(self) -> list[list[Json]]:
        return [[observation_to_wire(observation) for observation in batch] for batch in self.batches]

    def expected(self, batch: int) -> Json:
        """The pose and command of the reply to a batch."""
        updates = self.updates[batch]
        command = command_to_wire(merge_commands(updates))
        return {"pose": pose_to_wire(updates[-1].pose), "command": command}


@pytest.fixture(scope="session")
def drive() -> Drive:
    """A robot alone in a small office: it drops tags, writes into one, and sees victims."""
    config = override(AgentConfig(), CONFIG)
    simulation = Simulation(ScenarioConfig(map="office:60", robots=1, seed=4, victims=3, agent_config=config))
    agent = RobotAgent("r1", config)
    batches, updates = [], []
    for _ in range(_SECONDS * 5):
        batch = simulation.advance()["r1"]
        made = tuple(agent.step(observation) for observation in batch)
        batches.append(batch)
        updates.append(made)
        simulation.apply({"r1": Order(merge_commands(made))})
    return Drive(tuple(batches), tuple(updates), agent)


@pytest.fixture(scope="session")
def control(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Control]:
    """The server that most tests share; each opens a mission of its own."""
    control = Control(tmp_path_factory.mktemp("control"), snapshot_every=40)
    control.start()
    yield control
    control.stop()


@pytest.fixture(scope="session")
def control_type() -> type[Control]:
    """Control itself, for fixtures that outlive a test."""
    return Control


@pytest.fixture
def make_control() -> Iterator[Callable[..., Control]]:
    """A function that starts a server on a folder with settings; all are stopped at the end."""
    made: list[Control] = []

    def make(folder: Path, **settings: Any) -> Control:
        made.append(Control(folder, **settings))
        made[-1].start()
        return made[-1]

    yield make
    for control in made:
        control.stop()


@pytest.fixture
def line(control: Control) -> Line:
    """A mission with one robot, r1, that has not sent anything."""
    line = control.open()
    assert line.register(**line.words).status_code == 201
    return line


@pytest.fixture(scope="session")
def driven(control: Control, drive: Drive) -> Line:
    """A mission whose robot has driven the whole drive. Tests leave it as it is."""
    line = control.open("driven")
    line.register(**line.words)
    for wires in drive.wires:
        line.send(wires)
    with line.stream() as stream:
        stream.until(lambda s: "map" in s.state and s.kind("victim"))
        stream.until(lambda s: len(s.kind("tag")) == len(drive.agent.report().graph.tag_ids))
        # a solve may take longer than the second without news after which the stream is taken to be at rest
        team = control.missions.get(line.mission_id).shared_map._team
        wait_until(lambda: not (team._changed.is_set() or team._solving))
        stream.settle()
    return line


@pytest.fixture(name="wait_until")
def _wait_until() -> Callable[..., None]:
    return wait_until
