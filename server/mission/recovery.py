"""Bringing agents back after a restart of the server, and the snapshots that make it quick."""

from __future__ import annotations

import asyncio
import time

import structlog

from db.errors import DatabaseError
from db.store import Store
from robots import codec
from robots.types import AgentUpdate, Observation
from server.agents.host import Answer
from server.agents.process import WorkerDiedError
from server.mission.memories import Memories
from server.mission.orders import Orders
from server.mission.roster import Roster
from server.mission.shared_map import SharedMap
from server.mission.tasks import Tasks
from server.robot import Robot
from server.settings import Settings

_SETTLING_S = 15.0  # the team map waits so long for agents that are brought back
_PAUSE_S, _LONGEST_PAUSE_S = 0.2, 5.0

log = structlog.get_logger()


class Recovery:
    """Restores robots with their agents, and takes snapshots of agents that work."""

    def __init__(
        self,
        store: Store,
        roster: Roster,
        shared_map: SharedMap,
        memories: Memories,
        orders: Orders,
        tasks: Tasks,
        settings: Settings,
    ) -> None:
        self._store = store
        self._roster = roster
        self._shared_map = shared_map
        self._memories = memories
        self._orders = orders
        self._tasks = tasks
        self._settings = settings

    async def restore(self) -> None:
        """Bring back the robots of the database; their agents catch up in the background."""
        mission_id = self._roster.record.mission_id
        catching_up = []
        for record in await self._store.missions.robots_of(mission_id):
            last = await self._store.log.last_observation(mission_id, record.robot_id)
            robot = self._roster.add(record, done_seq=-1 if last is None else last.seq)
            self._shared_map.add(robot)
            if last is not None:
                robot.last_stamp_s, robot.heard_unix_s = last.stamp_s, last.received_unix_s
                robot.battery = codec.decode(last.body, Observation).battery
                robot.thought = self._tasks.spawn(self._catch_up(robot))
                catching_up.append(robot.thought)
        self._roster.publish()
        self._tasks.spawn(self._begin_map(catching_up))

    def snapshot_when_due(self, robot: Robot) -> None:
        """Take a snapshot in the background after enough observations, or enough time."""
        new = robot.host.done_seq - robot.snapshot_seq
        due = new >= self._settings.snapshot_every or (
            new > 0 and time.monotonic() - robot.snapshot_at_s >= self._settings.snapshot_every_s
        )
        if due and (robot.snapshot_task is None or robot.snapshot_task.done()):
            robot.snapshot_task = self._tasks.spawn(self._snapshot(robot))

    async def snapshot_all(self) -> None:
        """Take a snapshot of every agent that has something new."""
        robots = self._roster.robots.values()
        due = [
            robot
            for robot in robots
            if robot.host.pid is not None and robot.host.done_seq > robot.snapshot_seq
        ]
        await asyncio.gather(*map(self._snapshot, due))

    async def _begin_map(self, catching_up: list[asyncio.Task[None]]) -> None:
        """Let the map begin when all agents are there: a map of a few would show less than was known."""
        if catching_up:
            await asyncio.wait(catching_up, timeout=_SETTLING_S)
        self._shared_map.begin()

    async def _catch_up(self, robot: Robot) -> None:
        """Bring one agent back and put what it knows where it was; an agent that fails delays no other."""
        async with robot.thinking:  # first in the queue: what arrives is thought about afterwards
            update = await self._report(robot)
            if update is not None:
                robot.take(update)
                self._shared_map.put(robot, update)
        self._roster.publish([robot])

    async def _report(self, robot: Robot) -> AgentUpdate | None:
        """Return all that an agent knows after its log, trying as often as it takes."""
        pause_s = _PAUSE_S
        while True:
            try:
                await self._recall(robot)
                report = await robot.host.report()
            except (WorkerDiedError, DatabaseError) as error:
                log.warning("agent not back yet", robot_id=robot.robot_id, reason=str(error))
                await asyncio.sleep(pause_s)
                pause_s = min(2.0 * pause_s, _LONGEST_PAUSE_S)
                continue
            return None if report is None else codec.decode(report, AgentUpdate)

    async def _recall(self, robot: Robot) -> None:
        """Have what the robot was told last, for batches that it sends again."""
        snapshot = await self._store.log.latest_snapshot(self._roster.record.mission_id, robot.robot_id)
        robot.told.clear()
        if snapshot is not None:
            robot.recall(snapshot)
            robot.snapshot_seq = snapshot.seq

        def replayed(answer: Answer) -> None:
            if answer.update is not None:
                update = codec.decode(answer.update, AgentUpdate)
                robot.take(update)
                self._shared_map.put(robot, update)
                if update.orders:
                    self._tasks.spawn(self._orders.report(update))
                if update.command.writes:  # the server may have ended before it kept them; merging is safe
                    self._tasks.spawn(self._memories.keep_written(robot.robot_id, update.command.writes))

        robot.host.on_replayed = replayed

    async def _snapshot(self, robot: Robot) -> None:
        robot.snapshot_seq, robot.snapshot_at_s = robot.host.done_seq, time.monotonic()
        try:
            seq, body = await robot.host.snapshot()
            record = robot.snapshot_record(seq, body)
            await self._store.log.record_snapshot(self._roster.record.mission_id, robot.robot_id, record)
        except (WorkerDiedError, DatabaseError) as error:  # the log is enough, and the next one will do
            log.warning("no snapshot", robot_id=robot.robot_id, reason=str(error))
