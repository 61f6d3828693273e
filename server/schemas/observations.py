"""What robots send and what they are told."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import ConfigDict, Field, model_validator
from pydantic.config import JsonDict

from server.schemas.common import Base64, Name, PoseWire, Radians, Seconds, Share, TeamBytes, Wire
from server.schemas.orders import MAX_ORDERS, RobotOrderWire

MAX_BATCH = 2_000
MAX_BEAMS = 4_096

Step = Annotated[float, Field(ge=-1000.0, le=1000.0)]
Range = Annotated[float, Field(ge=0.0, le=10_000.0)]
Signal = Annotated[float, Field(ge=-200.0, le=100.0)]
SightingRange = Annotated[float, Field(ge=0.0, le=1000.0)]

EXAMPLE_BATCH: JsonDict = {
    "observations": [
        {
            "seq": 0,
            "stamp_s": 12.0,
            "odometry": {
                "kind": "wheels",
                "front_left_m": 0.02,
                "front_right_m": 0.02,
                "rear_left_m": 0.02,
                "rear_right_m": 0.02,
            },
            "imu": {"yaw_rad": 0.0, "roll_rad": 0.0, "pitch_rad": 0.0},
            "scan": {
                "ranges_m": [2.0, 2.1, None, 2.4, 2.2],
                "angle_min_rad": -2.0,
                "angle_increment_rad": 1.0,
                "range_max_m": 4.0,
            },
            "battery": 0.93,
            "tags_left": 100,
        },
        {
            "seq": 1,
            "stamp_s": 12.05,
            "odometry": {"kind": "distance_turn", "distance_m": 0.025, "turn_rad": 0.01},
            "tag_sightings": [{"tag_id": "A4", "memory": ""}],
            "heat": [{"bearing_rad": 0.2, "range_m": 1.8, "confidence": 0.9}],
        },
        {
            "seq": 2,
            "stamp_s": 12.1,
            "odometry": {"kind": "displacement", "dx_m": 0.025, "dy_m": 0.0, "dtheta_rad": 0.0},
            "beams": [
                {"kind": "sonar", "bearing_rad": 0.0, "range_m": 1.2, "range_max_m": 3.0, "cone_rad": 0.5}
            ],
            "tag_sightings": [
                {"tag_id": "A5", "range_m": 3.1, "bearing_rad": -0.4},
                {"tag_id": "N7", "rssi_dbm": -41.5, "sensors": {"temperature_c": 38.0, "tilt_rad": 0.1}},
            ],
            "robot_sightings": [{"robot_id": "r2", "range_m": 4.2, "bearing_rad": 0.7}],
        },
    ]
}


class WheelsWire(Wire):
    """Way rolled by each wheel since the previous observation."""

    kind: Literal["wheels"]
    front_left_m: Step
    front_right_m: Step
    rear_left_m: Step
    rear_right_m: Step


class DistanceTurnWire(Wire):
    """Distance driven and angle turned since the previous observation."""

    kind: Literal["distance_turn"]
    distance_m: Step
    turn_rad: Step


class DisplacementWire(Wire):
    """Pose of the base in the base frame of the previous observation."""

    kind: Literal["displacement"]
    dx_m: Step
    dy_m: Step
    dtheta_rad: Step


class ImuWire(Wire):
    """Orientation by the inertial unit: yaw counter-clockwise from north."""

    yaw_rad: Radians
    roll_rad: Radians = 0.0
    pitch_rad: Radians = 0.0


class ScanWire(Wire):
    """One sweep of the laser in the base frame."""

    ranges_m: list[Range | None] = Field(
        max_length=MAX_BEAMS, description="Per beam; null where nothing came back."
    )
    angle_min_rad: Radians = Field(description="Bearing of the first beam.")
    angle_increment_rad: Radians = Field(description="From one beam to the next.")
    range_max_m: float = Field(gt=0.0, le=10_000.0, description="At and beyond it nothing is measured.")


class BeamWire(Wire):
    """One sonar or infrared reading."""

    kind: Literal["sonar", "infrared"]
    bearing_rad: Radians
    range_m: Range
    range_max_m: float = Field(gt=0.0, le=10_000.0)
    cone_rad: float = Field(ge=0.0, le=7.0)


class NodeSensorsWire(Wire):
    """What an active node measures of its own place."""

    temperature_c: float | None = Field(None, ge=-273.15, le=2000.0)
    pressure_hpa: float | None = Field(None, ge=0.0, le=20_000.0)
    tilt_rad: Radians | None = Field(None, description="How far its antenna leans from upright.")


class TagSightingWire(Wire):
    """A tag that was read: under the antenna, or from afar by its range or its signal."""

    tag_id: Name
    memory: Base64 = Field("", description="Its memory in base64; empty when only the id was read.")
    range_m: SightingRange | None = Field(
        None, description="From the base; left out, with the bearing, for a tag under the antenna."
    )
    bearing_rad: Radians | None = Field(None, description="In the base frame, counter-clockwise from ahead.")
    rssi_dbm: Signal | None = Field(None, description="Signal strength, where the reader has no range.")
    antenna: Literal["front", "rear"] | None = Field(None, description="The directional one that heard it.")
    sensors: NodeSensorsWire | None = Field(None, description="Readings of an active node.")

    @model_validator(mode="after")
    def _direction_needs_a_range(self) -> Self:
        if self.bearing_rad is not None and self.range_m is None:
            raise ValueError("bearing_rad needs range_m; give both")
        if self.antenna is not None and self.range_m is None and self.rssi_dbm is None:
            raise ValueError("antenna needs range_m or rssi_dbm; a tag under the reader has none of them")
        return self


class RobotSightingWire(Wire):
    """Another robot that was seen: where its base is in the base frame."""

    robot_id: Name
    range_m: SightingRange
    bearing_rad: Radians = Field(description="Counter-clockwise from ahead.")


class HeatWire(Wire):
    """A warm body seen by the thermal sensor, in the base frame."""

    bearing_rad: Radians
    range_m: Range
    confidence: Share


class ObservationIn(Wire):
    """Everything a robot perceived since its previous observation."""

    seq: int = Field(ge=0, lt=2**53, description="Rises by one with every observation, from 0.")
    stamp_s: Seconds = Field(description="When, on the robot's clock.")
    odometry: (
        Annotated[WheelsWire | DistanceTurnWire | DisplacementWire, Field(discriminator="kind")] | None
    ) = None
    imu: ImuWire | None = None
    scan: ScanWire | None = None
    beams: list[BeamWire] = Field(default_factory=list, max_length=256)
    tag_sightings: list[TagSightingWire] = Field(default_factory=list, max_length=256)
    robot_sightings: list[RobotSightingWire] = Field(default_factory=list, max_length=256)
    heat: list[HeatWire] = Field(default_factory=list, max_length=256)
    battery: Share | None = Field(None, description="0 empty, 1 full.")
    tags_left: int | None = Field(None, ge=0, le=1_000_000, description="Tags in the magazine.")
    bumper: bool = Field(False, description="Pressed against something.")
    held: bool = Field(False, description="Standing still by an order.")
    orders: list[RobotOrderWire] = Field(
        default_factory=list,
        max_length=MAX_ORDERS,
        description="What an agent on board was told by the last reply; to others the server adds it.",
    )
    heard: list[TeamBytes] = Field(
        default_factory=list, max_length=256, description="Messages of the team, as `say` of a command."
    )


class TagWriteWire(Wire):
    """Bytes to write into a tag within reach."""

    tag_id: Name
    memory: Base64 = Field(description="In base64.")


class CommandWire(Wire):
    """An order to hold until the next one."""

    linear_mps: float
    angular_radps: float
    drop_tag: bool
    writes: list[TagWriteWire]
    say: TeamBytes | None = Field(None, description="A message to the robots in reach, in base64.")


class OnboardWire(Wire):
    """What the agent on board made of an observation, to be compared."""

    seq: int = Field(ge=0, lt=2**53)
    pose: PoseWire = Field(description="In the robot's map frame.")
    command: CommandWire


class BatchIn(Wire):
    """Observations in the order of their seq; sending them again does no harm."""

    model_config = ConfigDict(json_schema_extra={"examples": [EXAMPLE_BATCH]})

    observations: list[ObservationIn] = Field(min_length=1, max_length=MAX_BATCH)
    onboard: list[OnboardWire] | None = Field(None, max_length=MAX_BATCH, description="By an agent on board.")


class DifferenceWire(Wire):
    """A value in which the agent on board and its twin on the server differ."""

    seq: int
    what: str
    onboard: float | bool | str
    server: float | bool | str


class BatchOut(Wire):
    """The answer to observations: the next order."""

    next_seq: int
    accepted: int
    duplicates: int
    stop: bool = Field(description="Stand still; the command is all zero then.")
    pose: PoseWire | None = Field(description="In the robot's map frame; null while the agent is starting.")
    command: CommandWire
    differences: list[DifferenceWire]
    orders: list[RobotOrderWire] = Field(
        description="For an agent on board: to be put into its next observation."
    )
