"""One robot of a mission as the server keeps it.

Where its log stands, its agent's latest word, whether it is heard, and where it is in the world.
"""

from __future__ import annotations

import asyncio
import time
from collections import OrderedDict
from collections.abc import AsyncIterator
from dataclasses import dataclass, field, replace
from typing import Literal

from db.records import RobotRecord, SnapshotRecord
from db.store import Store
from robots import codec
from robots.config import AgentConfig
from robots.estimation.radio.hearing import Ears
from robots.graph_report import GraphReport
from robots.se2 import Array, GaussianPose, Pose2
from robots.types import AgentUpdate, Command, FrontierReport, Observation
from server.agents.host import AgentHost
from server.stopping import Stopping

Link = Literal["live", "late", "lost"]
_REMEMBERED = 2500  # answers kept for batches that are sent again: more than the largest batch
_IN_SNAPSHOT = 64
_SILENT_S = 1.0


@dataclass(frozen=True, slots=True)
class Told:
    """What a robot was told after an observation: its pose in the map frame and the command."""

    pose: Pose2
    command: Command


class RobotLog:
    """The log of one robot, as its agent's host reads it."""

    def __init__(self, store: Store, mission_id: str, robot_id: str) -> None:
        self._store = store
        self._of = (mission_id, robot_id)

    async def snapshot(self) -> tuple[int, bytes] | None:
        """Return the seq and bytes of the latest snapshot."""
        record = await self._store.log.latest_snapshot(*self._of)
        return None if record is None else (record.seq, record.body)

    async def observations(self, after: int, until: int) -> AsyncIterator[tuple[int, bytes]]:
        """Yield (seq, encoded observation) in order; an empty one where the agent cannot take it."""
        async for record in self._store.log.observations_after(*self._of, after, until):
            empty = record.fault is not None
            yield record.seq, codec.encode(Observation(record.seq, record.stamp_s)) if empty else record.body

    async def record_fault(self, seq: int, reason: str) -> bytes:
        """Mark an observation that the agent cannot survive; return an empty one to take its place."""
        await self._store.log.record_fault(*self._of, seq, reason)
        async for record in self._store.log.observations_after(*self._of, seq - 1, seq):
            return codec.encode(Observation(seq, record.stamp_s))
        raise LookupError(f"observation {seq} is not in the log")


