"""What crosses borders: observations into an agent, updates out of it.

Frozen, SI units, frames in the docstrings. Odometry and ranges are relative to the robot's base frame (x
ahead, y left). ``map`` is a robot's own map frame, whose origin is where it started; with an IMU its x axis
points north. ``world`` is the mission's frame, known to the team only.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from robots.graph_report import GraphReport
from robots.orders import Methods, OrderReport, RobotOrder
from robots.se2 import Array, Pose2

FloatArray32 = NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class WheelEncoders:
    """Distance rolled by each of four wheels since the previous observation, in metres."""

    front_left_m: float
    front_right_m: float
    rear_left_m: float
    rear_right_m: float


@dataclass(frozen=True, slots=True)
class DistanceTurn:
    """Odometry as (d, alpha) of Kleiner 2006 eq. (1).

    Distance driven and angle turned since the previous observation.
    """

    distance_m: float
    turn_rad: float


@dataclass(frozen=True, slots=True)
class Displacement:
    """Odometry as the pose of the base in the base frame of the previous observation."""

    dx_m: float
    dy_m: float
    dtheta_rad: float


Odometry = WheelEncoders | DistanceTurn | Displacement


@dataclass(frozen=True, slots=True)
class ImuReading:
    """Orientation from the inertial unit: yaw counter-clockwise from north, roll and pitch, in radians."""

    yaw_rad: float
    roll_rad: float = 0.0
    pitch_rad: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class LaserScan:
    """One sweep of a laser range finder in the base frame.

    ``ranges_m``: float32, shape (n,), beam i at ``angle_min_rad + i * angle_increment_rad``. A beam at or
    beyond ``range_max_m``, or not finite, is a far reading: free space at least that far, or glass.
    """

    ranges_m: FloatArray32
    angle_min_rad: float
    angle_increment_rad: float
    range_max_m: float


@dataclass(frozen=True, slots=True)
class RangeReading:
    """One sonar or infrared reading: nearest echo within a cone round ``bearing_rad`` in the base frame."""

    kind: Literal["sonar", "infrared"]
    bearing_rad: float
    range_m: float
    range_max_m: float
    cone_rad: float


@dataclass(frozen=True, slots=True)
class NodeSensors:
    """What an active node measures of its own place; None where it has no such sensor.

    ``tilt_rad``: how far its antenna leans from upright.
    """

    temperature_c: float | None = None
    pressure_hpa: float | None = None
    tilt_rad: float | None = None


@dataclass(frozen=True, slots=True)
class TagSighting:
    """A tag read by the robot: its id and the bytes of its memory (empty when only the id was read).

    How far off it is: ``range_m`` as a range finder measured it, or ``rssi_dbm``, from which the radio model
    tells the range. In which direction: ``bearing_rad`` in the base frame, which goes with a range, or
    ``antenna``, the directional one that heard it; neither, where the radio has no direction. A sighting with
    none of the four lies under the antenna. ``sensors`` ride along with an active node.
    """

    tag_id: str
    memory: bytes = b""
    range_m: float | None = None
    bearing_rad: float | None = None
    rssi_dbm: float | None = None
    antenna: Literal["front", "rear"] | None = None
    sensors: NodeSensors | None = None

    @property
    def under_antenna(self) -> bool:
        """Whether the robot stands over the tag."""
        return self.range_m is None and self.rssi_dbm is None


@dataclass(frozen=True, slots=True)
class RobotSighting:
    """Another robot seen by this one: its name, and where its base is in this one's base frame."""

    robot_id: str
    range_m: float
    bearing_rad: float


@dataclass(frozen=True, slots=True)
class HeatReading:
    """A warm body seen by the thermal sensor: bearing and range in the base frame, confidence in 0..1."""

    bearing_rad: float
    range_m: float
    confidence: float


