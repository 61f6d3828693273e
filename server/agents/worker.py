"""What runs in a worker process: one agent or one team map, answering frames until the server is gone.

This module is loaded in the fork server, before any fork; of the project's other packages it imports
``robots`` only.
"""

from __future__ import annotations

import json
import socket
import traceback
from contextlib import suppress
from types import ModuleType
from typing import Any, Protocol

from robots import codec
from robots.config import AgentConfig
from robots.se2 import Pose2
from robots.types import AgentUpdate, Observation
from server.agents.frames import Kind, pack, receive

TAKEN, REFUSED = b"+", b"!"  # first byte of each answer to an observation: update, or the reason


class Servant(Protocol):
    """Something that answers frames."""

    def answer(self, kind: Kind, parts: list[bytes]) -> list[bytes]:
        """Return the parts of the answer."""


class AgentServant:
    """One robot's agent."""

    def __init__(self, module: ModuleType) -> None:
        self._module = module
        self._agent: Any = None

    def answer(self, kind: Kind, parts: list[bytes]) -> list[bytes]:
        """Begin, restore, handle observations, take a snapshot, report."""
        if kind is Kind.HANDLE:
            return [self._handle(part) for part in parts]
        if kind is Kind.BEGIN:
            robot_id, config = parts
            self._agent = self._module.RobotAgent(robot_id.decode(), codec.decode(config, AgentConfig))
            self._agent.updates_digest = codec.CHAIN_START
            return []
        if kind is Kind.RESTORE:
            self._agent = self._module.RobotAgent.restore(parts[0])
            return []
        if kind is Kind.SNAPSHOT:
            return [self._agent.snapshot()]
        if kind is Kind.REPORT:
            try:
                return [codec.encode(self._agent.report())]
            except self._module.ObservationError:  # nothing observed yet
                return []
        raise ValueError(f"an agent cannot answer {kind.name}")

    def _handle(self, body: bytes) -> bytes:
        try:
            update = codec.encode(self._agent.step(codec.decode(body, Observation)))
        except self._module.ObservationError as error:  # the agent is unchanged
            return REFUSED + str(error).encode()
        if self._agent.updates_digest:  # none in a snapshot from before there were digests
            self._agent.updates_digest = codec.chained(self._agent.updates_digest, update)
        return TAKEN + update


class TeamServant:
    """One mission's team map."""

    def __init__(self, module: ModuleType) -> None:
        self._module = module
        self._team: Any = None
        self._grid_version: int | None = None

    def answer(self, kind: Kind, parts: list[bytes]) -> list[bytes]:
        """Begin, add robots, put their updates, solve."""
        if kind is Kind.BEGIN:
            self._team = self._module.TeamMap()
            return []
        if kind is Kind.ADD_ROBOT:
            self._team.add_robot(parts[0].decode(), start_pose(self._module, parts[1]))
            return []
        if kind is Kind.PUT:
            for part in parts[1:]:
                self._team.put(parts[0].decode(), codec.decode(part, AgentUpdate))
            return []
        if kind is Kind.SOLVE:
            return [codec.encode(self._team.solve())]
        raise ValueError(f"a team map cannot answer {kind.name}")


def start_pose(team_module: ModuleType, data: bytes) -> Any:
    """Return a surveyed start as the team map takes it, None where there is none."""
    if not data:
        return None
    start = json.loads(data)
    pose = Pose2(start["x_m"], start["y_m"], start["yaw_rad"])
    return team_module.StartPose(pose, start["sd_m"], start["sd_rad"])


def serve(connection: socket.socket, servant: Servant) -> int:
    """Answer frames until the server closes the connection; return the exit code.

    An unexpected error is told to the server and ends the process: the state may be half changed, and the
    log brings it back whole.
    """
    with suppress(BrokenPipeError, ConnectionResetError):
        while (frame := receive(connection)) is not None:
            try:
                answer = servant.answer(*frame)
            except Exception:
                connection.sendall(pack(Kind.FAILED, [traceback.format_exc().encode()]))
                return 1
            connection.sendall(pack(Kind.DONE, answer))
    return 0
