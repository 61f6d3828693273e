"""What a simulated mission is made of: the map, the team, its sensors, and everything that goes wrong."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import isfinite
from pathlib import Path
from typing import Literal

import numpy as np

from robots.config import AgentConfig, OdometryConfig
from robots.sim.generate import generate
from robots.sim.hostile import HostileConfig, make_hostile
from robots.sim.map_files import load_map
from robots.sim.sensors import HeatConfig, LaserConfig
from robots.sim.starts import StartKind
from robots.sim.wheels import NOISE_LEVELS, data_sheet
from robots.sim.world import World

ODOMETRY_HZ = 20
MAX_ROBOTS = 100
START_SD_M, START_SD_RAD = 0.05, 0.02  # how well the starts are surveyed


class ScenarioError(ValueError):
    """A scenario cannot be played; the message names the field and what to do."""


@dataclass(frozen=True, slots=True)
class RadioCut:
    """A time in which nothing gets to or from one robot."""

    robot_id: str
    start_s: float
    end_s: float


@dataclass(frozen=True, slots=True)
class SilenceConfig:
    """What a robot led by the server does when it hears nothing: stand still after so long, or go on."""

    after_s: float = 2.0
    policy: Literal["hold", "go_on"] = "hold"


@dataclass(frozen=True, slots=True)
class ScenarioConfig:
    """A scenario. The same scenario gives the same mission, bit for bit.

    ``map`` is a map_server YAML file, ``office:AREA`` or ``open:AREA``. With ``poses="truth"`` odometry and
    IMU are exact. ``agent_config`` is what every robot's agent is told; ``agent_for`` completes it. Compasses
    are off by a constant each, up to ``compass_off_rad`` to either side.
    """

    map: str = "office:300"
    robots: int = 4
    minutes: float = 20.0
    seed: int = 0
    poses: Literal["slam", "truth"] = "slam"
    slip: bool = False
    noise_level: int = 3
    victims: int = 4
    start: StartKind = "same"
    agent: Literal["server", "onboard"] = "server"
    radio_cuts: tuple[RadioCut, ...] = ()
    silence: SilenceConfig = field(default_factory=SilenceConfig)
    laser: LaserConfig = field(default_factory=LaserConfig)
    laser_hz: float = 5.0
    heat: HeatConfig = field(default_factory=HeatConfig)
    hostile: HostileConfig = field(default_factory=HostileConfig)
    imu: bool = True
    compass_off_rad: float = 0.0
    sonars: int = 0
    infrareds: int = 0
    tag_bits: int = 2048
    base_tag: bool = True
    agent_config: AgentConfig = field(default_factory=AgentConfig)

    def __post_init__(self) -> None:
        """Refuse what cannot be played. Raises ScenarioError."""
        _within("robots", self.robots, 1, MAX_ROBOTS)
        _within("minutes", self.minutes, 0.0, 24 * 60.0)
        _within("seed", self.seed, 0, 2**63 - 1)
        _within("noise_level", self.noise_level, 0, len(NOISE_LEVELS) - 1)
        _within("victims", self.victims, 0, 1000)
        _within("laser.beams", self.laser.beams, 1, 4096)
        _within("laser.range_max_m", self.laser.range_max_m, 0.1, 200.0)
        _within("laser.field_of_view_rad", self.laser.field_of_view_rad, 0.01, 2.0 * np.pi)
        _within("laser.sd_m", self.laser.sd_m, 0.0, 1.0)
        _within("laser_hz", self.laser_hz, 0.5, ODOMETRY_HZ)
        _within("compass_off_rad", self.compass_off_rad, 0.0, np.pi)
        _within("tag_bits", self.tag_bits, 0, 1_000_000)
        _within("sonars", self.sonars, 0, 64)
        _within("infrareds", self.infrareds, 0, 64)
        _within("silence.after_s", self.silence.after_s, 0.0, 3600.0)
        for name, count in (
            ("glass", self.hostile.glass),
            ("bricks", self.hostile.bricks),
            ("smoke", self.hostile.smoke),
            ("ramps", self.hostile.ramps),
            ("slippery", self.hostile.slippery),
        ):
            _within(f"hostile.{name}", count, 0, 1000)
        for cut in self.radio_cuts:
            if cut.robot_id not in self.robot_ids:
                raise ScenarioError(
                    f"radio_cuts: there is no robot {cut.robot_id}; robots are r1 to r{self.robots}"
                )
            if not cut.start_s < cut.end_s:
                raise ScenarioError(f"radio_cuts: the cut of {cut.robot_id} has to end after it starts")

    @property
    def robot_ids(self) -> tuple[str, ...]:
        """Names of the team: r1, r2, ..."""
        return tuple(f"r{index + 1}" for index in range(self.robots))

    @property
    def ticks_per_period(self) -> int:
        """Odometry ticks in one control period, which is one laser period."""
        return max(1, round(ODOMETRY_HZ / self.laser_hz))

    @property
    def period_s(self) -> float:
        """Length of a control period in seconds."""
        return self.ticks_per_period / ODOMETRY_HZ

    @property
    def periods(self) -> int:
        """Control periods in the whole mission."""
        return round(self.minutes * 60.0 / self.period_s)

    @property
    def agent_for(self) -> AgentConfig:
        """What its agents are told: with the data sheet of their wheels, unless told otherwise."""
        config = replace(self.agent_config, poses=self.poses, seed=self.seed)
        if self.poses == "truth" or self.noise_level == 0 or config.odometry != OdometryConfig():
            return config
        return replace(config, odometry=data_sheet(self.noise_level, config.body.track_width_m))


def _within(name: str, value: float, low: float, high: float) -> None:
    if not isfinite(value) or not low <= value <= high:
        raise ScenarioError(f"{name} {value:g} is out of range; give {low:g} to {high:g}")


def build_world(config: ScenarioConfig) -> World:
    """Return the scenario's world, hostile things included.

    Raises:
        WorldError: the map cannot be read, generated or driven in.
    """
    kind, _, area = config.map.partition(":")
    if area and not config.map.endswith((".yaml", ".yml")):
        try:
            area_m2 = float(area)
        except ValueError:
            raise ScenarioError(f"map {config.map!r}: after {kind}: give the area in square metres") from None
        world = generate(kind, area_m2, np.random.default_rng([config.seed, 1]))
    else:
        world = load_map(Path(config.map))
    hostile = config.hostile
    if config.slip and hostile.slippery == 0:
        hostile = replace(hostile, slippery=max(1, min(1000, round(world.free_area_m2 / 40.0))))
    return make_hostile(world, hostile, np.random.default_rng([config.seed, 2]))
