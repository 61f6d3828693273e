"""Looking at a mission's past in 3D: a scene of one's own, that shows the moment one asks for."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from contextlib import suppress

import structlog
from fastapi import APIRouter, WebSocket, WebSocketDisconnect

from db.errors import DatabaseError
from server.api.seats import FULL, NOT_LOGGED_IN, Line, read, tell_clicks, until_first
from server.api.stream import entered
from server.history.changes import Value
from server.history.film import grid_of
from server.history.past import Past
from server.map_image import MapImage
from server.missions import Missions
from web.viser.map_layer import Grid
from web.viser.scenes import PastScene, Scenes

router = APIRouter(prefix="/missions/{mission_id}/history")

log = structlog.get_logger()


@router.websocket("/view")
async def view(websocket: WebSocket, mission_id: str, theme: str = "dark") -> None:
    """Say where the scene is (`{"scene": address}`) and what is clicked in it; take moments and what to mark.

    It shows the moment that was sent last (`{"unix_s": 1.7e9}`). The scene ends with the socket.
    """
    found = await entered(websocket, mission_id)
    if found is None:
        return
    mission, actor = found
    missions: Missions = websocket.app.state.missions
    scenes: Scenes = websocket.app.state.scenes
    scene = scenes.open_past(mission_id, theme, actor.over)
    if scene is None:
        await websocket.close(FULL, "too many people look at the past in 3D; close another page or use 2D")
        return
    line = Line(websocket)
    moments = _Moments(Past(missions.store, mission_id), scene, lambda: mission.base_map.image)
    wanted: asyncio.Queue[float] = asyncio.Queue()
    try:
        await until_first(
            _listen(websocket, scene, wanted),
            _show(line, moments, scene, wanted),
            tell_clicks(line, scene.seat),
            actor.over.wait(),
        )
    finally:
        await scenes.close_past(scene)
    with suppress(WebSocketDisconnect, RuntimeError):
        await websocket.close(
            *(NOT_LOGGED_IN, "you have been logged out") if actor.over.is_set() else (1008,)
        )


class _Moments:
    """Draws moments of a mission's past; ``base`` gives its base map, as it is now."""

    def __init__(self, past: Past, scene: PastScene, base: Callable[[], MapImage | None]) -> None:
        self._past = past
        self._scene = scene
        self._base = base
        self._versions: dict[str, int | None] = {"map": None, "base_map": None}

    async def draw(self, unix_s: float) -> None:
        """Show a moment."""
        try:
            found = await self._past.state_at(unix_s)
            state = {} if found is None else found[1]
            grid = await self._map_of(state)
        except DatabaseError as error:
            log.error("the past could not be shown in 3D", reason=str(error))
            return
        await self._put_base(state)
        await self._scene.show(state, grid)

    async def _map_of(self, state: dict[str, Value]) -> Grid | None:
        """Return the map of a state, None where it is shown already or its picture was not kept."""
        shown = state.get("map")
        if shown is None or shown["version"] == self._versions["map"]:
            return None
        png = await self._past.picture(shown["version"])
        if png is None:
            return None
        self._versions["map"] = shown["version"]
        return await asyncio.to_thread(grid_of, shown, png)

    async def _put_base(self, state: dict[str, Value]) -> None:
        """Lay the base map of a state under it; one that was replaced since is not kept."""
        shown, image = state.get("base_map"), self._base()
        version = None if shown is None else shown["version"]
        if version == self._versions["base_map"]:
            return
        grid = None
        if shown is not None and image is not None and image.version == version:
            grid = await asyncio.to_thread(grid_of, shown, image.png)
        self._scene.update_base(grid)
        self._versions["base_map"] = version


async def _show(line: Line, moments: _Moments, scene: PastScene, wanted: asyncio.Queue[float]) -> None:
    with suppress(WebSocketDisconnect, RuntimeError, TimeoutError):
        await line.send({"scene": scene.seat.key})
        while True:
            unix_s = await wanted.get()
            while not wanted.empty():  # only the latest counts
                unix_s = wanted.get_nowait()
            await moments.draw(unix_s)
            await line.send({"shown_unix_s": unix_s})


async def _listen(websocket: WebSocket, scene: PastScene, wanted: asyncio.Queue[float]) -> None:
    """Take in moments and wishes until the other side closes; anything else ends it."""
    while (told := await read(websocket)) is not None:
        if told.unix_s is not None:
            wanted.put_nowait(told.unix_s)
        else:
            scene.seat.wish = told.wish()
