"""All missions of this server."""

from __future__ import annotations

import asyncio
import re
import secrets
import time
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from db.records import MissionRecord
from db.store import Store
from robots.team import TeamGrid
from server.agents.process import ForkServer
from server.board import Board
from server.errors import ApiError, unknown
from server.mission.mission import Mission
from server.settings import Settings


class Scenes(Protocol):
    """Something that shows missions in 3D."""

    async def start(self, mission_id: str, board: Board) -> None:
        """Show a mission from now on."""

    def update_map(
        self, mission_id: str, cells: NDArray[np.int8], origin_m: tuple[float, float], resolution_m: float
    ) -> None:
        """Take over a new fused map."""

    def update_base(self, mission_id: str, grid: TeamGrid | None) -> None:
        """Take over a base map, None when it is taken away."""


class Missions:
    """Opens missions, finds them, and brings them back after a restart."""

    def __init__(self, store: Store, forks: ForkServer, settings: Settings, scenes: Scenes) -> None:
        self._store = store
        self._forks = forks
        self._settings = settings
        self._scenes = scenes
        self._missions: dict[str, Mission] = {}
        self._opening = asyncio.Lock()
        self._stepping: dict[str, asyncio.Lock] = {}

    @property
    def store(self) -> Store:
        """The database, for what is only read."""
        return self._store

    def __len__(self) -> int:
        return len(self._missions)

    def all(self) -> list[Mission]:
        """Return the missions, oldest first."""
        return list(self._missions.values())

    def get(self, mission_id: str) -> Mission:
        """Return a mission.

        Raises:
            ApiError: there is none of that id.
        """
        if mission_id not in self._missions:
            raise unknown("mission", mission_id)
        return self._missions[mission_id]

    def find(self, mission_id: str) -> Mission | None:
        """Return a mission, None where there is none of that id."""
        return self._missions.get(mission_id)

    async def restore(self) -> None:
        """Bring back every mission of the database."""
        for record in await self._store.missions.all_missions():
            mission = await self._add(record)
            await mission.restore()

    async def open(
        self,
        name: str,
        mission_id: str | None,
        tag_key: str | None = None,
        state: Literal["draft", "running"] = "running",
        by: str = "",
    ) -> Mission:
        """Open a mission; without a key for its tags one is made at random.

        Raises:
            ApiError: there is a mission of that id already.
        """
        async with self._opening:
            if mission_id is not None and mission_id in self._missions:
                raise ApiError(
                    409,
                    "mission_exists",
                    f"There is a mission {mission_id!r} already; join it, or choose another mission_id.",
                    "mission_id",
                )
            key = secrets.token_hex(16) if tag_key is None else tag_key
            mission_id = mission_id or self._id_for(name)
            now = time.time()
            record = MissionRecord(
                mission_id, name, state, now, tag_key=key, state_by=by, state_unix_s=now,
                started_unix_s=now if state == "running" else None,
            )  # fmt: skip
            await self._store.missions.create_mission(record)
            mission = await self._add(record)
            mission.begin()
        await mission.events.tell("mission_opened", f"{name} was opened.")
        return mission

    async def take(self, mission_id: str, step: str, by: str) -> Mission:
        """Take a mission to another state; see ``lifecycle.STEPS``.

        One that is over keeps what it came to and ends its processes; one that is reopened begins again
        where its log ends.

        Raises:
            ApiError: there is no such mission, or the step does not follow from its state.
        """
        async with self._stepping.setdefault(mission_id, asyncio.Lock()):
            mission = self.get(mission_id)
            was_over = mission.roster.record.is_over
            if not await mission.lifecycle.take(step, by):
                return mission
            if not was_over and mission.roster.record.is_over:
                await mission.rest()
            elif was_over and not mission.roster.record.is_over:
                mission = await self._again(mission)
            return mission

    async def close(self) -> None:
        """End every mission's processes; the database keeps them."""
        await asyncio.gather(*(mission.close() for mission in self._missions.values()))

    async def _again(self, over: Mission) -> Mission:
        """Return a mission with agents in the place of one that is over, before the same eyes."""
        await over.close()
        mission = Mission(
            over.roster.record, self._store, self._forks, self._settings, self._on_grid,
            self._scenes.update_base, over.board,
        )  # fmt: skip
        mission.presence = over.presence
        await mission.go_on()
        self._missions[mission.mission_id] = mission
        return mission

    async def _add(self, record: MissionRecord) -> Mission:
        mission = Mission(
            record, self._store, self._forks, self._settings, self._on_grid, self._scenes.update_base
        )
        self._missions[record.mission_id] = mission
        await self._scenes.start(record.mission_id, mission.board)
        return mission

    def _on_grid(self, mission_id: str, grid: TeamGrid) -> None:
        self._scenes.update_map(mission_id, grid.cells, grid.origin_m, grid.resolution_m)

    def _id_for(self, name: str) -> str:
        stem = re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-")[:40] or "mission"
        candidates = [stem, *(f"{stem}-{k}" for k in range(2, len(self._missions) + 3))]
        return next(candidate for candidate in candidates if candidate not in self._missions)
