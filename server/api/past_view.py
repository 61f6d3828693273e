"""Looking at a mission's past in 3D: a scene of one's own, that shows the moment one asks for."""

from __future__ import annotations

import asyncio
from contextlib import suppress

import structlog
from fastapi import APIRouter, WebSocket, WebSocketDisconnect

from db.errors import DatabaseError
from server.api.stream import entered
from server.history.film import grid_of
from server.history.past import Past
from server.missions import Missions
from server.people.actor import Actor
from web.viser.scenes import PastScene, Scenes

router = APIRouter(prefix="/missions/{mission_id}/history")
_FULL, _NOT_LOGGED_IN = 4429, 4401
_SEND_S = 10.0
_LONGEST_MESSAGE = 64

log = structlog.get_logger()


@router.websocket("/view")
async def view(websocket: WebSocket, mission_id: str, theme: str = "dark") -> None:
    """Say where the scene is (`{"scene": address}`); it shows the moment that was sent last, in Unix seconds.

    The scene ends with the socket.
    """
    found = await entered(websocket, mission_id)
    if found is None:
        return
    _, actor = found
    missions: Missions = websocket.app.state.missions
    scenes: Scenes = websocket.app.state.scenes
    scene = scenes.open_past(mission_id, theme)
    if scene is None:
        await websocket.close(_FULL, "too many people look at the past in 3D; close another page or use 2D")
        return
    showing = asyncio.create_task(_show(websocket, Past(missions.store, mission_id), scene))
    logged_out = asyncio.create_task(_leave(websocket, actor))
    try:
        await showing
    finally:
        logged_out.cancel()
        await scenes.close_past(scene)


async def _show(websocket: WebSocket, past: Past, scene: PastScene) -> None:
    wanted: asyncio.Queue[float] = asyncio.Queue()
    listening = asyncio.create_task(_listen(websocket, wanted))
    version = None
    try:
        with suppress(WebSocketDisconnect, RuntimeError, TimeoutError):
            await asyncio.wait_for(websocket.send_json({"scene": scene.key}), _SEND_S)
            while True:
                moment = asyncio.ensure_future(wanted.get())
                await asyncio.wait({moment, listening}, return_when=asyncio.FIRST_COMPLETED)
                if not moment.done():
                    moment.cancel()
                    return
                unix_s = moment.result()
                while not wanted.empty():  # only the latest counts
                    unix_s = wanted.get_nowait()
                version = await _draw(past, scene, unix_s, version)
                await asyncio.wait_for(websocket.send_json({"shown_unix_s": unix_s}), _SEND_S)
    finally:
        listening.cancel()


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


async def _listen(websocket: WebSocket, wanted: asyncio.Queue[float]) -> None:
    """Take in moments until the other side closes; anything else ends it."""
    with suppress(WebSocketDisconnect, RuntimeError, KeyError, ValueError):
        while True:
            text = await websocket.receive_text()
            moment = float(text) if len(text) <= _LONGEST_MESSAGE else -1.0
            if not 0.0 <= moment <= 1e11:
                return
            wanted.put_nowait(moment)


async def _leave(websocket: WebSocket, actor: Actor) -> None:
    await actor.over.wait()
    with suppress(RuntimeError):
        await websocket.close(_NOT_LOGGED_IN, "you have been logged out")
