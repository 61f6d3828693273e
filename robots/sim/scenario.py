"""What a simulated mission is made of: the map, the team, its sensors, and everything that goes wrong."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from math import isfinite
from pathlib import Path
from typing import Literal, get_args, get_type_hints

import numpy as np

from robots.config import AgentConfig, OdometryConfig, RadioConfig
from robots.estimation.radio.model import ENVIRONMENTS, TagHardware, radio_for
from robots.exploration.methods import KNOWN
from robots.overrides import override
from robots.sim.generate import generate
from robots.sim.hostile import HostileConfig, make_hostile
from robots.sim.map_files import load_map
from robots.sim.per_robot import Pairs, check_pairs, chosen_for
from robots.sim.per_robot import ScenarioError as ScenarioError
from robots.sim.sensors import HeatConfig, LaserConfig
from robots.sim.starts import StartKind
from robots.sim.tags import link_of
from robots.sim.wheels import NOISE_LEVELS, data_sheet
from robots.sim.world import World
from robots.tags.chip import CHIPS, Chip, chip_of, format_chip
from robots.tags.memory import room_for_maps
from robots.tags.record import content_bytes
from robots.tags.sealed import room_in

ODOMETRY_HZ = 20
MAX_ROBOTS = 100
START_SD_M, START_SD_RAD = 0.05, 0.02  # how well the starts are surveyed
SLAM_KINDS: tuple[str, ...] = get_args(get_type_hints(AgentConfig)["slam"])
FLOOR_SLAM = frozenset({"tag-graph", "odometry"})  # their robots have an antenna over the floor
_LONG_ID = 8  # characters of a tag's id; longer ones take of the memory's room
TAG_BITS: dict[TagHardware, int] = {"near": 2048, "uhf": 2048, "node": 96_000}


@dataclass(frozen=True, slots=True)
class RadioCut:
    """A time in which nothing gets to or from one robot."""

    robot_id: str
    start_s: float
    end_s: float


def is_cut(cuts: Sequence[RadioCut], clock_s: float) -> bool:
    """Return whether one of the cuts covers this moment."""
    return any(cut.start_s <= clock_s < cut.end_s for cut in cuts)


@dataclass(frozen=True, slots=True)
class SilenceConfig:
    """What a robot led by the server does when it hears nothing: stand still after so long, or go on."""

    after_s: float = 2.0
    policy: Literal["hold", "go_on"] = "hold"


@dataclass(frozen=True, slots=True)
class ScenarioConfig:
    """A scenario. The same scenario gives the same mission, bit for bit.

    ``map`` is a map_server YAML file, ``office:AREA`` or ``open:AREA``. With ``poses="truth"`` odometry and
    IMU are exact. ``agent_config`` is what every robot's agent is told; ``agent_of`` completes it. Compasses
    are off by a constant each, up to ``compass_off_rad`` to either side.

    ``tags``: the hardware of the tags, those ``tags_in_place`` at the start (N01, N02, ...) and those that
    robots drop. Radio tags are heard in ``environment``, or as ``measured_radio`` says where there is one;
    robots with SLAM over the floor's tags also read the chip of a tag that they drive over. ``slam``,
    ``explore``, ``coordinate``, ``communication``: pairs of a robot's name, or ``OTHERS``, and its kind;
    ``tag_bits`` None: as much memory as such tags have.
    ``team_radio_m``: how far robots that talk by radio hear each other in the open.
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
    tags: TagHardware = "near"
    environment: str = "open"
    measured_radio: RadioConfig | None = None
    tags_in_place: int = 0
    tag_bits: int | None = None
    base_tag: bool = True
    team_radio_m: float = 20.0
    slam: Pairs = ()
    explore: Pairs = ()
    coordinate: Pairs = ()
    communication: Pairs = ()
    agent_config: AgentConfig = field(default_factory=AgentConfig)

    def __post_init__(self) -> None:
        """Refuse what cannot be played. Raises ScenarioError."""
        _known("tags", self.tags, get_args(TagHardware))
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
        _within("tag_bits", self.memory_bits, 0, 1_000_000)
        if self.tags == "near" and self.memory_bits not in (0, *CHIPS):
            known = ", ".join(map(str, CHIPS))
            raise ScenarioError(f"tag_bits: no chip has {self.memory_bits}; use 0 for no memory, or {known}")
        if self.agent_config.map_memory and self.tag_room_bytes < room_for_maps():
            raise ScenarioError(
                f"tag_bits: {self.memory_bits} leave no room for maps beside coverage; use 7104 or more"
            )
        _within("team_radio_m", self.team_radio_m, 0.1, 10_000.0)
        _within("tags_in_place", self.tags_in_place, 0, 2000)
        _known("environment", self.environment, tuple(ENVIRONMENTS))
        _within("sonars", self.sonars, 0, 64)
        _within("infrareds", self.infrareds, 0, 64)
        _within("silence.after_s", self.silence.after_s, 0.0, 3600.0)
        for name in HostileConfig.__slots__:
            _within(f"hostile.{name}", getattr(self.hostile, name), 0, 1000)
        for choice, names in (("slam", SLAM_KINDS), *KNOWN.items()):
            check_pairs(choice, getattr(self, choice), names, self.robot_ids)
        for _, kind in self.slam:
            if self.tags == "near" and kind not in FLOOR_SLAM:
                raise ScenarioError(f"slam: {kind} needs tags that are heard by radio; use tags uhf or node")
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
    def memory_bits(self) -> int:
        """How much a tag holds."""
        return TAG_BITS[self.tags] if self.tag_bits is None else self.tag_bits

    @property
    def chip(self) -> Chip | None:
        """The chip of a near-field tag; None for others, and for one with an id alone."""
        return chip_of(self.memory_bits) if self.tags == "near" and self.memory_bits else None

    @property
    def tag_room_bytes(self) -> int:
        """How much content a tag has room for."""
        if self.chip is None:
            return room_in(self.memory_bits)
        return content_bytes(self.chip, format_chip(self.chip, link_of("0" * _LONG_ID))[1])

    @property
    def radio(self) -> RadioConfig | None:
        """The radio of the tags, None where they have none."""
        if self.tags == "near":
            return None
        return self.measured_radio or radio_for(self.tags, self.environment)

    def agent_of(self, robot_id: str) -> AgentConfig:
        """Return what a robot's agent is told.

        Its kind of SLAM, the radio it carries, and the data sheet of its wheels unless told otherwise.
        """
        kind = chosen_for(self.slam, robot_id, self.agent_config.slam)
        usual = self.agent_config.planning
        methods = {name: chosen_for(getattr(self, name), robot_id, getattr(usual, name)) for name in KNOWN}
        radio = self.agent_config.radio
        if self.radio is not None and radio == RadioConfig():
            radio = self.radio
        told = override(self.agent_config, {"slam": kind, "planning": methods})
        memory = replace(told.tag_memory, room_bytes=self.tag_room_bytes)
        config = replace(told, poses=self.poses, seed=self.seed, radio=radio, tag_memory=memory)
        if self.poses == "truth" or self.noise_level == 0 or config.odometry != OdometryConfig():
            return config
        return replace(config, odometry=data_sheet(self.noise_level, config.body.track_width_m))


def _known(name: str, value: str, known: tuple[str, ...]) -> None:
    if value not in known:
        raise ScenarioError(f"{name}: {value!r} is unknown; use one of {', '.join(known)}")


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
