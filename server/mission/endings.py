"""What is left of a mission that is over: its board and map as they were, without any process behind them."""

from __future__ import annotations

import asyncio
import time

import structlog

from db.errors import DatabaseError
from db.mission_records import EndingRecord
from db.store import Store
from robots import codec
from robots.team import TeamGrid
from server.board import Board
from server.mission.recovery import Recovery
from server.mission.roster import Roster
from server.mission.shared_map import SharedMap

_KEPT = {"robot", "frontiers", "trail", "tag", "links", "map"}  # what no other table brings back
_SETTLING_S = 20.0

log = structlog.get_logger()


class Endings:
    """Keeps what a mission came to when it is closed, and shows it when the server starts."""

    def __init__(
        self, store: Store, board: Board, roster: Roster, shared_map: SharedMap, recovery: Recovery
    ) -> None:
        self._store = store
        self._board = board
        self._roster = roster
        self._shared_map = shared_map
        self._recovery = recovery
        self._mission_id = roster.record.mission_id

    async def keep(self) -> None:
        """Let agents and map finish what they are at, and keep what they came to.

        Raises:
            DatabaseError: it could not be saved; it is tried again at the next start.
        """
        thoughts = [robot.thought for robot in self._roster.robots.values() if robot.thought is not None]
        if thoughts:
            await asyncio.wait(thoughts, timeout=_SETTLING_S)
        await self._recovery.snapshot_all()
        await self._shared_map.settle(_SETTLING_S)
        board = {
            key: value for key, value in self._board.snapshot().items() if key.partition("/")[0] in _KEPT
        }
        grid = self._shared_map.grid
        ending = EndingRecord(time.time(), board, None if grid is None else codec.encode(grid))
        await self._store.missions.record_ending(self._mission_id, ending)

    async def restore(self) -> bool:
        """Show what is left; say whether there was anything: a server may have ended before it was kept."""
        ending = await self._store.missions.ending_of(self._mission_id)
        if ending is None:
            return False
        for record in await self._store.missions.robots_of(self._mission_id):
            last = await self._store.log.last_observation(self._mission_id, record.robot_id)
            robot = self._roster.add(record, done_seq=-1 if last is None else last.seq)
            self._shared_map.add(robot)
            robot.graph = await self._store.graphs.graph_of(self._mission_id, record.robot_id)
            if last is not None:
                robot.last_stamp_s, robot.heard_unix_s = last.stamp_s, last.received_unix_s
        self._board.publish(ending.board)
        self._roster.publish()
        if ending.grid is not None:
            try:
                await self._shared_map.show(codec.decode(ending.grid, TeamGrid))
            except codec.CodecError as error:
                log.error("a map could not be read", mission_id=self._mission_id, reason=str(error))
        return True

    async def forget(self) -> None:
        """Drop what is left: the mission goes on."""
        try:
            await self._store.missions.record_ending(self._mission_id, None)
        except DatabaseError as error:  # it is replaced when the mission is closed again
            log.warning("an ending could not be dropped", mission_id=self._mission_id, reason=str(error))
