"""The 3D scenes of missions, one for each theme that somebody looks at: fed from the board until stopped."""

from __future__ import annotations

import asyncio
import secrets
from collections.abc import AsyncIterator, Mapping, Sequence
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


class _Running:
    """What a mission's scenes are made of, those looked at so far, and the tasks that keep them in step."""

    def __init__(self, board: Board) -> None:
        self.board = board
        self.map: tuple[Cells, tuple[float, float], float] | None = None
        self.scenes: dict[str, MissionScene] = {}
        self.tasks: list[asyncio.Task[None]] = []
        self._loop = asyncio.get_running_loop()

    def scene(self, theme: str) -> MissionScene:
        """Return the scene in a theme; the first who asks opens it, from any thread."""
        if found := self.scenes.get(theme):
            return found
        scene = self.scenes[theme] = MissionScene(theme)
        if self.map is not None:
            scene.update_map(*self.map)
        self._loop.call_soon_threadsafe(self._keep, scene)
        return scene

    def _keep(self, scene: MissionScene) -> None:
        self.tasks += [asyncio.create_task(scene.run()), asyncio.create_task(_feed(scene, self.board))]


class Scenes:
    """Finds and stops the scenes of missions. Opening one costs milliseconds and half a megabyte."""

    def __init__(self) -> None:
        self._running: dict[str, _Running] = {}
        self._past: dict[str, PastScene] = {}

    async def start(self, mission_id: str, board: Board) -> None:
        """Show the mission's board to whoever looks; a second call changes nothing."""
        self._running.setdefault(mission_id, _Running(board))

    def port(self, mission_id: str, theme: str = "dark") -> int | None:
        """Return the loopback port of a scene, of a mission in a theme or of its past; None for none."""
        if past := self._past.get(mission_id):
            port: int = past.scene.port
            return port
        running = self._running.get(mission_id)
        return running.scene(theme).port if running and theme in THEMES else None

    def update_map(
        self, mission_id: str, cells: Cells, origin_m: tuple[float, float], resolution_m: float
    ) -> None:
        """Give a mission's scene its fused map: int8 (h, w), -1 unknown, 0..100; row 0 at the lowest y."""
        if running := self._running.get(mission_id):
            running.map = cells, origin_m, resolution_m
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


async def _feed(scene: MissionScene, board: Board) -> None:
    """Pass the board's state and then its changes on to a scene."""
    changes = board.subscribe()
    scene.replace(board.snapshot())
    async for values, deleted in changes:
        for key, value in values.items():
            scene.put(key, value)
        for key in deleted:
            scene.put(key, None)