@dataclass(slots=True)
class Robot:
    """A registered robot. ``anchors`` (n, 3): world poses of its pose vertices in the latest team map.

    ``anchor_covariance`` (3, 3): of the newest of them, None where nothing joins the robot to the world.

    ``thought``: the agent's work on the newest observations of the log; ``differs``: the agent on board
    decided otherwise in the last batch that told what it decided.
    """

    record: RobotRecord
    host: AgentHost
    next_seq: int = 0
    last_stamp_s: float | None = None
    stopping: Stopping = field(default_factory=Stopping)
    paused: bool = False
    link: Link = "lost"
    heard_unix_s: float | None = None
    heard_at_s: float = field(default_factory=time.monotonic)
    battery: float | None = None
    update: AgentUpdate | None = None
    speed_mps: float | None = None  # by its agent
    graph: GraphReport | None = None
    frontiers: tuple[FrontierReport, ...] = ()
    anchors: Array | None = None
    located: bool = False
    anchor_covariance: Array | None = None
    waiting: int = 0  # observations that wait for the agent
    told: OrderedDict[int, Told] = field(default_factory=OrderedDict)
    arriving: asyncio.Lock = field(default_factory=asyncio.Lock)
    thinking: asyncio.Lock = field(default_factory=asyncio.Lock)
    thought: asyncio.Task[None] | None = None
    asked_at_s: float = 0.0  # since when the agent owes an answer, while it does
    differs: bool = False
    snapshot_seq: int = -1
    snapshot_at_s: float = field(default_factory=time.monotonic)
    snapshot_task: asyncio.Task[None] | None = None
    slam: str = field(init=False)
    communication: str = field(init=False)
    ears: Ears = field(init=False)

    def __post_init__(self) -> None:
        """Look up what its agent was told; a damaged record must not hold up the others."""
        try:
            config = codec.decode(self.record.config, AgentConfig)
            self.slam, self.communication = config.slam, config.planning.communication
            self.ears = Ears(config.radio, config.ranging)
        except codec.CodecError:
            self.slam, self.communication, self.ears = "unknown", "unknown", Ears()

    @property
    def robot_id(self) -> str:
        """Its name in the mission."""
        return self.record.robot_id

    @property
    def thought_failed(self) -> bool:
        """Whether the agent's work on the newest observations ended with an error."""
        thought = self.thought
        return (
            thought is not None
            and thought.done()
            and not thought.cancelled()
            and thought.exception() is not None
        )

    @property
    def is_unanswered(self) -> bool:
        """Whether its agent has not answered to the newest observations, yet or at all."""
        return self.thought is not None and (not self.thought.done() or self.thought_failed)

    @property
    def is_agent_down(self) -> bool:
        """Whether its agent has owed an answer for so long that it must be dead, stuck or coming back."""
        return self.is_unanswered and time.monotonic() - self.asked_at_s > _SILENT_S

    @property
    def stopped(self) -> bool:
        """Whether STOP was ordered."""
        return self.stopping.is_ordered

    @property
    def held(self) -> bool:
        """Whether it has to stand still: by STOP, or because its mission is paused."""
        return self.stopped or self.paused

    def set_stopped(self, stopped: bool) -> None:
        """Stop it, or let it go on: from the next reply on."""
        self.stopping.order(stopped)
        self.record = replace(self.record, stopped=stopped)

    def world_from_map(self) -> Pose2 | None:
        """Return where the robot's map lies in the world now; None before anything was observed."""
        world_from_base = self.world_pose()
        if self.update is None or world_from_base is None:
            return None
        return world_from_base @ self.update.pose.inverse()

    def take(self, update: AgentUpdate) -> None:
        """Make an update the latest one."""
        if self.update is not None and update.stamp_s > self.update.stamp_s:
            driven = update.distance_m - self.update.distance_m
            self.speed_mps = max(0.0, driven / (update.stamp_s - self.update.stamp_s))
        self.update = update
        self.communication = update.methods.communication or self.communication
        if update.graph is not None:
            self.graph = update.graph
        if update.frontiers is not None:
            self.frontiers = update.frontiers
        self.told[update.seq] = Told(update.pose, update.command)
        while len(self.told) > _REMEMBERED:
            self.told.popitem(last=False)

    def world_pose(self) -> Pose2 | None:
        """Return the pose of the base in the world, by the latest team map.

        None before anything was observed.
        """
        update = self.update
        if update is None:
            return None
        if self.anchors is not None and update.anchor < len(self.anchors):
            return Pose2.from_array(self.anchors[update.anchor]) @ update.anchor_from_base
        if self.graph is None:
            return update.pose
        if self.anchors is not None and len(self.anchors):  # the newest anchor is not in the team map yet
            known = len(self.anchors) - 1
            map_from_known = Pose2.from_array(self.graph.poses[known])
            return Pose2.from_array(self.anchors[known]) @ map_from_known.between(update.pose)
        start = self.record.start_pose
        if start is None:
            return update.pose
        map_from_start = Pose2.from_array(self.graph.poses[0])
        return Pose2(start.x_m, start.y_m, start.yaw_rad) @ map_from_start.between(update.pose)

    def world_covariance(self) -> Array | None:
        """Return the covariance (3, 3) of ``world_pose`` by the latest team map.

        That of the newest anchor it knows, and what was driven since; None where it does not know any.
        """
        update, graph = self.update, self.graph
        if update is None or graph is None or self.anchors is None or self.anchor_covariance is None:
            return None
        since = update.anchor_from_base_covariance
        known = len(self.anchors) - 1
        if since is None or not 0 <= known <= update.anchor < len(graph.poses):
            return None
        here = GaussianPose(Pose2.from_array(self.anchors[known]), self.anchor_covariance)
        steps = {int(j): k for k, (i, j) in enumerate(graph.edge_pairs) if j == i + 1}
        for vertex in range(known + 1, update.anchor + 1):
            if vertex not in steps:
                return None
            edge = steps[vertex]
            driven = Pose2.from_array(graph.edge_poses[edge])
            here = here @ GaussianPose(driven, graph.edge_covariances[edge])
        return (here @ GaussianPose(update.anchor_from_base, since)).covariance

    def snapshot_record(self, seq: int, body: bytes) -> SnapshotRecord:
        """Return a snapshot together with what the robot was told last.

        It may send a batch again after a restart.
        """
        recent = [(s, told) for s, told in self.told.items() if s <= seq][-_IN_SNAPSHOT:]
        texts = tuple(
            (s, codec.encode(told.pose).decode() + "\n" + codec.encode(told.command).decode())
            for s, told in recent
        )
        return SnapshotRecord(seq, body, texts)

    def recall(self, snapshot: SnapshotRecord) -> None:
        """Take over what the robot was told before a restart."""
        for seq, text in snapshot.updates:
            pose, command = text.split("\n")
            self.told[seq] = Told(codec.decode(pose.encode(), Pose2), codec.decode(command.encode(), Command))
