"""A scenario at work: bodies, sensors, tags and victims in one world, advanced by control periods.

A period is a few odometry ticks; every tick yields one Observation per robot, the last of a period carries
the laser. Each robot and each of its sensors has a random stream of its own, so that robots do not disturb
one another's.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from robots.config import AgentConfig
from robots.se2 import Array, Pose2
from robots.sim.body import Bodies, Motion
from robots.sim.channel import Channel
from robots.sim.node_life import NodeLife
from robots.sim.receivers import Receiver
from robots.sim.scenario import FLOOR_SLAM, ODOMETRY_HZ, ScenarioConfig, build_world
from robots.sim.sensors import Laser, Ring, ThermalCamera, others_near
from robots.sim.starts import Victim, place_robots, place_tags, place_victims
from robots.sim.tags import BASE_TAG, Magazine, Reader, TagField
from robots.sim.team_radio import TeamRadio
from robots.sim.wheels import Imu, Wheels
from robots.sim.world import Cells, World
from robots.types import (
    Command,
    Displacement,
    HeatReading,
    LaserScan,
    Observation,
    Odometry,
    RangeReading,
    TagSighting,
)

IDLE_LIFE_S = 7200.0  # a battery lasts so long standing still,
DRIVE_LIFE_M = 2500.0  # or so far driving
_STREAMS = 5


@dataclass(frozen=True, slots=True)
class Order:
    """What a robot is told for one control period.

    ``held`` (STOP, or radio silence) overrides the command's motion.
    """

    command: Command = field(default_factory=Command)
    held: bool = False


class _Robot:
    """What one robot carries."""

    def __init__(
        self, config: ScenarioConfig, world: World, index: int, magazine: int, track_m: float
    ) -> None:
        robot_id = config.robot_ids[index]
        exact = config.poses == "truth"
        streams = [np.random.default_rng([config.seed, 10 + stream, index]) for stream in range(_STREAMS)]
        self.wheels = Wheels(0 if exact else config.noise_level, track_m, streams[0])
        off = config.compass_off_rad * np.random.default_rng([config.seed, 20, index]).uniform(-1.0, 1.0)
        self.imu = Imu(world, exact, streams[1], float(off)) if config.imu else None
        self.laser = Laser(world, config.laser, streams[2])
        self.camera = ThermalCamera(world, config.heat, streams[3])
        self.ring = Ring(world, config.sonars, config.infrareds, streams[4])
        self.magazine = Magazine(robot_id, magazine)
        floor_antenna = config.tags == "near" or config.agent_of(robot_id).slam in FLOOR_SLAM
        self.reader = Reader() if floor_antenna else None
        self.radio: Receiver | None = None
        self.battery = 1.0
        self.driven_m = 0.0
        self.order = Order()
        self.seq = 0

    def reaches(self, tag: int) -> bool:
        """Return whether the robot's radio reaches the tag of this index."""
        return self.radio is not None and self.radio.reaches(tag)


