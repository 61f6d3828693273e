"""Journeys of robots that never err: what the team must make of them is known."""

from collections.abc import Callable, Sequence

import pytest

from robots.agent import RobotAgent
from robots.config import AgentConfig
from robots.se2 import Pose2, wrap
from robots.types import AgentUpdate, Displacement, HeatReading, ImuReading, Observation, TagSighting

Journey = Callable[..., list[AgentUpdate]]


def travelled(
    robot_id: str,
    corners: Sequence[Pose2],
    tags: dict[int, str],
    *,
    imu: bool = True,
    heat: dict[int, tuple[float, float]] | None = None,
    stretch: float = 1.0,
    north: float = 0.0,
    begin_s: float = 0.0,
) -> list[AgentUpdate]:
    """Updates of an agent carried through poses in the world, tags read at some, victims seen from some.

    ``heat`` is bearing and range, seen three times over; ``stretch`` is how much too long odometry is,
    ``north`` by how much the compass is off, ``begin_s`` when it set out.
    """
    agent = RobotAgent(robot_id, AgentConfig())
    updates: list[AgentUpdate] = []
    before = corners[0]
    for k, pose in enumerate(corners):
        moved = before.between(pose)
        before = pose
        for repeat in range(3 if heat and k in heat else 1):
            seen = (HeatReading(*heat[k], 0.8),) if heat and k in heat else ()
            updates.append(
                agent.step(
                    Observation(
                        seq=len(updates),
                        stamp_s=begin_s + len(updates) * 0.2,
                        odometry=Displacement(moved.x * stretch, moved.y * stretch, moved.theta)
                        if repeat == 0
                        else Displacement(0.0, 0.0, 0.0),
                        imu=ImuReading(wrap(pose.theta + north)) if imu else None,
                        tag_sightings=(TagSighting(tags[k]),) if k in tags and repeat == 0 else (),
                        heat=seen,
                    )
                )
            )
    return updates


@pytest.fixture
def journey() -> Journey:
    return travelled
