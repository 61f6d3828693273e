"""What the store hands out: frozen values, one per row, units in the names."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from robots.orders import OrderKind, OrderState

AgentPlace = Literal["server", "onboard"]
SilencePolicy = Literal["hold", "go_on", "return"]
MissionState = Literal["draft", "running", "paused", "closed", "archived"]
TagState = Literal["sound", "moved", "cloned", "doubtful"]
AnnotationKind = Literal["note", "hazard", "searched", "victim", "exit"]
Severity = Literal["info", "warning", "alarm"]
AlertKind = Literal[
    "hot", "tilted", "pressure",  # of nodes
    "lost", "stuck", "slipping", "battery", "magazine", "agent",  # of robots
    "tag", "victim", "mayday",
]  # fmt: skip


@dataclass(frozen=True, slots=True)
class MissionRecord:
    """A mission: one place, one team of robots, one map.

    ``state_by`` has put it into its state at ``state_unix_s``; ``ran_s``: how long it ran before that.
    """

    mission_id: str
    name: str
    state: MissionState
    created_unix_s: float
    stopped_all: bool = False
    tag_key: str = ""  # hexadecimal; seals what is written into the mission's tags
    state_by: str = ""
    state_unix_s: float = 0.0
    started_unix_s: float | None = None
    ran_s: float = 0.0

    @property
    def is_over(self) -> bool:
        """Whether it is read and no longer changed."""
        return self.state in ("closed", "archived")

    def duration_s(self, now_unix_s: float) -> float:
        """Return how long it has been running in all."""
        return self.ran_s + (max(0.0, now_unix_s - self.state_unix_s) if self.state == "running" else 0.0)


@dataclass(frozen=True, slots=True)
class StartPoseRecord:
    """Where a surveyed robot started, in the world frame, and how well that is known."""

    x_m: float
    y_m: float
    yaw_rad: float
    sd_m: float
    sd_rad: float


@dataclass(frozen=True, slots=True)
class RobotRecord:
    """A robot as it registered; ``config`` is the encoded ``AgentConfig``."""

    mission_id: str
    robot_id: str
    agent: AgentPlace
    silence_after_s: float
    silence_policy: SilencePolicy
    start_pose: StartPoseRecord | None
    config: bytes
    stopped: bool
    registered_unix_s: float

    def registration(self) -> tuple[object, ...]:
        """Return what a robot that registers again has to repeat."""
        return (self.agent, self.silence_after_s, self.silence_policy, self.start_pose, self.config)


@dataclass(frozen=True, slots=True)
class ObservationRecord:
    """One line of the log.

    ``body`` is the encoded ``Observation``; ``fault`` says why the agent cannot take it.
    """

    seq: int
    stamp_s: float
    received_unix_s: float
    body: bytes
    fault: str | None = None


@dataclass(frozen=True, slots=True)
class SnapshotRecord:
    """An agent's state after observation ``seq``, and its latest updates in short: (seq, encoded text)."""

    seq: int
    body: bytes
    updates: tuple[tuple[int, str], ...]


@dataclass(frozen=True, slots=True)
class PointRecord:
    """A place in the world frame with its covariance."""

    x_m: float
    y_m: float
    var_x: float
    var_xy: float
    var_y: float


@dataclass(frozen=True, slots=True)
class TagRecord:
    """A tag as the team map places it; ``notice`` says what is wrong with one that is not sound."""

    tag_id: str
    place: PointRecord
    sightings: int
    robots: tuple[str, ...]
    state: TagState = "sound"
    notice: str = ""


@dataclass(frozen=True, slots=True)
class NodeRecord:
    """What an active node measured last, and which robot heard it; None where it has no such sensor.

    ``usual_pressure_hpa``: what its pressure has been lately.
    """

    tag_id: str
    temperature_c: float | None
    pressure_hpa: float | None
    tilt_rad: float | None
    usual_pressure_hpa: float | None
    heard_unix_s: float
    robot_id: str


@dataclass(frozen=True, slots=True)
class AlertRecord:
    """Something people have to know: raised, perhaps over since, perhaps acknowledged by somebody.

    ``robot_id``, ``tag_id`` and ``victim_id``: what it is about, as far as it is about such a thing.
    """

    alert_id: str
    kind: AlertKind
    text: str
    severity: Severity
    raised_unix_s: float
    robot_id: str | None = None
    tag_id: str | None = None
    victim_id: str | None = None
    over_unix_s: float | None = None
    acknowledged_by: str = ""
    acknowledged_unix_s: float | None = None

    @property
    def settled(self) -> bool:
        """Whether it is over and somebody has taken note of it."""
        return self.over_unix_s is not None and self.acknowledged_unix_s is not None


@dataclass(frozen=True, slots=True)
class EvacuationRecord:
    """An order to leave: by whom, since when, and who has heard it when."""

    by: str
    since_unix_s: float
    acknowledged: tuple[tuple[str, float], ...] = ()


@dataclass(frozen=True, slots=True)
class AnnotationRecord:
    """Something a person wrote on the map: at a place in the world frame, at a tag, or over an area.

    ``area_m``: the corners of the area in the world frame, empty where it has none.
    """

    annotation_id: str
    kind: AnnotationKind
    text: str
    x_m: float | None
    y_m: float | None
    tag_id: str | None
    by: str
    created_unix_s: float
    changed_unix_s: float
    area_m: tuple[tuple[float, float], ...] = ()

    @classmethod
    def of(cls, value: dict[str, Any]) -> AnnotationRecord:
        """Return it of its plain values, as they are stored and go over the wire."""
        return cls(**{**value, "area_m": tuple((float(x), float(y)) for x, y in value["area_m"])})


@dataclass(frozen=True, slots=True)
class EventRecord:
    """Something that happened, for the people who watch."""

    event_id: int
    unix_s: float
    kind: str
    text: str
    robot_id: str | None
    severity: Severity


@dataclass(frozen=True, slots=True)
class OrderRecord:
    """An operator's order to a robot, and what has become of it.

    ``x_m`` and ``y_m`` in the world frame, for the kinds that need a place; an empty name of a method leaves
    it as it is.
    """

    order_id: str
    robot_id: str
    kind: OrderKind
    by: str
    issued_unix_s: float
    x_m: float | None = None
    y_m: float | None = None
    explore: str = ""
    coordinate: str = ""
    communication: str = ""
    state: OrderState = "issued"
    text: str = ""
    area_m: tuple[tuple[float, float], ...] = ()

    @classmethod
    def of(cls, value: dict[str, Any]) -> OrderRecord:
        """Return it of its plain values, as they are stored."""
        return cls(**{**value, "area_m": tuple((float(x), float(y)) for x, y in value["area_m"])})
