"""The map that the team makes together, as it is saved and shown; everything on it moves with it."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Set
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np

from db.store import Store
from robots.se2 import Array
from robots.team import TeamGrid, TeamTag, TeamUpdate
from robots.types import AgentUpdate, SubmapReport
from server.agents.process import ForkServer
from server.agents.team import TeamHost
from server.board import Board
from server.map_image import MapImage, draw
from server.mission.doubts import Doubts
from server.mission.roster import Roster
from server.mission.told_victims import ToldVictims
from server.mission.victims import Victims
from server.robot import Robot
from server.sharing import map_value, tag_record, tag_value, team_values


class SharedMap:
    """The team map. ``image`` is its latest picture; ``on_grid`` is told of every new one."""

    def __init__(
        self,
        store: Store,
        forks: ForkServer,
        board: Board,
        roster: Roster,
        victims: Victims,
        told: ToldVictims,
        doubts: Doubts,
        on_grid: Callable[[str, TeamGrid], None],
    ) -> None:
        self.image: MapImage | None = None
        self._store = store
        self._board = board
        self._roster = roster
        self._victims = victims
        self._told = told
        self._doubts = doubts
        self._on_grid = on_grid
        self._grid: TeamGrid | None = None
        self._mission_id = roster.record.mission_id
        self._team = TeamHost(forks, self._take, name=self._mission_id)

    @property
    def pid(self) -> int | None:
        """The process that holds the team map now."""
        return self._team.pid

    @property
    def grid(self) -> TeamGrid | None:
        """The latest fused map; None before the first."""
        return self._grid

    async def restore(self) -> None:
        """Show the tags of the database; the map itself comes when the agents have caught up."""
        tags = await self._store.tags.tags_of(self._mission_id)
        self._board.publish({f"tag/{tag.tag_id}": tag_value(tag) for tag in tags})
        await self._doubts.restore(tags)

    def begin(self) -> None:
        """Solve from now on; before that, robots and their updates are only collected."""
        self._team.begin()

    def add(self, robot: Robot) -> None:
        """Add a robot, with its surveyed start if there is one."""
        self._team.add_robot(robot.robot_id, robot.record.start_pose)

    def put(self, robot: Robot, update: AgentUpdate) -> None:
        """Take over an agent's update."""
        self._team.put(robot.robot_id, update)

    def way(self, robot_id: str, until_seq: int) -> Array:
        """Return where a robot was up to an observation; see ``TeamHost.way``."""
        return self._team.way(robot_id, until_seq)

    async def settle(self, longest_s: float) -> None:
        """Wait until the map holds all that it was given, but not for ever."""
        with suppress(TimeoutError):
            async with asyncio.timeout(longest_s):
                await self._team.settled()

    async def show(self, grid: TeamGrid) -> None:
        """Show a map that was made before."""
        self._grid = grid
        self.image = await asyncio.to_thread(draw, replace(grid, version=self._next_version()))
        self._board.publish({"map": map_value(self._mission_id, self.image)})
        self._on_grid(self._mission_id, grid)

    def submaps(self, robot_id: str) -> list[SubmapReport]:
        """Return the latest submaps of a robot."""
        return self._team.submaps(robot_id)

    async def close(self) -> None:
        """End the process."""
        await self._team.close()

    async def _take(self, update: TeamUpdate) -> None:
        """Save a new solution, then show it."""
        absent = self._roster.absent()
        tags = [tag_record(tag) for tag in update.tags]
        await self._store.tags.record_tags(self._mission_id, tags)
        await self._victims.take(update.victims, absent)
        await self._victims.follow({tag.tag_id: tag for tag in tags})
        values: dict[str, dict[str, Any] | None] = dict(team_values(update))
        values |= {f"tag/{tag_id}": None for tag_id in self._vanished(update.tags, absent)}
        values |= {f"tag/{tag.tag_id}": tag_value(tag) for tag in tags}
        if update.grid is not None and not _same(update.grid, self._grid):
            await self.show(update.grid)
        robots = self._roster.robots
        for member in update.robots:
            if member.robot_id in robots:
                robots[member.robot_id].anchors = member.anchors
                robots[member.robot_id].located = member.located
                robots[member.robot_id].anchor_covariance = member.covariance
        self._board.publish(values)
        self._roster.publish(robots.values())
        await self._doubts.take(update.notices, absent)
        await self._told.settle()

    def _vanished(self, tags: tuple[TeamTag, ...], absent: Set[str]) -> list[str]:
        """Return the tags on the board that are no longer there, as far as those who saw them are heard."""
        now = {tag.tag_id for tag in tags}
        return [
            tag["tag_id"]
            for tag in self._board.of_kind("tag")
            if tag["tag_id"] not in now and not absent & set(tag["robots"])
        ]

    def _next_version(self) -> int:
        # By the clock: whoever still has the picture from before a restart of the server or of the team's
        # process sees that this is another one.
        now = int(time.time() * 1000.0)
        return now if self.image is None else max(now, self.image.version + 1)


def _same(grid: TeamGrid, other: TeamGrid | None) -> bool:
    return other is not None and grid.origin_m == other.origin_m and np.array_equal(grid.cells, other.cells)