@dataclass(frozen=True, slots=True, eq=False)
class Observation:
    """Everything a robot perceived since its previous observation.

    ``seq`` rises by one each time; stamps in seconds.
    """

    seq: int
    stamp_s: float
    odometry: Odometry | None = None
    imu: ImuReading | None = None
    scan: LaserScan | None = None
    beams: tuple[RangeReading, ...] = ()
    tag_sightings: tuple[TagSighting, ...] = ()
    robot_sightings: tuple[RobotSighting, ...] = ()
    heat: tuple[HeatReading, ...] = ()
    battery: float | None = None  # 0..1
    tags_left: int | None = None  # in the magazine
    bumper: bool = False  # pressed against something
    held: bool = False  # standing still by an order (STOP or hold), whatever the agent commanded
    heard: tuple[bytes, ...] = ()  # messages of the team, see robots.exploration.team.team_message
    orders: tuple[RobotOrder, ...] = ()  # of an operator, given since


@dataclass(frozen=True, slots=True)
class TagWrite:
    """Bytes to write into the memory of a tag within reach."""

    tag_id: str
    memory: bytes


@dataclass(frozen=True, slots=True)
class Command:
    """An order to the robot's body: velocities to hold until the next command, and what to do with tags."""

    linear_mps: float = 0.0
    angular_radps: float = 0.0
    drop_tag: bool = False
    writes: tuple[TagWrite, ...] = ()
    say: bytes | None = None  # a message to the team


@dataclass(frozen=True, slots=True, eq=False)
class SubmapReport:
    """An occupancy grid anchored to a pose vertex: the latest version replaces earlier ones.

    ``cells``: zlib-compressed int8 log-odds (tenths, 0 unknown, positive occupied), row-major, row = y, cell
    (0, 0) at the grid frame's origin; ``anchor_from_grid`` places that frame in the anchor's frame.
    """

    anchor: int
    version: int
    anchor_from_grid: Pose2
    resolution_m: float
    width: int
    height: int
    cells: bytes


@dataclass(frozen=True, slots=True, eq=False)
class VictimEstimate:
    """A victim as one robot knows it.

    ``position_m`` (2,) and ``covariance`` (2, 2) in the frame of its anchor pose vertex; ``kind``: what the
    sensor that saw it finds.
    """

    victim_id: str
    anchor: int
    position_m: Array
    covariance: Array
    confidence: float
    sightings: int
    first_seen_s: float
    last_seen_s: float
    kind: str = "person"


@dataclass(frozen=True, slots=True)
class Suspect:
    """What looked warm, but not often enough to be a victim: ``place_m`` (x, y) in the map frame."""

    victim_id: str
    place_m: tuple[float, float]
    sightings: int
    last_seen_s: float


@dataclass(frozen=True, slots=True)
class FrontierReport:
    """An edge of the unknown that a robot could go to: ``goal_m`` (x, y) in its map frame.

    ``worth_m``: what it is worth by the robot's strategy, in metres of way; ``chosen``: it goes there.
    """

    goal_m: tuple[float, float]
    length_m: float
    worth_m: float
    chosen: bool


Activity = Literal["starting", "exploring", "returning", "holding", "stuck", "done"]


@dataclass(frozen=True, slots=True, eq=False)
class AgentUpdate:
    """What an agent makes of one observation.

    ``pose`` and ``covariance`` (3, 3) in the map frame; ``anchor_from_base`` in the frame of pose vertex
    ``anchor``, ``anchor_from_base_covariance`` (3, 3) of it alone; ``goal_m`` and ``path_m`` (n, 2) in the
    map frame. ``graph``, ``submaps`` and ``victims`` are given when they changed, ``frontiers`` (best
    first) with every plan that changed them. ``doubts`` say once each what is wrong with tags, ranges or
    maps, ``orders`` what became of an operator's orders. ``methods``: those in force.
    """

    seq: int
    stamp_s: float
    pose: Pose2
    covariance: Array
    anchor: int
    anchor_from_base: Pose2
    command: Command
    activity: Activity
    reason: str
    tags_left: int
    explored_m2: float
    distance_m: float
    goal_m: tuple[float, float] | None = None
    path_m: FloatArray32 = field(default_factory=lambda: np.zeros((0, 2), np.float32))
    slipping: bool = False
    graph: GraphReport | None = None
    submaps: tuple[SubmapReport, ...] = ()
    victims: tuple[VictimEstimate, ...] = ()
    anchor_from_base_covariance: Array | None = None
    doubts: tuple[str, ...] = ()
    frontiers: tuple[FrontierReport, ...] | None = None
    orders: tuple[OrderReport, ...] = ()
    methods: Methods = field(default_factory=Methods)
