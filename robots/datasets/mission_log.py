"""An exported mission log as a recording: what robots told mission control, exactly as it was stored.

Agents that go through it are told what the mission's were, so they have to come to the same updates bit for
bit; ``UpdateComparison`` says whether they do.
"""

from __future__ import annotations

import json
import re
from array import array
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from hashlib import sha256
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np

from robots import codec
from robots.config import AgentConfig, ConfigError
from robots.datasets.conformity import fault
from robots.datasets.log_lines import json_object, read_lines
from robots.datasets.recording import RecordingError
from robots.overrides import override
from robots.se2 import Array, Pose2
from robots.team import StartPose
from robots.trajectory import Trajectory
from robots.types import AgentUpdate, Observation

_ROBOT_ID = re.compile(r"[A-Za-z0-9][A-Za-z0-9._:~-]{0,63}")  # as mission control has them; files bear them
_MOST_OBSERVATIONS = 20_000_000


@dataclass(frozen=True, slots=True, eq=False)
class LoggedRobot:
    """A robot of the log: what its agent was told, and the digests of what that agent made of it."""

    robot_id: str
    settings: dict[str, Any]
    start: StartPose | None
    stamps_s: Array
    updates_until: int | None
    updates_sha256: str | None
    graph_sha256: str | None


@dataclass(frozen=True, slots=True, eq=False)
class MissionLog:
    """A mission as it was logged; observations are read from the file each time."""

    path: Path
    mission_id: str
    logged: dict[str, LoggedRobot]
    name: str = "log"
    truth_gap_s: float = 0.5

    @property
    def robots(self) -> tuple[str, ...]:
        """Ids of the robots that observed anything."""
        return tuple(robot_id for robot_id, robot in self.logged.items() if len(robot.stamps_s))

    @property
    def settings(self) -> dict[str, Any]:
        """Overrides of ``AgentConfig`` for the first robot."""
        return self.settings_of(self.robots[0])

    def settings_of(self, robot_id: str) -> dict[str, Any]:
        """Return all settings that the robot's agent had."""
        return self.logged[robot_id].settings

    def start_pose(self, robot_id: str) -> StartPose | None:
        """Return the start pose that the robot registered with."""
        return self.logged[robot_id].start

    def length(self, robot_id: str) -> int:
        """Return the number of observations."""
        return len(self.stamps_s(robot_id))

    def stamps_s(self, robot_id: str) -> Array:
        """Return the robot's own stamps, (n,)."""
        return self.logged[robot_id].stamps_s

    def truth(self, robot_id: str) -> Trajectory | None:
        """Return nothing: mission control does not know."""
        return None

    def tag_places(self) -> dict[str, tuple[float, float]]:
        """Return nothing: mission control does not know."""
        return {}

    def observations(self, robot_id: str) -> Iterator[Observation]:
        """Yield the observations as the mission's agent was given them."""
        for owner, observation in _read(self.path, None):
            if owner == robot_id:
                yield observation


def load(path: Path, virtual_tags_m: float | None = None) -> MissionLog:
    """Read a mission log once from end to end, so that whatever is wrong with it is said at the start.

    Raises:
        RecordingError: the file cannot be read, is no mission log of this version, not whole, or holds
            something that mission control would not have let in; or virtual tags are wanted.
    """
    if virtual_tags_m is not None:
        raise RecordingError("a mission log has real tags; leave the virtual ones out")
    heads: dict[str, dict[str, Any]] = {}
    stamps: dict[str, array[float]] = {}
    for owner, observation in _read(path, heads):
        stamps.setdefault(owner, array("d")).append(observation.stamp_s)
    mission = heads.pop("")
    logged = {
        robot_id: _logged_robot(path, robot_id, head, np.array(stamps.get(robot_id, ()), np.float64))
        for robot_id, head in heads.items()
    }
    if not stamps:
        raise RecordingError(f"{path} holds no observation: no robot of that mission has sent any")
    return MissionLog(path, str(mission.get("mission_id")), logged)


