"""Settings of an agent: nested, SI units, defaults that work.

Derived values are properties beside what they derive from.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise
from math import cos, radians, sin
from typing import Literal

from robots.exploration.settings import KleinerConfig, SafeGroundConfig, ZiparoConfig
from robots.scan_config import LoopConfig, ScanMatchConfig
from robots.tags.memory import CELLS_M


class ConfigError(ValueError):
    """A setting is unknown, of the wrong type or out of range; the message names it."""


@dataclass(frozen=True, slots=True)
class BodyConfig:
    """The robot's shape and what it can do."""

    radius_m: float = 0.22
    track_width_m: float = 0.40
    max_speed_mps: float = 0.5
    max_turn_radps: float = radians(90.0)


@dataclass(frozen=True, slots=True)
class AntennaConfig:
    """The tag reader under the robot.

    A plate along and across the heading, or a disc where ``radius_m`` is given.
    """

    ahead_m: float = 0.0  # centre of the antenna, ahead of the base
    along_m: float = 0.03
    across_m: float = 0.20
    radius_m: float | None = None

    @property
    def variances(self) -> tuple[float, float]:
        """Variance (m2) along and across the heading of a tag that lies anywhere under the antenna.

        Uniformly so (DESIGN: footprint).
        """
        if self.radius_m is not None:
            return self.radius_m**2 / 4.0, self.radius_m**2 / 4.0
        return self.along_m**2 / 12.0, self.across_m**2 / 12.0


@dataclass(frozen=True, slots=True)
class OdometryConfig:
    """Noise of the wheels (Kleiner 2006 Sigma_u).

    Standard deviations that grow with the square root of the motion.
    """

    distance_sd_per_sqrt_m: float = 0.14
    turn_sd_per_sqrt_m: float = 0.17
    turn_sd_per_sqrt_rad: float = 0.08
    slip: Literal["off", "basic", "extended"] = "extended"  # the tree that tells slippage of four wheels
    slip_sd_per_sqrt_s: float = 0.25  # of the distance (m) while the wheels slip
    lateral_sd_per_sqrt_m: float = 0.02


@dataclass(frozen=True, slots=True)
class ImuConfig:
    """Noise of the heading from the inertial unit."""

    yaw_sd_rad: float = radians(1.0)
    yaw_drift_sd_rad: float = radians(0.16)  # of a difference over a short time


@dataclass(frozen=True, slots=True)
class MappingConfig:
    """Occupancy grids."""

    resolution_m: float = 0.05
    max_range_m: float = 12.0
    hit_logodds: int = 9  # tenths
    miss_logodds: int = 4
    limit_logodds: int = 40
    submap_travel_m: float = 12.0  # a new anchor at the latest after so much driving without a tag
    report_every_s: float = 1.0

    @property
    def occupied_logodds(self) -> int:
        """Log-odds in tenths from which a cell counts as occupied (p > 0.65)."""
        return 7


@dataclass(frozen=True, slots=True)
class GraphConfig:
    """The tag graph."""

    method: Literal["gauss-newton", "linear"] = "gauss-newton"
    max_iterations: int = 20
    tag_kernel_sd: float = 3.0  # residuals of a tag beyond so many deviations lose weight (Huber)


@dataclass(frozen=True, slots=True)
class RangingConfig:
    """Tags and robots seen from afar, by range and bearing."""

    range_sd_m: float = 0.05
    range_sd_per_m: float = 0.03
    bearing_sd_rad: float = radians(1.5)
    anchor_travel_m: float = 0.25  # a sighting this far from the last anchor gets an anchor of its own
    anchor_turn_rad: float = radians(20.0)

    def covariance(self, range_m: float, bearing_rad: float) -> tuple[tuple[float, float], ...]:
        """Return the covariance (2, 2) in m2 of the place seen, in the base frame."""
        along = (self.range_sd_m + self.range_sd_per_m * range_m) ** 2
        across = (self.bearing_sd_rad * max(range_m, self.range_sd_m)) ** 2
        c, s = cos(bearing_rad), sin(bearing_rad)
        return (
            (c * c * along + s * s * across, c * s * (along - across)),
            (c * s * (along - across), s * s * along + c * c * across),
        )


