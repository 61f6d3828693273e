"""A mission while it runs, and the one way through it: saved, thought about, saved, shown, answered.

What else a mission has is in the modules beside this one, each a part of ``Mission``.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Sequence
from typing import Any

from db.errors import DatabaseError
from db.records import MissionRecord, ObservationRecord, RobotRecord
from db.store import Store
from robots import codec
from robots.team import TeamGrid
from robots.types import Observation
from server.agents.process import ForkServer
from server.board import Board
from server.broadcast import Broadcast
from server.differences import differences
from server.errors import ApiError
from server.history.recorder import Recorder
from server.mission.alerts import Alerts
from server.mission.annotations import Annotations
from server.mission.base_map import BaseMap
from server.mission.best_map import BestMap
from server.mission.chip_notes import ChipNotes
from server.mission.doubts import Doubts
from server.mission.endings import Endings
from server.mission.evacuation import Evacuation
from server.mission.events import Events
from server.mission.georeferences import Georeferences
from server.mission.ground import Ground
from server.mission.lifecycle import Lifecycle
from server.mission.links import Links
from server.mission.locating import Locating
from server.mission.memories import Memories
from server.mission.nodes import Nodes
from server.mission.orders import Orders
from server.mission.photos import Photos
from server.mission.pocket import Pocket
from server.mission.presence import Presence
from server.mission.progress import Progress
from server.mission.recovery import Recovery
from server.mission.relay import Relay
from server.mission.replies import fresh_of, reply_to
from server.mission.reports import Reports
from server.mission.robot_alerts import RobotAlerts
from server.mission.roster import Roster
from server.mission.routes import Routes
from server.mission.sectors import Sectors
from server.mission.senders import Senders
from server.mission.shared_map import SharedMap
from server.mission.stops import Stops
from server.mission.tasks import Tasks
from server.mission.thinking import Thinking
from server.mission.told_victims import ToldVictims
from server.mission.victims import Victims
from server.robot import Robot
from server.schemas.observations import OnboardWire
from server.settings import Settings


class Mission:
    """One mission. ``board`` is what everybody sees.

    ``on_grid`` is told of every new fused map, ``on_base`` of the base map, None when it is taken away.
    """

    def __init__(
        self,
        record: MissionRecord,
        store: Store,
        forks: ForkServer,
        settings: Settings,
        on_grid: Callable[[str, TeamGrid], None],
        on_base: Callable[[str, TeamGrid | None], None],
        board: Board | None = None,
    ) -> None:
        mission_id = record.mission_id
        self.mission_id = mission_id
        self.board = Board() if board is None else board
        self.events = Events(store, mission_id, self.board)
        self.broadcast = Broadcast(self.board)
        self.presence = Presence(self.board)
        self.routes = Routes(self.board)
        self.annotations = Annotations(store, mission_id, self.board)
        self.alerts = Alerts(store, mission_id, self.board, self.events)
        self.photos = Photos(store, mission_id, self.board, self.events)
        self.georeferences = Georeferences(store, mission_id, self.board, self.events)
        self.base_map = BaseMap(store, mission_id, self.board, self.events, on_base)
        self.sectors = Sectors(store, mission_id, self.board, self.events)
        self.evacuation = Evacuation(store, mission_id, self.board, self.events)
        self.victims = Victims(store, mission_id, self.board, self.events, self.alerts)
        tag_key = bytes.fromhex(record.tag_key)
        chip_notes = ChipNotes(self.annotations, tag_key)
        self.reports = Reports(
            store, mission_id, self.board, self.annotations, self.victims, self.alerts, self.evacuation,
            chip_notes,
        )  # fmt: skip
        told = ToldVictims(self.board, self.victims)
        self.memories = Memories(store, mission_id, tag_key, self.events, self.alerts, chip_notes, told)
        self.nodes = Nodes(store, mission_id, self.board, self.alerts)
        self._tasks = Tasks(mission_id)
        self.roster = Roster(record, store, forks, self.board, self.alerts, self._tasks)
        self.stops = Stops(store, self.roster, self.events)
        self.lifecycle = Lifecycle(store, self.roster, self.events)
        self.progress = Progress(store, mission_id, self.board)
        self.orders = Orders(store, mission_id, self.board, self.events)
        doubts = Doubts(store, mission_id, self.alerts)
        self.shared_map = SharedMap(
            store, forks, self.board, self.roster, self.victims, told, doubts, on_grid
        )
        self.ground = Ground(store, self.roster, self.shared_map)
        self.locating = Locating(self.board, self.roster, self.shared_map)
        self.pocket = Pocket(self.board, self.roster, self.routes, self.shared_map, self.locating)
        self.best_map = BestMap(store, forks, self.board, self.roster, self.shared_map, self._tasks)
        self.history = Recorder(store, mission_id, self.board, lambda: self.shared_map.image)
        self._relay = Relay(self.roster)
        self._senders = Senders(store, mission_id, self.events)
        self._links = Links(self.roster, self.alerts, settings)
        self._recovery = Recovery(
            store, self.roster, self.shared_map, self.memories, self.orders, self._tasks, settings
        )
        self._thinking = Thinking(
            store, self.roster, self.shared_map, self._relay, self.memories, self.orders,
            RobotAlerts(self.alerts, self.events), self._recovery, self.events,
        )  # fmt: skip
        self._endings = Endings(store, self.board, self.roster, self.shared_map, self._recovery)
        self._store = store
        self._settings = settings
        if not record.is_over:
            self._tasks.spawn(self._links.watch())
            self._tasks.spawn(self.progress.watch())

    def begin(self) -> None:
        """Begin as a new mission."""
        self.shared_map.begin()
        self.history.begin()

    async def restore(self) -> None:
        """Begin where the database says that it stood; the agents catch up in the background."""
        await self.events.restore()
        await self.alerts.restore()
        await self.evacuation.restore()
        await self.annotations.restore()
        await self.photos.restore()
        await self.georeferences.restore()
        await self.base_map.restore()
        await self.sectors.restore()
        await self.victims.restore()
        await self.reports.restore()
        await self.nodes.restore()
        await self.orders.restore()
        if self.roster.record.is_over and await self._endings.restore():
            await self.history.restore()  # nothing begins: what people still do is recorded when they do it
            return
        await self.shared_map.restore()
        await self._recovery.restore()
        if self.roster.record.is_over:  # the server ended before it could keep the ending
            self._tasks.spawn(self.rest())
        await self.history.restore()
        self.history.begin()

    async def rest(self) -> None:
        """Keep what the mission came to, and end its processes: it is over.

        Raises:
            DatabaseError: the ending could not be kept; it is tried again at the next start.
        """
        await self.progress.note()
        await self._endings.keep()
        await asyncio.gather(self.shared_map.close(), self.roster.close(), self.nodes.save())
        await self._tasks.close()

    async def go_on(self) -> None:
        """Begin again after it was over; see ``restore``."""
        await self._endings.forget()
        await self.restore()

    async def close(self) -> None:
        """End the processes of all agents and of the team map."""
        await self._tasks.close()
        await asyncio.gather(self.shared_map.close(), self.roster.close(), self.nodes.save())
        await self.history.close()

    async def register(self, record: RobotRecord) -> tuple[Robot, bool]:
        """Add a robot, or let it join again with the same words; say whether it is new.

        Raises:
            ApiError: a robot of that name registered otherwise.
        """
        robot, is_new = await self.roster.register(record)
        if is_new:
            self.shared_map.add(robot)
            await self.events.tell("robot_joined", f"{robot.robot_id} joined the mission.", robot.robot_id)
        return robot, is_new

    async def ingest(
        self, robot_id: str, batch: Sequence[Observation], onboard: Sequence[OnboardWire], sender: str
    ) -> dict[str, Any]:
        """Take in observations, in the order of their seq, and return the reply of the wire.

        ``sender`` says from where they come, for people to read.

        Raises:
            ApiError: a mission that takes none now, a gap, stamps that run backwards, or too much waiting
                already, and nothing is kept then; or the agent takes too long, and everything is kept.
        """
        robot = self.roster.get(robot_id)
        self.lifecycle.check_running()
        if robot.waiting + len(batch) > self._settings.max_waiting:
            if robot.held:
                return reply_to(robot, batch, 0, 0, [])
            text = f"The agent of {robot_id} is behind; send again in a second."
            raise ApiError(503, "busy", text, retry_after_s=1)
        robot.waiting += len(batch)
        fresh: list[Observation] = []
        try:
            async with robot.arriving:
                fresh = fresh_of(robot, batch)
                if fresh:
                    await self._accept(robot, fresh)
                elif robot.thought_failed:
                    robot.thought = self._tasks.spawn(self._thinking.think(robot, None))
                thought = robot.thought
            await self._senders.check(robot, batch, len(fresh), sender)
            if fresh:
                await self._links.heard(robot)
            if thought is not None:  # also for a batch that came before: its answer may not be there yet
                await self._answered(robot, thought)
        except DatabaseError:
            if not robot.held:
                raise
            return reply_to(
                robot, batch, 0, len(batch) - len(fresh), []
            )  # not accepted, but STOP all the same
        finally:
            robot.waiting -= len(batch)
        found = differences(robot, onboard)
        if onboard:
            await self._thinking.tell_difference(robot, found)
        orders = self.orders.waiting(robot) if robot.record.agent == "onboard" else ()
        return reply_to(robot, batch, len(fresh), len(batch) - len(fresh), found, orders)

    async def _accept(self, robot: Robot, fresh: list[Observation]) -> None:
        """Save observations, and only then let the agent think about them."""
        now = time.time()
        fresh = self.orders.attach(robot, self._relay.heard(robot, fresh))
        bodies = [codec.encode(observation) for observation in fresh]
        records = [
            ObservationRecord(observation.seq, observation.stamp_s, now, body)
            for observation, body in zip(fresh, bodies, strict=True)
        ]
        await self._store.log.append_observations(self.mission_id, robot.robot_id, records)
        self._relay.done(robot, fresh[0])
        is_stop_heard = robot.stopping.take(fresh, robot.last_stamp_s)
        robot.next_seq = fresh[-1].seq + 1
        robot.last_stamp_s = fresh[-1].stamp_s
        robot.battery = next((o.battery for o in reversed(fresh) if o.battery is not None), robot.battery)
        if not robot.is_unanswered:
            robot.asked_at_s = time.monotonic()
        robot.thought = self._tasks.spawn(
            self._thinking.think(robot, [(record.seq, record.body) for record in records])
        )
        if is_stop_heard:
            self.roster.publish([robot])
        await self.orders.delivered(fresh)
        await self.memories.keep_read(robot.robot_id, fresh)
        await self.nodes.take(robot.robot_id, fresh)

    async def _answered(self, robot: Robot, thought: asyncio.Task[None]) -> None:
        """Wait until the agent has answered; a stopped robot has its STOP at once, whatever its agent does.

        Raises:
            ApiError: it takes too long.
        """
        give_up_s = time.monotonic() + self._settings.reply_s
        while True:
            done, _ = await asyncio.wait({thought}, timeout=self._settings.stop_reply_s)
            if robot.held:
                return
            if done:
                thought.result()
                return
            if time.monotonic() > give_up_s:
                text = (
                    f"The observations of {robot.robot_id} are saved, but its agent is not done with them;"
                    " send them again for its order."
                )
                raise ApiError(503, "agent_busy", text, retry_after_s=1)
