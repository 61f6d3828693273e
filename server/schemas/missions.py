"""Missions, robots, STOP and events on the wire."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import ConfigDict, Field

from db.records import AgentPlace, MissionState, Severity, SilencePolicy
from server.schemas.common import Metres, Name, Radians, Wire


class MissionIn(Wire):
    """A mission to open."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {"name": "Collapsed school", "mission_id": "school-1"},
                {"name": "Mine", "state": "draft"},
            ]
        }
    )

    name: str = Field(min_length=1, max_length=200, description="What people call it.")
    mission_id: Name | None = Field(None, description="Its id in addresses; made from the name by default.")
    tag_key: Annotated[str, Field(max_length=64, pattern="^([0-9a-f]{2})*$")] | None = Field(
        None,
        description="Key that seals what its robots write into tags, in hexadecimal digits; made at random by"
        " default. It is never told again.",
    )
    state: Literal["draft", "running"] = Field(
        "running", description="A draft takes no observations until somebody starts it."
    )


class MissionOut(Wire):
    """A mission."""

    mission_id: str
    name: str
    state: MissionState = Field(
        description="`draft`: robots may join, no observations; `running`; `paused`: robots stand still and"
        " are logged on; `closed` and `archived`: nothing is changed any more."
    )
    state_by: str = Field(description="Who has put it into this state; empty where nobody was asked.")
    state_unix_s: float = Field(description="When.")
    created_unix_s: float
    started_unix_s: float | None = Field(description="When it was running first.")
    duration_s: float = Field(description="How long it has been running in all.")
    robots: int = Field(description="How many robots are registered.")
    explored_m2: float = Field(description="Free ground on its map.")
    tags: int
    victims: int = Field(description="Those that were not dismissed or merged into others.")
    heard_unix_s: float | None = Field(description="When one of its robots was heard last.")


class MissionsOut(Wire):
    """All missions, oldest first."""

    missions: list[MissionOut]


class ProgressWire(Wire):
    """How far a mission was at a moment."""

    unix_s: float
    clock_s: float = Field(description="The robots' own clock.")
    explored_m2: float
    tags: int
    victims: int


class EffortWire(Wire):
    """What one robot has done."""

    robot_id: str
    distance_m: float
    explored_m2: float


class SummaryOut(Wire):
    """A mission in figures, to compare it with others."""

    mission: MissionOut
    robots: list[EffortWire]
    victims: dict[str, int] = Field(description="How many of each status.")
    alerts: dict[str, int] = Field(description="How many events of each kind were a warning or an alarm.")
    progress: list[ProgressWire] = Field(description="What it had come to, in order of time.")


class SilenceWire(Wire):
    """What the robot does when it hears nothing."""

    after_s: Annotated[float, Field(gt=0.0, le=3600.0, description="Silence after which it does so.")] = 2.0
    policy: Annotated[
        SilencePolicy, Field(description="Stand still, go on exploring, or return to the start.")
    ] = "hold"


class StartPoseWire(Wire):
    """A surveyed start in the world frame, and how well it is known."""

    x_m: Metres
    y_m: Metres
    yaw_rad: Radians
    sd_m: float = Field(gt=0.0, le=1000.0, description="Standard deviation of the position along each axis.")
    sd_rad: float = Field(gt=0.0, le=10.0, description="Standard deviation of the heading.")


class RobotIn(Wire):
    """A robot that joins; the same words again are a re-join."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {"robot_id": "r1"},
                {
                    "robot_id": "r2",
                    "agent": "onboard",
                    "silence": {"after_s": 5.0, "policy": "go_on"},
                    "start_pose": {"x_m": 1.0, "y_m": 2.5, "yaw_rad": 0.0, "sd_m": 0.1, "sd_rad": 0.02},
                    "config": {"body": {"radius_m": 0.3}, "slam": "ekf"},
                },
            ]
        }
    )

    robot_id: Name = Field(description="Its name in this mission.")
    agent: AgentPlace = Field("server", description="Where the agent decides: on the server or on board.")
    silence: SilenceWire = Field(default_factory=SilenceWire)
    start_pose: StartPoseWire | None = Field(None, description="Where it starts, if that was surveyed.")
    config: dict[str, Any] = Field(default_factory=dict, description="Settings of its agent that differ.")


class RobotOut(Wire):
    """A robot: how it registered, where to go on, and its latest state on the board."""

    robot_id: str
    agent: AgentPlace
    slam: str = Field(description="The kind of SLAM of its agent, as in config.slam.")
    silence: SilenceWire
    start_pose: StartPoseWire | None
    next_seq: int = Field(description="The seq of the observation that is expected next.")
    stopped: bool
    link: Literal["live", "late", "lost"] = Field(description="Heard lately, not lately, not for long.")
    state: dict[str, Any] | None = Field(description="As `robot/ID` on the stream; null before it was heard.")


class RobotsOut(Wire):
    """The robots of a mission in the order in which they registered."""

    robots: list[RobotOut]


class StopIn(Wire):
    """Whom to stop, or to let go on."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"robots": None}]})

    robots: list[Name] | None = Field(
        None, min_length=1, max_length=1000, description="Robot ids; null for all."
    )


class StopOut(Wire):
    """Who is stopped now."""

    stopped: list[str]


class EventOut(Wire):
    """Something that happened."""

    event_id: int
    unix_s: float
    kind: str
    text: str
    robot_id: str | None
    severity: Severity


class EventsOut(Wire):
    """Events, oldest first."""

    events: list[EventOut]


class HealthOut(Wire):
    """That the server is there."""

    status: Literal["ok"]
    version: str
    missions: int
    uptime_s: float
