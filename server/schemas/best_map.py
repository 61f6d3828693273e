"""The best map on the wire."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import ConfigDict, Field

from server.schemas.common import Covariance, Wire
from server.schemas.findings import MapOut, TagOut

_STATE: dict[str, Any] = {
    "state": "ready",
    "reason": "",
    "asked_unix_s": 1767225600.0,
    "robots_done": 1,
    "robots_total": 1,
    "solved_unix_s": 1767225604.5,
    "explored_m2": 212.4,
    "map": {
        "version": 1767225604500,
        "width": 412,
        "height": 256,
        "resolution_m": 0.05,
        "origin_m": [-3.2, -1.05],
        "explored_m2": 214.3,
        "png": "/api/v1/missions/school-1/best-map.png?version=1767225604500",
    },
    "as_of": [{"robot_id": "r1", "seq": 4211, "stamp_s": 842.2, "distance_m": 186.4}],
    "left_out": [],
}
_DETAILS: dict[str, Any] = {
    "is_current": True,
    "robots": [
        {
            "robot_id": "r1",
            "located": True,
            "x_m": 4.2,
            "y_m": 1.5,
            "yaw_rad": 0.3,
            "points_m": [[0.0, 0.0], [0.25, 0.01]],
        }
    ],
    "tags": [],
    "links": [],
    "victims": [],
}


class BestAsOfOut(Wire):
    """The last observation of a robot that is in the best map."""

    robot_id: str
    seq: int
    stamp_s: float = Field(description="When it was made, on the robot's clock.")
    distance_m: float = Field(description="How far the robot had driven then.")


class BestLeftOut(Wire):
    """A robot that is not in the best map."""

    robot_id: str
    reason: str = Field(description="Why it is not, in words.")


class BestMapStateOut(Wire):
    """How the best map stands, as `best_map` on the stream; an earlier one stays until the next is there."""

    model_config = ConfigDict(json_schema_extra={"examples": [_STATE]})

    state: Literal["none", "solving", "ready", "failed"] = Field(
        description="`none`: nobody has asked; `solving`: it is being made; `ready`; `failed`: see `reason`."
    )
    reason: str = Field(description="Why there is none or the last solve failed; empty otherwise.")
    asked_unix_s: float | None = Field(description="When the latest one was asked for.")
    robots_done: int = Field(description="How many robots' recordings are smoothed already.")
    robots_total: int = Field(description="Of how many.")
    solved_unix_s: float | None = Field(description="When the best map that is there was made.")
    explored_m2: float | None = Field(description="Free floor in it.")
    map: MapOut | None = Field(description="Its picture and where that lies; null where there is none.")
    as_of: list[BestAsOfOut] = Field(description="Up to which observation each robot is in it.")
    left_out: list[BestLeftOut] = Field(description="Robots with observations that are not in it, and why.")


class BestRobotOut(Wire):
    """A robot in the best map, where it was at its last observation in it."""

    robot_id: str
    located: bool = Field(description="Whether anything joins it to the world; else it is in its map frame.")
    x_m: float
    y_m: float
    yaw_rad: float
    points_m: list[tuple[float, float]] = Field(description="Its trail; empty while it is not located.")


class BestVictimOut(Wire):
    """Where a victim is in the best map; what people say about it stands at the victim itself."""

    victim_id: str
    x_m: float
    y_m: float
    covariance: Covariance


class BestMapOut(BestMapStateOut):
    """The best map with everything in it, in the world frame."""

    model_config = ConfigDict(json_schema_extra={"examples": [{**_STATE, **_DETAILS}]})

    is_current: bool = Field(description="Whether every observation up to now is in it.")
    robots: list[BestRobotOut]
    tags: list[TagOut]
    links: list[tuple[str, str]] = Field(description="Pairs of tags driven one after the other.")
    victims: list[BestVictimOut]
