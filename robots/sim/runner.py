"""Batch runs: a scenario played with agents stepped directly, as fast as the machine allows."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from robots.agent import RobotAgent, merge_commands
from robots.graph_report import IntArray
from robots.se2 import Array, Pose2
from robots.sim.pilots import Agent, AgentFactory, DirectPilot, Merge, Pilot, RadioPilot
from robots.sim.scenario import ScenarioConfig
from robots.sim.score import CoverageLog, Score, observable, score
from robots.sim.simulation import Simulation
from robots.sim.starts import Victim
from robots.sim.tags import BASE_TAG, Tag
from robots.sim.world import Mask, World
from robots.types import AgentUpdate, Observation

SHARES = (0.5, 0.9, 0.99)  # of what can be seen


@dataclass(frozen=True, eq=False)
class RobotResult:
    """One robot's mission: k observations, estimates as they were made beside the truth.

    ``start`` true start pose in the world; ``world_from_map`` where its map frame lies. ``stamps_s`` (k,),
    ``poses`` (k, 3) in the map frame, ``truths`` (k, 3) in the world; ``anchors`` (k,) and
    ``anchors_from_base`` (k, 3) of each update, to be placed again by the final graph; ``steps_s`` (k,) wall
    time of each step; ``with_scan`` (k,) which had a laser scan.
    """

    robot_id: str
    start: Pose2
    world_from_map: Pose2
    stamps_s: Array
    poses: Array
    truths: Array
    anchors: IntArray
    anchors_from_base: Array
    steps_s: Array
    with_scan: NDArray[np.bool_]
    report: AgentUpdate
    distance_m: float

    @cached_property
    def final_poses(self) -> Array:
        """The trajectory placed by the last graph, (k, 3), in the map frame."""
        graph = self.report.graph
        if graph is None:
            return self.poses
        placed = np.empty_like(self.poses)
        for k, (anchor, offset) in enumerate(zip(self.anchors, self.anchors_from_base, strict=True)):
            placed[k] = (Pose2.from_array(graph.poses[anchor]) @ Pose2.from_array(offset)).as_array()
        return placed

    @property
    def victims_m(self) -> Array:
        """Where the robot believes victims to be, (e, 2), in the world frame."""
        places = []
        for victim in self.report.victims:
            graph = self.report.graph
            map_from_anchor = Pose2() if graph is None else Pose2.from_array(graph.poses[victim.anchor])
            x, y = (float(value) for value in victim.position_m)
            places.append((self.world_from_map @ map_from_anchor).transform_point(x, y))
        return np.array(places).reshape(-1, 2)


@dataclass(frozen=True, eq=False)
class SimulationResult:
    """A whole mission. ``stopped`` when it was ended early; ``clock_s`` is how long it ran.

    ``covered_s``: when each of ``SHARES`` of what can be seen was seen; None when it was not.
    ``known_at_base``: the share of it that the base was told of by radio; None without.
    """

    config: ScenarioConfig
    world: World
    victims: tuple[Victim, ...]
    tags: tuple[Tag, ...]
    robots: tuple[RobotResult, ...]
    score: Score
    covered_s: Mapping[float, float | None]
    known_at_base: float | None
    clock_s: float
    wall_s: float
    stopped: bool

    @property
    def tags_dropped(self) -> int:
        """Tags laid down by the robots."""
        return sum(tag.tag_id != BASE_TAG for tag in self.tags)


@dataclass(slots=True)
class _Log:
    """What is noted of one robot while it runs."""

    stamps_s: list[float] = field(default_factory=list)
    poses: list[Pose2] = field(default_factory=list)
    anchors: list[int] = field(default_factory=list)
    anchors_from_base: list[Pose2] = field(default_factory=list)
    steps_s: list[float] = field(default_factory=list)
    with_scan: list[bool] = field(default_factory=list)

    def note(self, observation: Observation, update: AgentUpdate) -> None:
        self.stamps_s.append(observation.stamp_s)
        self.poses.append(update.pose)
        self.anchors.append(update.anchor)
        self.anchors_from_base.append(update.anchor_from_base)
        self.with_scan.append(observation.scan is not None)


class _Timed:
    """An agent whose steps are timed."""

    def __init__(self, agent: Agent, steps_s: list[float]) -> None:
        self._agent = agent
        self._steps_s = steps_s

    def step(self, observation: Observation) -> AgentUpdate:
        start = time.perf_counter()
        update = self._agent.step(observation)
        self._steps_s.append(time.perf_counter() - start)
        return update

    def smoothed(self) -> AgentUpdate:
        return self._agent.smoothed()


def run(
    config: ScenarioConfig,
    agent_factory: AgentFactory = RobotAgent,
    *,
    merge: Merge = merge_commands,
    progress: Callable[[Simulation], None] | None = None,
    stop: Callable[[], bool] = lambda: False,
) -> SimulationResult:
    """Play a scenario with one agent per robot and return what came of it.

    ``progress`` is called after every control period; when ``stop`` returns True the mission ends there.

    Raises:
        WorldError, ScenarioError: it cannot be played; the message says why.
    """
    began = time.perf_counter()
    simulation = Simulation(config)
    logs = {robot_id: _Log() for robot_id in config.robot_ids}
    agents = {
        robot_id: _Timed(agent_factory(robot_id, simulation.agent_of(robot_id)), logs[robot_id].steps_s)
        for robot_id in config.robot_ids
    }
    pilots: dict[str, Pilot] = {
        robot_id: radio(config, robot_id, DirectPilot(agents[robot_id], merge, logs[robot_id].note))
        for robot_id in config.robot_ids
    }
    coverage = CoverageLog(_observable(simulation))
    stopped = False
    for _ in range(config.periods):
        batches = simulation.advance()
        simulation.apply(
            {name: pilots[name].decide(batch, simulation.clock_s) for name, batch in batches.items()}
        )
        coverage.note(simulation.clock_s, simulation.seen)
        if progress is not None:
            progress(simulation)
        if stop():
            stopped = True
            break
    wall_s = time.perf_counter() - began  # of the mission; smoothing comes after it
    reports = {robot_id: agent.smoothed() for robot_id, agent in agents.items()}
    robots = tuple(
        _result(simulation, robot_id, logs[robot_id], reports[robot_id]) for robot_id in config.robot_ids
    )
    return SimulationResult(
        config=config,
        world=simulation.world,
        victims=simulation.victims,
        tags=simulation.tags.tags,
        robots=robots,
        score=mission_score(simulation, [robot.victims_m for robot in robots], coverage.observable),
        covered_s={share: coverage.reached_s(share) for share in SHARES},
        known_at_base=simulation.team_radio.known_at_base(coverage.observable),
        clock_s=simulation.clock_s,
        wall_s=wall_s,
        stopped=stopped,
    )


def radio(config: ScenarioConfig, robot_id: str, pilot: Pilot) -> Pilot:
    """Return the pilot behind the robot's radio; an agent on board needs none."""
    cuts = [cut for cut in config.radio_cuts if cut.robot_id == robot_id]
    return RadioPilot(pilot, cuts, config.silence) if cuts and config.agent == "server" else pilot


