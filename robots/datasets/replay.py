"""Running agents over a recording, as fast as they go, and solving their map at the end."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Any

import numpy as np

from robots.agent import ObservationError, RobotAgent
from robots.config import AgentConfig
from robots.datasets.recording import Recording
from robots.estimation.ranges.views import as_sightings
from robots.graph_report import GraphReport
from robots.overrides import override
from robots.se2 import Array
from robots.team import TeamMap, TeamRobot, TeamUpdate
from robots.trajectory import Trajectory, TrajectoryStep, edges_of, final_trajectory
from robots.types import AgentUpdate, Observation

_ROOM_BYTES = 12_000  # of a tag in a recording, with --memory: as much as an active node has


@dataclass(frozen=True, slots=True, eq=False)
class RobotReplay:
    """One robot's day: estimates as they were made and after the last solve, on the recording's own clock."""

    robot_id: str
    online: Trajectory
    final: Trajectory
    distance_m: float
    observations: int
    refused: int  # that the agent could not take
    sightings: int
    step_s: Array  # (n,) time each step took


@dataclass(frozen=True, slots=True, eq=False)
class ReplayResult:
    """What agents made of a recording."""

    robots: tuple[RobotReplay, ...]
    team: TeamUpdate


def replay(
    recording: Recording,
    on_step: Callable[[], None] = lambda: None,
    robots: Sequence[str] | None = None,
    changes: dict[str, Any] | None = None,
    on_update: Callable[[str, AgentUpdate], None] = lambda robot_id, update: None,
    memory: bool = False,
    robot_sightings: bool = True,
) -> ReplayResult:
    """Run an agent per robot over the recording.

    Args:
        recording: what they observed.
        on_step: called after each observation.
        robots: who takes part, in the order in which they go through the recording; None for all.
        changes: overrides of ``AgentConfig`` beside the recording's own.
        on_update: called with each update that an agent makes.
        memory: tags keep what robots write into them, for themselves and for those that come later.
        robot_sightings: whether robots see each other.

    Raises:
        ConfigError: one of the overrides is no setting, or out of range.
        ObservationError: an agent cannot take a single observation.
        RecordingError: the recording turns out to be damaged.
    """
    chosen = recording.robots if robots is None else robots
    if not chosen:
        raise ValueError("there is no robot to replay")
    days = []
    tags = TagMemories(memory)
    if memory:
        changes = {"tag_memory": {"room_bytes": _ROOM_BYTES}, **(changes or {}), "map_memory": True}
    configs = [
        override(override(AgentConfig(), recording.settings_of(name)), changes or {}) for name in chosen
    ]
    team = TeamMap(configs[0].mapping.resolution_m)
    for robot_id, config in zip(chosen, configs, strict=True):
        team.add_robot(robot_id, recording.start_pose(robot_id))
        observations = (
            tags.read(o if robot_sightings else replace(o, robot_sightings=()))
            for o in recording.observations(robot_id)
        )

        def keep(robot_id: str, update: AgentUpdate) -> None:
            tags.write(update)
            # where it was and when: others may have seen it there
            team.put(robot_id, replace(update, graph=None, submaps=(), victims=()))
            on_update(robot_id, update)

        stamps_s = recording.stamps_s(robot_id)
        day = _Day(robot_id, zip(stamps_s, observations, strict=True), config, on_step, keep)
        team.put(robot_id, _without_loops(day.last) if config.slam == "odometry" else day.last)
        days.append(day)
    solved = team.solve()
    by_id = {robot.robot_id: robot for robot in solved.robots}
    return ReplayResult(tuple(day.result(by_id[day.robot_id]) for day in days), solved)


class TagMemories:
    """What stands in the tags of a recording whose own tags had no memory: what our robots wrote there."""

    def __init__(self, kept: bool) -> None:
        self._memories: dict[str, bytes] | None = {} if kept else None

    def read(self, observation: Observation) -> Observation:
        """Return the observation with the tags' memories in its sightings."""
        memories = self._memories
        if not memories or not observation.tag_sightings:
            return observation
        sightings = tuple(
            replace(sighting, memory=memories.get(sighting.tag_id, sighting.memory))
            for sighting in observation.tag_sightings
        )
        return replace(observation, tag_sightings=sightings)

    def write(self, update: AgentUpdate) -> None:
        """Take in what an agent wants written into tags."""
        if self._memories is not None:
            self._memories |= {write.tag_id: write.memory for write in update.command.writes}


class _Day:
    def __init__(
        self,
        robot_id: str,
        observations: Iterable[tuple[float, Observation]],
        config: AgentConfig,
        on_step: Callable[[], None],
        on_update: Callable[[str, AgentUpdate], None],
    ) -> None:
        agent = RobotAgent(robot_id, config)
        self.robot_id = robot_id
        self._slam = config.slam
        self._refused = 0
        self._steps: list[TrajectoryStep] = []
        self._online: list[Array] = []
        self._step_s: list[float] = []
        self._sightings = 0
        for stamp, observation in observations:
            self._sightings += len(observation.tag_sightings)
            began = perf_counter()
            try:
                update = agent.step(observation)
            except ObservationError:  # as mission control does: the agent is unchanged and goes on
                self._refused += 1
            else:
                self._step_s.append(perf_counter() - began)
                self._keep(float(stamp), update)
                on_update(robot_id, update)
            on_step()
        self.last = agent.smoothed()

    def _keep(self, stamp_s: float, update: AgentUpdate) -> None:
        self._steps.append(TrajectoryStep(stamp_s, update.anchor, update.anchor_from_base))
        self._online.append(update.pose.as_array())

    def result(self, solved: TeamRobot) -> RobotReplay:
        graph = self.last.graph
        edges = edges_of(graph) if graph is not None else {}
        anchors = graph.poses if graph is not None and self._slam == "odometry" else solved.anchors
        return RobotReplay(
            robot_id=self.robot_id,
            online=Trajectory(
                np.array([step.stamp_s for step in self._steps]), np.array(self._online).reshape(-1, 3)
            ),
            final=final_trajectory(self._steps, anchors, edges),
            distance_m=self.last.distance_m,
            observations=len(self._steps) + self._refused,
            refused=self._refused,
            sightings=self._sightings,
            step_s=np.array(self._step_s),
        )


def _without_loops(update: AgentUpdate) -> AgentUpdate:
    """Return the update with a graph that only places each tag where it was first seen."""
    if update.graph is None:
        return update
    graph = as_sightings(update.graph)
    _, first = np.unique(graph.sighting_pairs[:, 1], return_index=True)
    return replace(
        update,
        graph=GraphReport(
            poses=graph.poses,
            stamps_s=graph.stamps_s,
            yaws_rad=np.full(len(graph.poses), np.nan),
            tag_ids=graph.tag_ids,
            tags=graph.tags,
            edge_pairs=graph.edge_pairs,
            edge_poses=graph.edge_poses,
            edge_covariances=graph.edge_covariances,
            sighting_pairs=graph.sighting_pairs[first],
            sighting_offsets=graph.sighting_offsets[first],
            sighting_covariances=graph.sighting_covariances[first],
        ),
    )
