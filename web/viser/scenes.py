"""The 3D scenes of all missions that run: each fed from its mission's board until it is stopped."""

from __future__ import annotations

import asyncio
import secrets
from collections.abc import AsyncIterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from web.viser.colors import THEMES
from web.viser.map_layer import Cells, Grid
from web.viser.scene import MissionScene

MAX_PAST_SCENES = 12


class Board(Protocol):
    """What a scene needs of a mission's board: where it stands, and what changes after that."""

    def snapshot(self) -> dict[str, dict[str, Any]]:
        """Return the value of every key."""

    def subscribe(self) -> AsyncIterator[tuple[Mapping[str, dict[str, Any]], Sequence[str]]]:
        """Return an iterator of changes: values that were set, keys that were deleted."""


class PastScene:
    """A scene of one viewer's own, that shows what it is told to; ``key`` stands for it in addresses."""

    def __init__(self, mission_id: str, theme: str) -> None:
        self.key = f"{mission_id}@{secrets.token_hex(12)}"  # no mission's id holds an @
        self.scene = MissionScene(theme)

    async def show(self, state: dict[str, dict[str, Any]], grid: Grid | None) -> None:
        """Draw a state of the board, and its map where that is another than before."""
        await asyncio.to_thread(self.scene.show, state, grid)


@dataclass(frozen=True, slots=True)
class _Running:
    """A mission's scene in each theme, and the tasks that keep them up to date."""

    scenes: Mapping[str, MissionScene]
    tasks: tuple[asyncio.Task[None], ...]


class Scenes:
    """Starts, finds and stops the scene of a mission. Starting costs milliseconds and half a megabyte."""

    def __init__(self) -> None:
        self._running: dict[str, _Running] = {}
        self._past: dict[str, PastScene] = {}

    async def start(self, mission_id: str, board: Board) -> None:
        """Open a scene for the mission and keep it in step with the board; a second call changes nothing."""
        if mission_id in self._running:
            return
        scenes = {theme: MissionScene(theme) for theme in THEMES}
        drawing = [asyncio.create_task(scene.run()) for scene in scenes.values()]
        tasks = (asyncio.create_task(_feed(tuple(scenes.values()), board)), *drawing)
        self._running[mission_id] = _Running(scenes, tasks)

    def port(self, mission_id: str, theme: str = "dark") -> int | None:
        """Return the loopback port of a scene, of a mission in a theme or of its past; None for none."""
        if past := self._past.get(mission_id):
            port: int = past.scene.port
            return port
        running = self._running.get(mission_id)
        scene = running.scenes.get(theme) if running else None
        return scene.port if scene else None

    def update_map(
        self, mission_id: str, cells: Cells, origin_m: tuple[float, float], resolution_m: float
    ) -> None:
        """Give a mission's scene its fused map: int8 (h, w), -1 unknown, 0..100; row 0 at the lowest y."""
        if running := self._running.get(mission_id):
            for scene in running.scenes.values():
                scene.update_map(cells, origin_m, resolution_m)

    async def stop(self, mission_id: str) -> None:
        """Close a mission's scene; nothing when it has none."""
        running = self._running.pop(mission_id, None)
        if running is None:
            return
        for task in running.tasks:
            task.cancel()
        await asyncio.gather(*running.tasks, return_exceptions=True)
        await asyncio.gather(*(asyncio.to_thread(scene.stop) for scene in running.scenes.values()))

    def open_past(self, mission_id: str, theme: str) -> PastScene | None:
        """Open a scene for somebody who looks at a mission's past; None where there are too many."""
        if len(self._past) >= MAX_PAST_SCENES:
            return None
        scene = PastScene(mission_id, theme if theme in THEMES else "dark")
        self._past[scene.key] = scene
        return scene

    async def close_past(self, scene: PastScene) -> None:
        """Close a scene of the past."""
        self._past.pop(scene.key, None)
        await asyncio.to_thread(scene.scene.stop)

    async def close(self) -> None:
        """Close every scene."""
        await asyncio.gather(*(self.close_past(scene) for scene in tuple(self._past.values())))
        await asyncio.gather(*(self.stop(mission_id) for mission_id in tuple(self._running)))


async def _feed(scenes: Sequence[MissionScene], board: Board) -> None:
    """Pass the board's state and then its changes on to the scenes."""
    changes = board.subscribe()
    for scene in scenes:
        scene.replace(board.snapshot())
    async for values, deleted in changes:
        for scene in scenes:
            for key, value in values.items():
                scene.put(key, value)
            for key in deleted:
                scene.put(key, None)