@dataclass(frozen=True, slots=True)
class RadioConfig:
    """Tags heard by radio: log-distance path loss (Ziparo 2007 and Sun 2009 eq. 1).

    The defaults are Sun's active node. The shadowing's deviation is ``shadowing_sd_db``, or, where a table is
    given, ``table_sds_db`` at ``table_distances_m``, linear in between and constant beyond. The antennas are
    those of a reader with two of them, front and rear; a radio without direction has one over the base.
    """

    power_at_1m_dbm: float = -12.0  # p(d0) at d0 = 1 m
    path_loss_exponent: float = 2.0
    shadowing_sd_db: float = 4.0  # X_sigma: of the place, the same at every reading there
    table_distances_m: tuple[float, ...] = ()
    table_sds_db: tuple[float, ...] = ()
    fading_sd_db: float = 2.0  # of every reading
    reach_m: float = 35.0
    place_m: float = 0.5  # shadowing is another one after so much driving
    readings: int = 10  # that make one mean
    front_ahead_m: float = 0.2
    rear_ahead_m: float = -0.2
    cone_rad: float = radians(60.0)  # of a directional antenna

    def __post_init__(self) -> None:
        """Refuse a table that is none. Raises ConfigError."""
        distances = self.table_distances_m
        if len(distances) != len(self.table_sds_db):
            raise ConfigError("radio.table_distances_m and radio.table_sds_db have to be of one length")
        if any(b <= a for a, b in pairwise(distances)):
            raise ConfigError("radio.table_distances_m has to rise")


@dataclass(frozen=True, slots=True)
class RangeSlamConfig:
    """Range-only SLAM by particles (Sun 2009): measured = scale * true + offset of the node."""

    particles: int = 1000
    resample_below: float = 0.5  # effective sample size, as a share of the particles
    scale_sd: float = 0.1  # of the scale of all ranges, about 1
    offset_sd_m: float = 0.3  # of a node's offset, about 0
    offset_lasts_s: float = 0.0  # an offset fades and comes anew within so long; 0: it stays
    outlier_share: float = 0.02  # of the ranges, which may be anything
    outlier_reach_m: float = 20.0  # over so much
    starts_known: bool = False  # in one frame, that of all robots' maps


@dataclass(frozen=True, slots=True)
class EkfConfig:
    """EKF-SLAM over tags (Ziparo 2007)."""

    error_lasts_s: float = 10.0  # errors of ranges and bearings to one tag fade within this time
    gate_sd: float = 3.0  # sightings off by more deviations lose weight
    place_sd_m: float = 0.5  # a tag that one sighting cannot place waits until it is known this well


@dataclass(frozen=True, slots=True)
class DeploymentConfig:
    """Dropping tags (Kleiner 2006 section III)."""

    magazine: int = 100
    spacing_m: float = 4.0
    side_window_m: float = 1.5
    rate_per_m: float = 1.2  # expected drops per metre where tags are wanted most
    even_m: float = 0.0  # instead, one wherever none is known within so far (Ziparo 2007: 1 m)


@dataclass(frozen=True, slots=True)
class TagMemoryConfig:
    """What tags remember: how much, and under which seal."""

    room_bytes: int = 196  # of content in a tag of 2,048 bits, beside a link, header, checksum and seal
    key: str = ""  # of the mission, in hexadecimal digits: memories sealed with another are not believed

    def __post_init__(self) -> None:
        """Refuse a key that is none. Raises ConfigError."""
        try:
            too_long = len(self.key_bytes) > 32
        except ValueError:
            too_long = True
        if too_long:
            raise ConfigError("tag_memory.key has to be at most 64 hexadecimal digits, two for each byte")

    @property
    def key_bytes(self) -> bytes:
        """The key itself."""
        return bytes.fromhex(self.key)


