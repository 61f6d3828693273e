"""Looking at a mission's past in 3D: a scene of one's own, that shows the moment one asks for."""

from __future__ import annotations

import asyncio
from contextlib import suppress

import structlog
from fastapi import APIRouter, WebSocket, WebSocketDisconnect

from db.errors import DatabaseError
from server.api.seats import FULL, NOT_LOGGED_IN, Line, read, tell_clicks, until_first
from server.api.stream import entered
from server.history.film import grid_of
from server.history.past import Past
from server.missions import Missions
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
    _, actor = found
    missions: Missions = websocket.app.state.missions
    scenes: Scenes = websocket.app.state.scenes
    scene = scenes.open_past(mission_id, theme, actor.over)
    if scene is None:
        await websocket.close(FULL, "too many people look at the past in 3D; close another page or use 2D")
        return
    line, past = Line(websocket), Past(missions.store, mission_id)
    wanted: asyncio.Queue[float] = asyncio.Queue()
    try:
        await until_first(
            _listen(websocket, scene, wanted),
            _show(line, past, scene, wanted),
            tell_clicks(line, scene.seat),
            actor.over.wait(),
        )
    finally:
        await scenes.close_past(scene)
    with suppress(WebSocketDisconnect, RuntimeError):
        await websocket.close(
            *(NOT_LOGGED_IN, "you have been logged out") if actor.over.is_set() else (1008,)
        )


async def _show(line: Line, past: Past, scene: PastScene, wanted: asyncio.Queue[float]) -> None:
    version = None
    with suppress(WebSocketDisconnect, RuntimeError, TimeoutError):
        await line.send({"scene": scene.seat.key})
        while True:
            unix_s = await wanted.get()
            while not wanted.empty():  # only the latest counts
                unix_s = wanted.get_nowait()
            version = await _draw(past, scene, unix_s, version)
            await line.send({"shown_unix_s": unix_s})


async def _draw(past: Past, scene: PastScene, unix_s: float, version: int | None) -> int | None:
    """Show a moment; return the version of the map that is shown."""
    try:
        found = await past.state_at(unix_s)
        state = {} if found is None else found[1]
        shown = state.get("map")
        png = None
        if shown is not None and shown["version"] != version:
            png = await past.picture(shown["version"])
    except DatabaseError as error:
        log.error("the past could not be shown in 3D", reason=str(error))
        return version
    grid = None if shown is None or png is None else await asyncio.to_thread(grid_of, shown, png)
    await scene.show(state, grid)
    return version if grid is None or shown is None else int(shown["version"])


async def _listen(websocket: WebSocket, scene: PastScene, wanted: asyncio.Queue[float]) -> None:
    """Take in moments and wishes until the other side closes; anything else ends it."""
    while (told := await read(websocket)) is not None:
        if told.unix_s is not None:
            wanted.put_nowait(told.unix_s)
        else:
            scene.seat.wish = told.wish()