def mission_score(
    simulation: Simulation, victims_m: Sequence[Array], observable_cells: Mask | None = None
) -> Score:
    """Return the score so far of robots that believe victims at ``victims_m``, (e, 2) each, in the world."""
    config = simulation.config
    estimates = np.concatenate([np.zeros((0, 2)), *victims_m])
    return score(
        simulation.world,
        simulation.seen,
        _observable(simulation) if observable_cells is None else observable_cells,
        sum(simulation.driven_m(robot_id) for robot_id in config.robot_ids),
        estimates,
        np.array([(victim.x_m, victim.y_m) for victim in simulation.victims]).reshape(-1, 2),
    )


def _observable(simulation: Simulation) -> Mask:
    config = simulation.config
    return observable(simulation.world, config.agent_config.body.radius_m, config.laser.range_max_m)


def _result(simulation: Simulation, robot_id: str, log: _Log, report: AgentUpdate) -> RobotResult:
    index = simulation.index[robot_id]
    count = len(log.stamps_s)
    return RobotResult(
        robot_id=robot_id,
        start=simulation.starts[index],
        world_from_map=simulation.world_from_map(robot_id),
        stamps_s=np.array(log.stamps_s),
        poses=_rows(log.poses),
        truths=np.array([poses[index] for poses in simulation.track[:count]]).reshape(-1, 3),
        anchors=np.array(log.anchors, dtype=np.int64),
        anchors_from_base=_rows(log.anchors_from_base),
        steps_s=np.array(log.steps_s),
        with_scan=np.array(log.with_scan, dtype=bool),
        report=report,
        distance_m=simulation.driven_m(robot_id),
    )


def _rows(poses: Sequence[Pose2]) -> Array:
    return np.array([(pose.x, pose.y, pose.theta) for pose in poses]).reshape(-1, 3)
