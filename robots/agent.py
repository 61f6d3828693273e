"""The agent: the algorithm of Kleiner 2006, one observation at a time.

``RobotAgent.step`` reads like the paper: predict from wheels and inertial unit, match the scan, fuse, map,
handle tags, look for victims, decide where to go, drop tags, answer with a command. It is a function of the
configuration and the log, nothing else.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from math import isfinite

import numpy as np

from robots.config import AgentConfig
from robots.estimation.slam import Slam, begin_slam
from robots.estimation.slip.detector import SlipDetector
from robots.estimation.slip.patches import UNKNOWN
from robots.exploration.scout import Scout, Situation
from robots.mapping.map_keeper import MapKeeper
from robots.se2 import Array
from robots.snapshot import freeze, thaw
from robots.types import AgentUpdate, Command, Observation, RobotSighting, TagSighting
from robots.victims import VictimTracker


class ObservationError(ValueError):
    """The observation cannot follow what this agent has seen; the agent is unchanged."""


class RobotAgent:
    """Localises, maps and explores for one robot.

    Raises:
        ConfigError: a setting of ``config`` names something that does not exist.
    """

    updates_digest = b""  # chain of all updates so far, where whoever encodes them keeps one

    def __init__(self, robot_id: str, config: AgentConfig) -> None:
        self.robot_id = robot_id
        self.config = config
        self._scout = Scout(robot_id, config)
        self._victims = VictimTracker(robot_id, config.victims)
        self._slip = SlipDetector(config.odometry.slip) if config.odometry.slip != "off" else None
        self._maps = MapKeeper(config.mapping)
        self._slam: Slam | None = None
        self._last: Observation | None = None
        self._update: AgentUpdate | None = None

    def step(self, observation: Observation) -> AgentUpdate:
        """Take in one observation and answer with the estimate and the next command.

        Raises:
            ObservationError: sequence number or stamp out of order, or a value that is not finite; nothing
                has changed then.
        """
        self._check(observation)
        slam = self._start(observation)
        slipping, slip_share = self._wheels_slip(observation)
        slam.predict(observation, self._last is not None, slipping, slip_share)  # (1), (2)
        if observation.scan is not None:
            slam.match(observation.scan)  # (3), (4)
            self._maps.add_scan(slam.local_from_base, observation.scan)
        passage = slam.pass_tags(observation)  # (5)
        if passage.moved:
            self._scout.replan()
        if passage.anchored:
            self._maps.anchored(slam.anchor, slam.anchors[-1], slam.local_from_base, slam.distance_m)
        pose = slam.pose
        victims = [
            self._victims.see(reading, observation.stamp_s, pose, slam.anchor, slam.anchors)
            for reading in observation.heat
        ]
        intent = self._scout.step(self._situation(observation, slam, passage.read))
        decision = intent.decision
        command = Command(decision.linear_mps, decision.angular_radps, intent.drop, intent.writes, intent.say)
        self._last = observation
        self._update = self._report(observation, slam, command, slipping, passage.changed)
        doubts = (*self._update.doubts, *intent.doubts)
        return replace(self._update, victims=tuple(v for v in victims if v is not None), doubts=doubts)

    def report(self) -> AgentUpdate:
        """Return the latest update with the whole graph, all submaps, victims and frontiers.

        Raises:
            ObservationError: nothing has been observed yet.
        """
        if self._update is None or self._slam is None:
            raise ObservationError("the agent has not observed anything yet")
        return replace(
            self._update,
            graph=self._slam.report(),
            submaps=self._maps.all_reports(),
            victims=self._victims.victims(),
            frontiers=self._scout.frontiers,
        )

    def smoothed(self) -> AgentUpdate:
        """Return the report with the graph after a batch solve: the best map, which takes seconds to make.

        Raises:
            ObservationError: nothing has been observed yet.
        """
        report = self.report()
        return report if self._slam is None else replace(report, graph=self._slam.smoothed())

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
            if sighting.bearing_rad is not None and sighting.range_m is None:
                raise ObservationError(f"sighting of {sighting.tag_id} has a bearing without a range")
            if sighting.antenna is not None and sighting.under_antenna:
                raise ObservationError(
                    f"sighting of {sighting.tag_id} names an antenna without a range or rssi"
                )
            if not isfinite(sighting.rssi_dbm or 0.0):
                raise ObservationError("a sighting holds a value that is not finite")
        seen: tuple[TagSighting | RobotSighting, ...]
        seen = (*observation.tag_sightings, *observation.robot_sightings)
        if not all(isfinite(s.range_m or 0.0) and isfinite(s.bearing_rad or 0.0) for s in seen):
            raise ObservationError("a sighting holds a value that is not finite")

    def _start(self, observation: Observation) -> Slam:
        """Begin the map at the first observation."""
        if self._slam is None:
            self._slam = begin_slam(self.robot_id, self.config, observation.stamp_s, observation.imu)
            here = self._slam.local_from_base
            self._maps.begin(0, self._slam.pose, here, 0.0)
            self._maps.add_free(here, self.config.body.radius_m)
        return self._slam

    def _wheels_slip(self, observation: Observation) -> tuple[bool, float]:
        """Say whether the wheels slip, and the share of slippage among moments like this one."""
        if self.config.poses != "slam":
            return False, UNKNOWN
        pressed = observation.bumper  # against something: the wheels turn on the spot
        if self._slip is None or observation.imu is None:
            return pressed, UNKNOWN  # with the distance the wheels' turn would be lost: worse, as measured
        told = None if self._update is None else self._update.command
        in_force = Command() if observation.held else told
        alarm = self._slip.observe(observation.stamp_s, observation.odometry, observation.imu, in_force)
        return alarm or pressed, self._slip.share

    def _situation(self, observation: Observation, slam: Slam, read: tuple[TagSighting, ...]) -> Situation:
        """Bring the map up to date where the scout needs it, and say how things stand."""
        if observation.scan is not None:
            if self._scout.plan_is_due(observation.stamp_s):
                self._maps.draw(slam.anchors)
            if observation.bumper and self._scout.decision.linear_mps > 0.0:
                self._maps.add_obstacle(slam.local_from_base, self.config.body.radius_m, observation.scan)
        last = self._last
        return Situation(
            stamp_s=observation.stamp_s,
            pose=slam.pose,
            fused=self._maps.fused,
            distance_m=slam.distance_m,
            seq=None if last is None else last.seq,
            north=last is not None and last.imu is not None,
            scan=observation.scan,
            bumper=observation.bumper,
            held=observation.held,
            battery=observation.battery,
            tags_left=observation.tags_left,
            orders=observation.orders,
            suspects=self._victims.suspects(slam.anchors),
            victims=self._victims.known(slam.anchors),
            read=read,
            heard=observation.heard,
            tag_place=partial(_place, slam),
            tag_sd_m=0.0 if self.config.poses == "truth" else _sd_m(slam.belief.covariance),
            tag_places=slam.tag_places,
            own_map=slam.own_map,
        )

    def _report(
        self, observation: Observation, slam: Slam, command: Command, slipping: bool, changed: bool
    ) -> AgentUpdate:
        here = slam.belief
        decision = self._scout.decision
        return AgentUpdate(
            seq=observation.seq,
            stamp_s=observation.stamp_s,
            pose=here.mean,
            covariance=here.covariance,
            anchor=slam.anchor,
            anchor_from_base=slam.anchor_from_base.mean,
            anchor_from_base_covariance=slam.anchor_from_base.covariance,
            command=command,
            activity=decision.activity,
            reason=decision.reason,
            tags_left=self._scout.tags_left,
            explored_m2=self._scout.explored_m2,
            distance_m=slam.distance_m,
            goal_m=decision.goal_m,
            path_m=decision.path_m,
            slipping=slipping,
            graph=slam.report() if changed or self._update is None else None,
            submaps=self._maps.take_reports(observation.stamp_s),
            doubts=slam.take_doubts(),
            frontiers=self._scout.take_frontiers(observation.stamp_s),
            orders=self._scout.explorer.order_reports(),
            methods=self._scout.explorer.errands.methods,
        )


def _sd_m(covariance: Array) -> float:
    """Return the deviation of a pose's place along its longest axis."""
    return float(np.sqrt(max(0.0, np.linalg.eigvalsh(covariance[:2, :2])[-1])))


def _place(slam: Slam, tag_id: str) -> tuple[float, float] | None:
    try:
        return slam.tag_place(tag_id)
    except KeyError:
        return None


def merge_commands(updates: Sequence[AgentUpdate]) -> Command:
    """Return one command for the updates of a batch; see ``merged_command``."""
    return merged_command([update.command for update in updates])


def merged_command(commands: Sequence[Command]) -> Command:
    """Return the last velocities and message, every write, and a tag to drop if any asked for one."""
    writes = tuple(write for command in commands for write in command.writes)
    say = next((command.say for command in reversed(commands) if command.say is not None), None)
    drop = any(command.drop_tag for command in commands)
    return replace(commands[-1], drop_tag=drop, writes=writes, say=say)