@dataclass(frozen=True, slots=True)
class VictimConfig:
    """Turning heat readings into victims."""

    range_sd_m: float = 0.3
    bearing_sd_rad: float = radians(6.0)
    same_within_m: float = 1.2  # readings this near to a victim are of it
    min_sightings: int = 3  # a lone false alarm is not a victim


MAX_LOCAL_MAP_M = 40.0


@dataclass(frozen=True, slots=True)
class PlanningConfig:
    """Where to go and how."""

    cell_m: float = 0.10
    clearance_m: float = 0.05
    comfort_m: float = 0.45
    replan_every_s: float = 1.0
    explore: str = "waymark"
    coordinate: str = "none"  # how frontiers are shared out among the robots that are heard
    communication: Literal["none", "tags", "full", "radio"] = "tags"  # who is heard, see Communication
    tag_cell_m: float = CELLS_M[0]  # of the ground that is told to tags where none has told any yet
    kleiner: KleinerConfig = field(default_factory=KleinerConfig)
    ziparo: ZiparoConfig = field(default_factory=ZiparoConfig)
    safe: SafeGroundConfig = field(default_factory=SafeGroundConfig)
    local_map_m: float = 0.0  # plan on a square of this side that goes along with the robot; 0: on the map
    min_frontier_m: float = 0.5
    stuck_after_s: float = 6.0
    mission_s: float = 0.0  # the robot is back so long after it began; 0: the mission has no end
    battery_per_m: float = 0.0006  # share that a metre takes, until the robot has learnt it
    battery_reserve: float = 0.1  # what is left of it back at the base

    def __post_init__(self) -> None:
        """Keep a name that is an attribute's too apart from that: snapshots tell what is one object.

        Raises ConfigError where a small map would be a large one, or tags cannot tell of such cells.
        """
        if not 0.0 <= self.local_map_m <= MAX_LOCAL_MAP_M:
            raise ConfigError(f"planning.local_map_m has to be 0 to {MAX_LOCAL_MAP_M:g} metres")
        if self.tag_cell_m not in CELLS_M:
            sides = ", ".join(f"{side:g}" for side in sorted(CELLS_M))
            raise ConfigError(f"planning.tag_cell_m has to be one of {sides} metres")
        object.__setattr__(self, "communication", self.communication.encode().decode())


@dataclass(frozen=True, slots=True)
class AgentConfig:
    """Everything an agent is told before its first observation.

    The same config, seed and log give the same updates.
    """

    body: BodyConfig = field(default_factory=BodyConfig)
    antenna: AntennaConfig = field(default_factory=AntennaConfig)
    odometry: OdometryConfig = field(default_factory=OdometryConfig)
    imu: ImuConfig = field(default_factory=ImuConfig)
    scan_match: ScanMatchConfig = field(default_factory=ScanMatchConfig)
    mapping: MappingConfig = field(default_factory=MappingConfig)
    graph: GraphConfig = field(default_factory=GraphConfig)
    ranging: RangingConfig = field(default_factory=RangingConfig)
    radio: RadioConfig = field(default_factory=RadioConfig)
    rslam: RangeSlamConfig = field(default_factory=RangeSlamConfig)
    ekf: EkfConfig = field(default_factory=EkfConfig)
    loops: LoopConfig = field(default_factory=LoopConfig)
    deployment: DeploymentConfig = field(default_factory=DeploymentConfig)
    tag_memory: TagMemoryConfig = field(default_factory=TagMemoryConfig)
    victims: VictimConfig = field(default_factory=VictimConfig)
    planning: PlanningConfig = field(default_factory=PlanningConfig)
    poses: Literal["slam", "truth"] = "slam"  # "truth": odometry is exact; nothing is estimated (experiments)
    # "odometry": tags are noted, the graph never solved; "ekf": a filter over tags seen from afar; "rslam":
    # particles, by ranges alone
    slam: Literal["tag-graph", "odometry", "ekf", "rslam"] = "tag-graph"
    start: tuple[float, ...] = ()  # x, y (m), heading (rad) in the mission frame as surveyed; () unknown
    map_memory: bool = False  # leave maps of tags in the tags' memories, and use those that others left
    seed: int = 0
