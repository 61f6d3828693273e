"""What a robot's agent makes of the log, taken over, saved and shown."""

from __future__ import annotations

from typing import Any

import structlog

from db.errors import DatabaseError
from db.store import Store
from robots import codec
from robots.estimation.ranges.views import as_sightings
from robots.types import AgentUpdate
from server.agents.host import Answer
from server.mission.events import Events
from server.mission.memories import Memories
from server.mission.orders import Orders
from server.mission.recovery import Recovery
from server.mission.relay import Relay
from server.mission.robot_alerts import RobotAlerts
from server.mission.roster import Roster
from server.mission.shared_map import SharedMap
from server.robot import Robot

log = structlog.get_logger()


class Thinking:
    """Has agents answer to observations, one batch of a robot after the other."""

    def __init__(
        self,
        store: Store,
        roster: Roster,
        shared_map: SharedMap,
        relay: Relay,
        memories: Memories,
        orders: Orders,
        robot_alerts: RobotAlerts,
        recovery: Recovery,
        events: Events,
    ) -> None:
        self._store = store
        self._mission_id = roster.record.mission_id
        self._roster = roster
        self._shared_map = shared_map
        self._relay = relay
        self._memories = memories
        self._orders = orders
        self._robot_alerts = robot_alerts
        self._recovery = recovery
        self._events = events

    async def think(self, robot: Robot, records: list[tuple[int, bytes]] | None) -> None:
        """Have the agent answer to observations; None for what has no answer, after a thought that failed."""
        async with robot.thinking:
            if records is None:
                records = await robot.host.unanswered(robot.next_seq - 1)
            answers = await robot.host.handle(records)
            updates = [self._take(robot, answer) for answer in answers]
            made = [update for update in updates if update is not None]
            self._relay.take(robot, made)
            await self._save(robot, made)
            self._roster.publish([robot])
            await self._robot_alerts.look(robot)
            for update in made:
                await self._orders.report(update)
            for text in dict.fromkeys(doubt for update in made for doubt in update.doubts):
                await self._events.tell(
                    "tag_doubtful", f"{robot.robot_id}: {text}", robot.robot_id, "warning"
                )
            self._recovery.snapshot_when_due(robot)

    def _take(self, robot: Robot, answer: Answer) -> AgentUpdate | None:
        if answer.update is None:
            log.warning("refused by the agent", robot_id=robot.robot_id, seq=answer.seq, reason=answer.reason)
            return None
        update = codec.decode(answer.update, AgentUpdate)
        robot.take(update)
        self._shared_map.put(robot, update)
        return update

    async def _save(self, robot: Robot, updates: list[AgentUpdate]) -> None:
        """Save what the agent made of the log; were it lost, the log brings it back."""
        graphs = [update.graph for update in updates if update.graph is not None]
        if graphs:
            try:
                graph = as_sightings(graphs[-1])
                await self._store.graphs.record_graph(self._mission_id, robot.robot_id, graph)
            except DatabaseError as error:
                log.error("a graph could not be saved", robot_id=robot.robot_id, reason=str(error))
        writes = [write for update in updates for write in update.command.writes]
        await self._memories.keep_written(robot.robot_id, writes)

    async def tell_difference(self, robot: Robot, found: list[dict[str, Any]]) -> None:
        """Tell of the first of a row of batches in which the agent on board differs."""
        differed, robot.differs = robot.differs, bool(found)
        if found and not differed:
            first = found[0]
            text = (
                f"{robot.robot_id} decided otherwise on board at observation {first['seq']}: {first['what']}."
            )
            await self._events.tell("onboard_differs", text, robot.robot_id, "warning")