class UpdateComparison:
    """Compares the updates of one replayed agent with what the server's came to."""

    def __init__(self, robot: LoggedRobot) -> None:
        self._robot = robot
        self._digest = codec.CHAIN_START
        self._same_updates: bool | None = None
        self._same_graph = False
        self._taken = 0
        self.compared = 0

    def take(self, update: AgentUpdate) -> None:
        """Take the next update into account."""
        self._digest = codec.chained(self._digest, codec.encode(update))
        self._taken += 1
        if update.seq == self._robot.updates_until:
            self._same_updates = self._digest.hex() == self._robot.updates_sha256
            self.compared = self._taken
        if update.graph is not None and not self._same_graph:
            self._same_graph = sha256(codec.encode(update.graph)).hexdigest() == self._robot.graph_sha256

    def bit_equal(self) -> bool | None:
        """Return whether all that the server recorded came out the same, None where it recorded nothing.

        That is every update up to the server's latest snapshot of the agent, and its latest tag graph.
        """
        if self._robot.updates_sha256 is not None and not self._same_updates:
            return False
        if self._robot.graph_sha256 is not None:
            return self._same_graph
        return self._same_updates


def _read(path: Path, heads: dict[str, dict[str, Any]] | None) -> Iterator[tuple[str, Observation]]:
    """Yield each observation with its robot; collect the heads, that of the mission under ""."""
    lines = read_lines(path)
    mission = json_object(path, next(lines))
    heads = {} if heads is None else heads
    heads[""] = mission
    total = 0
    for _ in range(_count(path, mission, "robots")):
        head = json_object(path, _next(path, lines))
        robot_id = head.get("robot_id")
        if not isinstance(robot_id, str) or not _ROBOT_ID.fullmatch(robot_id):
            raise RecordingError(f"{path}: {str(robot_id)[:70]!r} is no name of a robot")
        if robot_id in heads:
            raise RecordingError(f"{path} holds two robots with the name {robot_id}")
        heads[robot_id] = head
        count = _count(path, head, "observations")
        total += count
        if total > _MOST_OBSERVATIONS:
            raise RecordingError(f"{path} announces more than {_MOST_OBSERVATIONS} observations")
        for _ in range(count):
            yield robot_id, _observation(path, lines)
    if next(lines, None) is not None:
        raise RecordingError(f"{path} is damaged: it holds more than it announces")


def _observation(path: Path, lines: Iterator[bytes]) -> Observation:
    line = _next(path, lines)
    survived = not line.startswith(b'{"fault":')
    if not survived:
        line = _next(path, lines)
    try:
        observation = codec.decode(line, Observation)
    except (codec.CodecError, OverflowError) as error:
        raise RecordingError(f"{path} is damaged: a line is no observation") from error
    wrong = fault(observation, Observation, "observation")
    if wrong is not None:
        raise RecordingError(f"{path}: {wrong} in an observation")
    # an agent was given an empty one in place of what it did not survive
    return observation if survived else Observation(observation.seq, observation.stamp_s)


def _logged_robot(path: Path, robot_id: str, head: dict[str, Any], stamps_s: Array) -> LoggedRobot:
    try:
        told = codec.decode(json.dumps(head.get("config")).encode(), AgentConfig)
        settings: dict[str, Any] = asdict(told)
        override(AgentConfig(), settings)
    except (codec.CodecError, ConfigError, TypeError, OverflowError) as error:
        raise RecordingError(f"{path}: the configuration of {robot_id} is none: {error}") from error
    until = head.get("updates_until")
    return LoggedRobot(
        robot_id,
        settings,
        _start(path, robot_id, head.get("start_pose")),
        stamps_s,
        until if isinstance(until, int) else None,
        _text(head.get("updates_sha256")),
        _text(head.get("graph_sha256")),
    )


def _start(path: Path, robot_id: str, value: Any) -> StartPose | None:
    if value is None:
        return None
    try:
        x, y, yaw, sd, sd_rad = (float(value[key]) for key in ("x_m", "y_m", "yaw_rad", "sd_m", "sd_rad"))
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        raise RecordingError(f"{path}: the start pose of {robot_id} is none") from error
    if not all(map(isfinite, (x, y, yaw, sd, sd_rad))) or min(sd, sd_rad) < 0.0:
        raise RecordingError(f"{path}: the start pose of {robot_id} is none")
    return StartPose(Pose2(x, y, yaw), sd, sd_rad)


def _count(path: Path, head: dict[str, Any], name: str) -> int:
    value = head.get(name)
    if type(value) is not int or value < 0:
        raise RecordingError(f"{path} is damaged: the number of {name} is {str(value)[:20]}")
    return value


def _next(path: Path, lines: Iterator[bytes]) -> bytes:
    line = next(lines, None)
    if line is None:
        raise RecordingError(f"{path} is damaged: it holds less than it announces")
    return line


def _text(value: Any) -> str | None:
    return value if isinstance(value, str) else None
