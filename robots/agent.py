"""The agent: the algorithm of Kleiner 2006, one observation at a time.

``RobotAgent.step`` reads like the paper: predict from wheels and inertial unit, match the scan, fuse, map,
handle tags, look for victims, decide where to go, drop tags, answer with a command. It is a function of the
configuration and the log, nothing else.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import isfinite
from zlib import crc32

import numpy as np

from robots.config import AgentConfig
from robots.estimation.tag_graph import TagGraph
from robots.estimation.tracking import PoseTracker
from robots.exploration.explorer import Decision, Explorer
from robots.mapping.map_keeper import MapKeeper
from robots.planning.plan_grid import plan_grid
from robots.se2 import GaussianPose, Pose2
from robots.snapshot import freeze, thaw
from robots.tags.deployment import TagDropper
from robots.tags.memory import TagMemoryError, decode_memory, encode_memory, observed_memory
from robots.types import AgentUpdate, Command, Observation, RobotSighting, TagSighting, TagWrite
from robots.victims import VictimTracker

_SAME_PASS_M = 0.4  # a tag read again within so much driving is the same pass


class ObservationError(ValueError):
    """The observation cannot follow what this agent has seen; the agent is unchanged."""


class RobotAgent:
    """Localises, maps and explores for one robot.

    Raises:
        ConfigError: a setting of ``config`` names something that does not exist.
    """

    def __init__(self, robot_id: str, config: AgentConfig) -> None:
        self.robot_id = robot_id
        self.config = config
        own = crc32(robot_id.encode())  # robots told the same seed must not draw alike
        self._explorer = Explorer(config, (config.seed, own, 1))
        self._dropper = TagDropper(config.deployment, config.mapping, (config.seed, own, 2))
        self._victims = VictimTracker(robot_id, config.victims)
        self._maps = MapKeeper(config.mapping)
        self._tracker: PoseTracker | None = None
        self._graph: TagGraph | None = None
        self._last: Observation | None = None
        self._last_tag: tuple[str, float] | None = None  # id, way driven when it was read
        self._anchor_driven_m = 0.0
        self._decision = Decision(0.0, 0.0, "starting", "waiting for the first scan")
        self._update: AgentUpdate | None = None

    def step(self, observation: Observation) -> AgentUpdate:
        """Take in one observation and answer with the estimate and the next command.

        Raises:
            ObservationError: sequence number or stamp out of order, or a value that is not finite; nothing
                has changed then.
        """
        self._check(observation)
        # what was driven before the first observation is not part of the map
        odometry = observation.odometry if self._last is not None else None
        tracker, graph = self._start(observation)
        # pressed against something, the wheels turn on the spot
        slipping = observation.bumper and self.config.poses == "slam"
        tracker.predict(observation.stamp_s, odometry, observation.imu, slipping)  # (1), (2)
        if observation.scan is not None:
            tracker.match(observation.scan)  # (3), (4)
            self._maps.add_scan(tracker.local_from_base, observation.scan)
        passed = self._pass_tags(observation, tracker, graph)  # (5)
        pose = graph.poses[-1] @ tracker.anchor_from_base.mean
        victims = [
            self._victims.see(reading, observation.stamp_s, pose, graph.newest, graph.poses)
            for reading in observation.heat
        ]
        drop = False
        if observation.scan is not None:
            if self._explorer.plan_is_due(observation.stamp_s):
                self._maps.draw(graph.poses)
            self._decision = self._decide(observation, pose)
            drop = self._drop(observation, pose, graph)
        writes = tuple(self._writes(sighting, pose, graph) for sighting in passed)
        command = Command(
            self._decision.linear_mps,
            self._decision.angular_radps,
            drop,
            tuple(w for w in writes if w is not None),
        )
        self._last = observation
        self._update = self._report(observation, tracker, graph, command, slipping, bool(passed))
        return replace(self._update, victims=tuple(v for v in victims if v is not None))

    def report(self) -> AgentUpdate:
        """Return the latest update with the whole graph, all submaps and all victims.

        Raises:
            ObservationError: nothing has been observed yet.
        """
        if self._update is None or self._graph is None:
            raise ObservationError("the agent has not observed anything yet")
        return replace(
            self._update,
            graph=self._graph.report(),
            submaps=self._maps.all_reports(),
            victims=self._victims.victims(),
        )

    def snapshot(self) -> bytes:
        """Return the whole state as bytes."""
        return freeze(self)

    @classmethod
    def restore(cls, data: bytes) -> RobotAgent:
        """Return the agent that ``snapshot`` was taken of.

        Raises:
            SnapshotError: the bytes are damaged, or not a snapshot of an agent.
        """
        return thaw(data, cls)

    def _check(self, observation: Observation) -> None:
        last = self._last
        if last is not None and observation.seq != last.seq + 1:
            raise ObservationError(f"seq {observation.seq} does not follow {last.seq}")
        if not isfinite(observation.stamp_s):
            raise ObservationError("stamp_s is not finite")
        if last is not None and observation.stamp_s < last.stamp_s:
            raise ObservationError(
                f"stamp_s {observation.stamp_s} lies before {last.stamp_s} of seq {last.seq}"
            )
        odometry = observation.odometry
        if odometry is not None:
            for name in odometry.__slots__:
                if not isfinite(getattr(odometry, name)):
                    raise ObservationError(f"odometry.{name} is not finite")
        imu = observation.imu
        if imu is not None and not all(map(isfinite, (imu.yaw_rad, imu.roll_rad, imu.pitch_rad))):
            raise ObservationError("imu holds a value that is not finite")
        for sighting in observation.tag_sightings:
            if (sighting.range_m is None) != (sighting.bearing_rad is None):
                raise ObservationError(f"sighting of {sighting.tag_id} has to have range and bearing or none")
        seen: tuple[TagSighting | RobotSighting, ...]
        seen = (*observation.tag_sightings, *observation.robot_sightings)
        if not all(isfinite(s.range_m or 0.0) and isfinite(s.bearing_rad or 0.0) for s in seen):
            raise ObservationError("a sighting holds a value that is not finite")

    def _start(self, observation: Observation) -> tuple[PoseTracker, TagGraph]:
        """Begin the map at the first observation; with an inertial unit its x axis points north."""
        if self._tracker is None or self._graph is None:
            yaw = None if observation.imu is None else observation.imu.yaw_rad
            start = Pose2(0.0, 0.0, yaw or 0.0)
            self._tracker = PoseTracker(self.config, start.theta)
            self._graph = TagGraph(self.config, start, observation.stamp_s, yaw)
            self._maps.begin(0, start, self._tracker.local_from_base, 0.0)
            self._maps.add_free(self._tracker.local_from_base, self.config.body.radius_m)
        return self._tracker, self._graph

    def _pass_tags(
        self, observation: Observation, tracker: PoseTracker, graph: TagGraph
    ) -> tuple[TagSighting, ...]:
        """Restart the filter at a tag and keep the displacement as an edge.

        The graph is solved when the tag was known.
        """
        fresh = tuple(s for s in observation.tag_sightings if self._is_new_pass(s.tag_id, tracker.distance_m))
        overdue = tracker.distance_m - self._anchor_driven_m > self.config.mapping.submap_travel_m
        if not fresh and not overdue:
            return ()
        self._add_anchor(observation, tracker, graph)
        known = False
        for sighting in fresh:
            known |= not graph.add_sighting(sighting.tag_id)
            self._last_tag = (sighting.tag_id, tracker.distance_m)
        if known and self.config.poses == "slam":
            graph.solve()
            self._explorer.replan()
        self._maps.anchored(graph.newest, graph.poses[-1], tracker.local_from_base, tracker.distance_m)
        return fresh

    def _is_new_pass(self, tag_id: str, driven_m: float) -> bool:
        last = self._last_tag
        return last is None or last[0] != tag_id or driven_m - last[1] > _SAME_PASS_M

    def _add_anchor(self, observation: Observation, tracker: PoseTracker, graph: TagGraph) -> None:
        yaw = None if observation.imu is None else observation.imu.yaw_rad
        graph.add_pose(tracker.restart(), observation.stamp_s, yaw)
        self._anchor_driven_m = tracker.distance_m

    def _decide(self, observation: Observation, pose: Pose2) -> Decision:
        unseen = observation.bumper and self._decision.linear_mps > 0.0 and self._tracker is not None
        if unseen and self._tracker is not None:
            self._maps.add_obstacle(
                self._tracker.local_from_base, self.config.body.radius_m, observation.scan
            )
        return self._explorer.decide(
            observation.stamp_s,
            pose,
            self._maps.fused,
            observation.scan,
            observation.bumper,
            observation.held,
        )

    def _drop(self, observation: Observation, pose: Pose2, graph: TagGraph) -> bool:
        self._dropper.magazine(observation.tags_left)
        if observation.held or self._tracker is None:
            return False
        places = [place for _, place in graph.tags.values()]
        return self._dropper.should_drop(self._tracker.distance_m, pose, self._maps.fused, places)

    def _writes(self, sighting: TagSighting, pose: Pose2, graph: TagGraph) -> TagWrite | None:
        """Leave in the tag what is known round it, merged with what it said.

        Needs a compass for its frame.
        """
        if self._last is None or self._last.imu is None:
            return None
        grid = plan_grid(
            self._maps.fused, self.config.body, self.config.planning, self.config.mapping, np.zeros((0, 3))
        )
        x, y = graph.tags[sighting.tag_id][1]
        try:
            said = decode_memory(sighting.memory)
        except TagMemoryError:
            return None  # a stranger's or a damaged memory is left as it is
        memory = encode_memory(said.merge(observed_memory(grid, x, y)))
        return None if memory == sighting.memory else TagWrite(sighting.tag_id, memory)

    def _report(
        self,
        observation: Observation,
        tracker: PoseTracker,
        graph: TagGraph,
        command: Command,
        slipping: bool,
        changed: bool,
    ) -> AgentUpdate:
        since_anchor = tracker.anchor_from_base
        here = GaussianPose(graph.poses[-1], graph.last_covariance) @ since_anchor
        decision = self._decision
        return AgentUpdate(
            seq=observation.seq,
            stamp_s=observation.stamp_s,
            pose=here.mean,
            covariance=here.covariance,
            anchor=graph.newest,
            anchor_from_base=since_anchor.mean,
            command=command,
            activity=decision.activity,
            reason=decision.reason,
            tags_left=self._dropper.left,
            explored_m2=self._explorer.explored_m2,
            distance_m=tracker.distance_m,
            goal_m=decision.goal_m,
            path_m=decision.path_m,
            slipping=slipping,
            graph=graph.report() if changed or self._graph_is_new(graph) else None,
            submaps=self._maps.take_reports(observation.stamp_s),
        )

    def _graph_is_new(self, graph: TagGraph) -> bool:
        return self._update is None or self._update.anchor != graph.newest


def merge_commands(updates: Sequence[AgentUpdate]) -> Command:
    """Return one command for the updates of a batch; see ``merged_command``."""
    return merged_command([update.command for update in updates])


def merged_command(commands: Sequence[Command]) -> Command:
    """Return the last velocities, every write, and a tag to drop if any command asked for one."""
    writes = tuple(write for command in commands for write in command.writes)
    return replace(commands[-1], drop_tag=any(command.drop_tag for command in commands), writes=writes)