class Simulation:
    """A scenario being played. ``apply`` orders, then ``advance`` one period.

    ``seen`` marks what the lasers truly saw.
    """

    def __init__(self, config: ScenarioConfig) -> None:
        """Build the world and put everything in its place. Raises WorldError or ScenarioError."""
        self.config = config
        self.world = build_world(config)
        body, antenna = config.agent_config.body, config.agent_config.antenna
        self._radius_m = body.radius_m
        self._antenna_ahead_m = antenna.ahead_m
        starts = place_robots(
            self.world, config.robots, body.radius_m, config.start, np.random.default_rng([config.seed, 3])
        )
        self.starts = tuple(Pose2.from_array(row) for row in starts)
        self.victims: tuple[Victim, ...] = place_victims(
            self.world, config.victims, body.radius_m, starts[:, :2], np.random.default_rng([config.seed, 4])
        )
        self._victims_m = np.array([(victim.x_m, victim.y_m) for victim in self.victims]).reshape(-1, 2)
        self.bodies = Bodies(self.world, starts, body, antenna)
        self.tags = TagField(config.memory_bits, config.chip)
        if config.base_tag:
            self.tags.drop(BASE_TAG, *self._antenna(0))
        self.life = _lay_tags(config, self.world, self.tags, body.radius_m)
        magazine = config.agent_config.deployment.magazine
        self._robots = [
            _Robot(config, self.world, index, magazine, body.track_width_m) for index in range(config.robots)
        ]
        self._give_radios()
        self.team_radio = TeamRadio(config, self.world, self._antenna(0))
        self.seen: Cells = np.zeros_like(self.world.cells)
        self.track: list[Array] = []  # true poses, (n, 3), at each tick

    @property
    def ticks(self) -> int:
        """Odometry ticks played so far."""
        return len(self.track)

    @property
    def clock_s(self) -> float:
        """Time since the start of the mission in seconds."""
        return self.ticks / ODOMETRY_HZ

    @cached_property
    def index(self) -> Mapping[str, int]:
        """Position of each robot id in the team."""
        return {robot_id: index for index, robot_id in enumerate(self.config.robot_ids)}

    def truth(self, robot_id: str) -> Pose2:
        """Return a robot's true pose in the world frame."""
        return self.bodies.pose(self.index[robot_id])

    def world_from_map(self, robot_id: str) -> Pose2:
        """Return where the map frame of a robot lies: at its start, north up where an IMU knows north."""
        index = self.index[robot_id]
        start, imu = self.starts[index], self._robots[index].imu
        return start if imu is None else Pose2(start.x, start.y, -imu.off_rad)

    def agent_of(self, robot_id: str) -> AgentConfig:
        """Return what a robot's agent is told, its surveyed start with it."""
        start = self.starts[self.index[robot_id]]
        return replace(self.config.agent_of(robot_id), start=(start.x, start.y, start.theta))

    def driven_m(self, robot_id: str) -> float:
        """Return the true distance a robot has driven."""
        return self._robots[self.index[robot_id]].driven_m

    def apply(self, orders: Mapping[str, Order]) -> None:
        """Take the orders for the next period: writes and drops happen now, in the order of the team."""
        for index, robot_id in enumerate(self.config.robot_ids):
            order = orders.get(robot_id)
            if order is None:
                continue
            robot = self._robots[index]
            robot.order = order
            x, y = self._antenna(index)
            if order.command.say is not None:
                self.team_radio.say(index, order.command.say, self.bodies.poses, self.clock_s)
            for write in order.command.writes:
                self.tags.write(write.tag_id, write.memory, x, y, robot.reaches)
            if order.command.drop_tag and not order.held:
                tag_id = robot.magazine.take()
                if tag_id is not None:
                    self.tags.drop(tag_id, x, y)

    def advance(self) -> dict[str, tuple[Observation, ...]]:
        """Play one control period under the orders applied and return each robot's observations of it."""
        batches: list[list[Observation]] = [[] for _ in self._robots]
        for tick in range(self.config.ticks_per_period):
            before = [self.bodies.pose(index) for index in range(len(self._robots))]
            motion = self.bodies.tick(self._velocities(), self.tags.places_m, 1.0 / ODOMETRY_HZ)
            self.track.append(self.bodies.poses.copy())
            self.life.advance(self.clock_s)
            with_scan = tick == self.config.ticks_per_period - 1
            for index, batch in enumerate(batches):
                batch.append(self._observe(index, before[index], motion, with_scan))
        return {
            robot_id: tuple(batch) for robot_id, batch in zip(self.config.robot_ids, batches, strict=True)
        }

    def _velocities(self) -> Array:
        """Return the commanded velocities, (n, 2); nothing moves when held or without power."""
        return np.array(
            [
                (0.0, 0.0)
                if robot.order.held or robot.battery <= 0.0
                else (robot.order.command.linear_mps, robot.order.command.angular_radps)
                for robot in self._robots
            ]
        )

    def _observe(self, index: int, before: Pose2, motion: Motion, with_scan: bool) -> Observation:
        robot, pose = self._robots[index], self.bodies.pose(index)
        dt_s = 1.0 / ODOMETRY_HZ
        driven = float(motion.driven_m[index])
        robot.driven_m += driven
        robot.battery = max(0.0, robot.battery - dt_s / IDLE_LIFE_S - driven / DRIVE_LIFE_M)
        speed, turn = float(motion.speeds[index, 0]), float(motion.speeds[index, 1])
        odometry: Odometry = robot.wheels.read(speed, turn, dt_s, float(motion.grip[index]))
        if self.config.poses == "truth":
            moved = before.between(pose)
            odometry = Displacement(moved.x, moved.y, moved.theta)
        seq, robot.seq = robot.seq, robot.seq + 1
        scan: LaserScan | None = None
        beams: tuple[RangeReading, ...] = ()
        heat: tuple[HeatReading, ...] = ()
        if with_scan:
            reach = self.config.laser.range_max_m + self._radius_m
            others = others_near(self.bodies.poses, index, reach)
            scan = robot.laser.scan(pose, others, self._radius_m, self.seen)
            beams = robot.ring.read(pose, others, self._radius_m)
            heat = robot.camera.look(pose, self._victims_m, self.config.period_s)
        return Observation(
            seq=seq,
            stamp_s=self.clock_s,
            odometry=odometry,
            imu=robot.imu.read(pose.x, pose.y, pose.theta, dt_s) if robot.imu is not None else None,
            scan=scan,
            beams=beams,
            tag_sightings=self._tags_read(robot, pose, motion.read[index]),
            heat=heat,
            battery=robot.battery,
            tags_left=robot.magazine.left,
            bumper=bool(motion.pressed[index]),
            held=robot.order.held,
            heard=self.team_radio.take(index, self.bodies.poses, self.clock_s),
        )

    def _tags_read(self, robot: _Robot, pose: Pose2, under: NDArray[np.bool_]) -> tuple[TagSighting, ...]:
        read: tuple[TagSighting, ...] = ()
        if robot.reader is not None:
            read = robot.reader.sightings(self.tags, under, self.clock_s)
        if robot.radio is not None:
            read += robot.radio.sightings(pose, self.clock_s, 1.0 / ODOMETRY_HZ)
        return read

    def _give_radios(self) -> None:
        config, radio = self.config, self.config.radio
        if radio is None:
            return
        channel = Channel(self.world, self.tags, config.tags, radio, config.seed)
        for index, robot in enumerate(self._robots):
            rng = np.random.default_rng([config.seed, 10 + _STREAMS, index])
            robot.radio = Receiver(channel, self.tags, self.life, config.hostile.spikes / 1000.0, rng)

    def _antenna(self, index: int) -> tuple[float, float]:
        """Return where the middle of a robot's antenna is over the floor, in the world frame."""
        return self.bodies.pose(index).transform_point(self._antenna_ahead_m, 0.0)


def _lay_tags(config: ScenarioConfig, world: World, field: TagField, radius_m: float) -> NodeLife:
    """Lay down the tags that are in place at the start."""
    placing, living = np.random.default_rng([config.seed, 5]).spawn(2)
    places = place_tags(world, config.tags_in_place, radius_m, placing)
    return NodeLife(world, field, places, config.hostile, radius_m, 60.0 * config.minutes, living)
