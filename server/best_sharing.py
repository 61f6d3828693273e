"""A best map as those who look at it get it: in short for everybody's board, in detail for who shows it."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from robots.se2 import Pose2
from robots.team import TeamRobot
from robots.types import AgentUpdate
from server.agents.best import BestSolution
from server.map_image import MapImage, draw
from server.sharing import map_value, tag_record, tag_value, team_values, victim_place_value


@dataclass(frozen=True, slots=True)
class SharedBestMap:
    """A best map that is there, or none.

    ``as_of``: the last observation of each robot that is in it; ``short``: its part of ``best_map`` on the
    board; ``details``: robots with their trails, tags, links and victims.
    """

    image: MapImage | None = None
    as_of: Mapping[str, int] = field(default_factory=dict)
    short: Mapping[str, Any] = field(
        default_factory=lambda: {
            "solved_unix_s": None,
            "explored_m2": None,
            "map": None,
            "as_of": [],
            "left_out": [],
        }
    )
    details: Mapping[str, Any] = field(
        default_factory=lambda: {"robots": [], "tags": [], "links": [], "victims": []}
    )


def shared(
    mission_id: str, solution: BestSolution, left_out: Mapping[str, str], before: MapImage | None
) -> SharedBestMap:
    """Return a solution as it is shared, with a picture that is newer than the one before."""
    team = solution.team
    image = None
    if team.grid is not None:
        now = int(time.time() * 1000.0)  # by the clock, as the live map's
        version = now if before is None else max(now, before.version + 1)
        image = draw(replace(team.grid, version=version))
    values = team_values(team)
    return SharedBestMap(
        image,
        {name: update.seq for name, update in solution.robots.items()},
        {
            "solved_unix_s": time.time(),
            "explored_m2": round(team.explored_m2, 2),
            "map": None if image is None else map_value(mission_id, image, "best-map.png"),
            "as_of": [
                {"robot_id": name, "seq": u.seq, "stamp_s": u.stamp_s, "distance_m": round(u.distance_m, 2)}
                for name, u in solution.robots.items()
            ],
            "left_out": [{"robot_id": name, "reason": why} for name, why in sorted(left_out.items())],
        },
        {
            "robots": [
                _robot_value(member, solution.robots[member.robot_id])
                | {"points_m": (values[f"trail/{member.robot_id}"] or {})["points_m"]}
                for member in team.robots
            ],
            "tags": [tag_value(tag_record(tag)) for tag in team.tags],
            "links": (values["links"] or {})["pairs"],
            "victims": [victim_place_value(victim) for victim in team.victims],
        },
    )


def _robot_value(member: TeamRobot, here: AgentUpdate) -> dict[str, Any]:
    pose = Pose2.from_array(member.anchors[here.anchor]) @ here.anchor_from_base
    return {
        "robot_id": member.robot_id,
        "located": member.located,
        "x_m": round(pose.x, 4),
        "y_m": round(pose.y, 4),
        "yaw_rad": round(pose.theta, 4),
    }
