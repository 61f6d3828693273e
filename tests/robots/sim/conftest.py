"""A driver that needs no map, and worlds drawn as text."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest

from robots.config import AgentConfig
from robots.se2 import Pose2
from robots.sim.world import BRICK, GLASS, SMOKE, WALL, World
from robots.tags.record import seal
from robots.types import AgentUpdate, Command, Observation, TagWrite, VictimEstimate, WheelEncoders

CELLS = {".": 0, "#": WALL, "g": GLASS, "b": BRICK, "s": SMOKE}


class Wanderer:
    """Drives ahead until something is near, then turns; drops tags and writes into those it meets."""

    def __init__(self, robot_id: str, config: AgentConfig) -> None:
        self._robot_id = robot_id
        self._turns = 0
        self._command = Command()
        self._pose = Pose2()
        self._track_m = config.body.track_width_m
        self._update: AgentUpdate | None = None

    def step(self, observation: Observation) -> AgentUpdate:
        odometry = observation.odometry
        if isinstance(odometry, WheelEncoders):
            left = (odometry.front_left_m + odometry.rear_left_m) / 2
            right = (odometry.front_right_m + odometry.rear_right_m) / 2
            turn = (right - left) / self._track_m
            self._pose = self._pose @ Pose2.exp(np.array([(left + right) / 2, 0.0, turn]))
        writes = tuple(
            TagWrite(
                sighting.tag_id,
                seal(f"{self._robot_id}@{observation.seq}".encode(), observation.seq, sighting.tag_id, b""),
            )
            for sighting in observation.tag_sightings
        )
        self._command = replace(self._command, drop_tag=observation.seq % 157 == 23, writes=writes)
        scan = observation.scan
        if scan is not None:
            middle = len(scan.ranges_m) // 2
            if self._turns > 0:
                self._turns -= 1
            elif observation.bumper or scan.ranges_m[middle - 25 : middle + 25].min() < 0.6:
                self._turns = 4 + observation.seq % 7
            turning = self._turns > 0
            self._command = replace(
                self._command, linear_mps=0.0 if turning else 0.5, angular_radps=1.3 if turning else 0.05
            )
        self._update = AgentUpdate(
            seq=observation.seq,
            stamp_s=observation.stamp_s,
            pose=self._pose,
            covariance=np.eye(3),
            anchor=0,
            anchor_from_base=self._pose,
            command=self._command,
            activity="exploring",
            reason="wandering",
            tags_left=observation.tags_left or 0,
            explored_m2=0.0,
            distance_m=0.0,
            victims=(VictimEstimate("v", 0, np.array([0.0, 0.0]), np.eye(2), 0.9, 1, 0.0, 0.0),),
        )
        return self._update

    def smoothed(self) -> AgentUpdate:
        assert self._update is not None
        return self._update


def merged(updates: Sequence[AgentUpdate]) -> Command:
    writes = tuple(write for update in updates for write in update.command.writes)
    drop = any(update.command.drop_tag for update in updates)
    return replace(updates[-1].command, drop_tag=drop, writes=writes)


def drawn(text: str, resolution_m: float = 0.1) -> World:
    """A world from a drawing, top line = largest y; the rim has to be wall."""
    rows = [[CELLS[sign] for sign in line.strip()] for line in text.strip().splitlines()]
    return World(np.array(rows[::-1], dtype=np.uint8), (0.0, 0.0), resolution_m)


@pytest.fixture
def draw() -> Callable[..., World]:
    return drawn


@pytest.fixture
def hall() -> World:
    """An empty room of 10 x 6 metres inside."""
    cells = np.full((122, 202), WALL, dtype=np.uint8)
    cells[1:-1, 1:-1] = 0
    return World(cells, (-0.05, -0.05), 0.05)


@pytest.fixture
def wanderer() -> type[Wanderer]:
    return Wanderer


@pytest.fixture
def merge() -> Callable[[Sequence[AgentUpdate]], Command]:
    return merged
