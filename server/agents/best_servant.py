"""What runs in the process that makes a best map: each robot is smoothed, then all are joined.

Loaded in the fork server, before any fork, as ``server.agents.worker`` is.
"""

from __future__ import annotations

import os
from dataclasses import replace
from types import ModuleType
from typing import Any

import numpy as np

from robots import codec
from robots.estimation.graph.solve import GraphError
from robots.se2 import Pose2
from robots.snapshot import SnapshotError
from robots.types import AgentUpdate
from server.agents.frames import Kind
from server.agents.worker import REFUSED, TAKEN, start_pose

NICENESS = 10  # live agents have a deadline, this has none
WAY_COLUMNS = 6  # of a step: seq, stamp, anchor, and the base in the anchor's frame (x, y, heading)


class BestServant:
    """One best map, made once and then thrown away; it yields the processor to whoever wants it."""

    def __init__(self, agent: ModuleType, team: ModuleType) -> None:
        os.nice(NICENESS)
        self._agent = agent
        self._team_module = team
        self._team: Any = team.TeamMap()

    def answer(self, kind: Kind, parts: list[bytes]) -> list[bytes]:
        """Smooth and add a robot (id, start, snapshot, way), solve."""
        if kind is Kind.ADD_ROBOT:
            robot_id, start, snapshot, way = parts
            return [self._add(robot_id.decode(), start, snapshot, way)]
        if kind is Kind.SOLVE:
            return [codec.encode(self._team.solve())]
        raise ValueError(f"a best map cannot answer {kind.name}")

    def _add(self, robot_id: str, start: bytes, snapshot: bytes, way: bytes) -> bytes:
        """Return how the robot stands, without its map; or why it has to be left out."""
        try:
            update: AgentUpdate = self._agent.RobotAgent.restore(snapshot).smoothed()
        except (SnapshotError, GraphError, self._agent.ObservationError) as error:
            return REFUSED + str(error).encode()
        self._team.add_robot(robot_id, start_pose(self._team_module, start))
        self._team.put(robot_id, update)
        here = replace(update, graph=None, submaps=(), victims=())
        for seq, stamp_s, anchor, x, y, theta in np.frombuffer(way).reshape(-1, WAY_COLUMNS).tolist():
            place = Pose2(x, y, theta)
            step = replace(here, seq=int(seq), stamp_s=stamp_s, anchor=int(anchor), anchor_from_base=place)
            self._team.put(robot_id, step)
        return TAKEN + codec.encode(here)
