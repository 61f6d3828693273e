"""The 3D scenes of missions, one for each theme that somebody looks at: fed from the board until stopped."""

from __future__ import annotations

import asyncio
import secrets
from collections.abc import AsyncIterator, Mapping, Sequence
from typing import Any, Protocol

from web.viser.colors import THEMES
from web.viser.map_layer import Cells, Grid
from web.viser.scene import MissionScene
from web.viser.seats import Seat, is_seat, mission_of, seat_name

MAX_PAST_SCENES = 12
MAX_SEATS = 64
"""As many pages a mission may have its 3D view at the same time."""


class Board(Protocol):
    """What a scene needs of a mission's board: where it stands, and what changes after that."""

    def snapshot(self) -> dict[str, dict[str, Any]]:
        """Return the value of every key."""

    def subscribe(self) -> AsyncIterator[tuple[Mapping[str, dict[str, Any]], Sequence[str]]]:
        """Return an iterator of changes: values that were set, keys that were deleted."""


class BaseMap(Protocol):
    """What was known of the building before."""

    @property
    def cells(self) -> Cells:
        """-1 unknown, 0..100, row 0 at the lowest y."""

    @property
    def origin_m(self) -> tuple[float, float]:
        """The corner of cell (0, 0), x and y in metres."""

    @property
    def resolution_m(self) -> float:
        """The side of a cell."""


class PastScene:
    """A scene of one viewer's own, that shows what it is told to; in addresses stands its seat's key."""

    def __init__(self, seat: Seat, theme: str) -> None:
        self.seat = seat
        self.scene = MissionScene(theme, seats={seat.key: seat})
        self._running = asyncio.create_task(self.scene.run())  # for marks; states are shown when asked for

    async def show(self, state: dict[str, dict[str, Any]], grid: Grid | None) -> None:
        """Draw a state of the board, and its map where that is another than before."""
        await self.scene.show(state, grid)

    def update_base(self, grid: Grid | None) -> None:
        """Take the base map of the next state that is shown."""
        self.scene.update_base(grid)

    async def close(self) -> None:
        """End it."""
        self._running.cancel()
        await asyncio.gather(self._running, return_exceptions=True)
        await asyncio.to_thread(self.scene.stop)


class _Running:
    """What a mission's scenes are made of, those looked at so far, and the tasks that keep them in step."""

    def __init__(self, board: Board, seats: Mapping[str, Seat]) -> None:
        self.board = board
        self.seats = seats
        self.map: tuple[Cells, tuple[float, float], float] | None = None
        self.base: Grid | None = None
        self.scenes: dict[str, MissionScene] = {}
        self.tasks: list[asyncio.Task[None]] = []
        self._loop = asyncio.get_running_loop()

    def scene(self, theme: str) -> MissionScene:
        """Return the scene in a theme; the first who asks opens it, from any thread."""
        if found := self.scenes.get(theme):
            return found
        scene = self.scenes[theme] = MissionScene(theme, seats=self.seats)
        if self.map is not None:
            scene.update_map(*self.map)
        if self.base is not None:
            scene.update_base(self.base)
        self._loop.call_soon_threadsafe(self._keep, scene)
        return scene

    def _keep(self, scene: MissionScene) -> None:
        self.tasks += [asyncio.create_task(scene.run()), asyncio.create_task(_feed(scene, self.board))]


class Scenes:
    """Finds and stops the scenes of missions. Opening one costs milliseconds and half a megabyte."""

    def __init__(self) -> None:
        self._running: dict[str, _Running] = {}
        self._past: dict[str, PastScene] = {}
        self._seats: dict[str, Seat] = {}  # of missions as they are

    async def start(self, mission_id: str, board: Board) -> None:
        """Show the mission's board to whoever looks; a second call changes nothing."""
        self._running.setdefault(mission_id, _Running(board, self._seats))

    def port(self, key: str, theme: str = "dark") -> int | None:
        """Return the loopback port of a scene, None for none.

        ``key``: a mission's id, or the key of a seat before its scene or its past.
        """
        if past := self._past.get(key):
            port: int = past.scene.port
            return port
        running = self._running.get(mission_of(key)) if key in self._seats or not is_seat(key) else None
        return running.scene(theme).port if running and theme in THEMES else None

    def may_sit(self, key: str, over: asyncio.Event) -> bool:
        """Say whether a session may open the view by this key: a seat is for the session that took it."""
        past = self._past.get(key)
        seat = self._seats.get(key) if past is None else past.seat
        return not is_seat(key) if seat is None else seat.over is over

    def take_seat(self, mission_id: str, secret: str, over: asyncio.Event) -> Seat | None:
        """Take a seat before a mission's scene; None where there are too many, or it is another session's.

        Taken again, by a page that lost its connection, it is the page's that came last.
        """
        key = seat_name(mission_id, secret)
        before = self._seats.get(key)
        if before is None:
            if sum(mission_of(taken) == mission_id for taken in self._seats) >= MAX_SEATS:
                return None
        elif before.over is not over:
            return None
        else:
            before.gone.set()
        seat = self._seats[key] = Seat(key, over)
        return seat

    def leave_seat(self, seat: Seat) -> None:
        """Give a seat back."""
        if self._seats.get(seat.key) is seat:
            del self._seats[seat.key]

    def update_map(
        self, mission_id: str, cells: Cells, origin_m: tuple[float, float], resolution_m: float
    ) -> None:
        """Give a mission's scene its fused map: int8 (h, w), -1 unknown, 0..100; row 0 at the lowest y."""
        if running := self._running.get(mission_id):
            running.map = cells, origin_m, resolution_m
            for scene in running.scenes.values():
                scene.update_map(cells, origin_m, resolution_m)

    def update_base(self, mission_id: str, grid: BaseMap | None) -> None:
        """Give a mission's scene its base map, None where there is none any more."""
        if running := self._running.get(mission_id):
            running.base = None if grid is None else Grid(grid.cells, grid.origin_m, grid.resolution_m)
            for scene in running.scenes.values():
                scene.update_base(running.base)

    async def stop(self, mission_id: str) -> None:
        """Close a mission's scene; nothing when it has none."""
        running = self._running.pop(mission_id, None)
        if running is None:
            return
        for task in running.tasks:
            task.cancel()
        await asyncio.gather(*running.tasks, return_exceptions=True)
        await asyncio.gather(*(asyncio.to_thread(scene.stop) for scene in running.scenes.values()))

    def open_past(self, mission_id: str, theme: str, over: asyncio.Event) -> PastScene | None:
        """Open a scene for somebody who looks at a mission's past; None where there are too many."""
        if len(self._past) >= MAX_PAST_SCENES:
            return None
        seat = Seat(seat_name(mission_id, secrets.token_hex(16)), over)
        scene = self._past[seat.key] = PastScene(seat, theme if theme in THEMES else "dark")
        return scene

    async def close_past(self, scene: PastScene) -> None:
        """Close a scene of the past."""
        self._past.pop(scene.seat.key, None)
        await scene.close()

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
