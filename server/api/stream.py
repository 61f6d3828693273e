"""The stream: a snapshot of the board, then its changes as they come; the latest state of a key wins."""

from __future__ import annotations

import asyncio
from contextlib import suppress

from fastapi import APIRouter, WebSocket, WebSocketDisconnect

from server.errors import ApiError
from server.guard import is_same_origin
from server.mission.mission import Mission
from server.missions import Missions
from server.people.access import Access
from server.people.actor import Actor

router = APIRouter(prefix="/missions/{mission_id}")
_SEND_S = 10.0  # who takes longer to accept a message is not reading any more
_NOT_LOGGED_IN, _FOREIGN, _UNKNOWN = 4401, 4403, 4404
_CODES = {401: _NOT_LOGGED_IN, 403: _FOREIGN, 404: _UNKNOWN}


@router.websocket("/stream")
async def stream(websocket: WebSocket, mission_id: str) -> None:
    """Send a snapshot, then coalesced changes, and an empty change each second as a heartbeat."""
    found = await entered(websocket, mission_id)
    if found is None:
        return
    mission, actor = found
    listening = asyncio.create_task(_until_over(websocket, actor))
    try:
        with (
            mission.presence.of(actor),
            mission.broadcast.listener() as listener,
            suppress(WebSocketDisconnect, RuntimeError, TimeoutError),
        ):
            await _send(websocket, mission.broadcast.snapshot_text())
            while not listening.done():
                await _send(websocket, await listener.next_text())
    finally:
        listening.cancel()
        with suppress(WebSocketDisconnect, RuntimeError, TimeoutError):
            code, reason = (
                (_NOT_LOGGED_IN, "you have been logged out") if actor.over.is_set() else (1000, None)
            )
            await asyncio.wait_for(websocket.close(code, reason), 1.0)


async def entered(websocket: WebSocket, mission_id: str) -> tuple[Mission, Actor] | None:
    """Accept a socket of those who may see the mission; close any other with the reason, and return None."""
    missions: Missions = websocket.app.state.missions
    access: Access = websocket.app.state.access
    if not is_same_origin(websocket.headers):
        await websocket.close(_FOREIGN, "this page belongs to another server")
        return None
    try:
        actor = access.actor_of(websocket)
        mission = missions.get(mission_id)
        if not actor.is_for(mission_id):
            raise ApiError(403, "other_scope", "This token is for another mission.")
    except ApiError as error:
        await websocket.accept()
        await websocket.close(_CODES[error.status], error.message)
        return None
    await websocket.accept()
    return mission, actor


async def _send(websocket: WebSocket, text: str) -> None:
    async with asyncio.timeout(_SEND_S):
        await websocket.send_text(text)


async def _until_over(websocket: WebSocket, actor: Actor) -> None:
    """Wait until the other side closes, or whoever it is has been logged out."""
    waits = {asyncio.create_task(_until_closed(websocket)), asyncio.create_task(actor.over.wait())}
    try:
        await asyncio.wait(waits, return_when=asyncio.FIRST_COMPLETED)
    finally:
        for wait in waits:
            wait.cancel()


async def _until_closed(websocket: WebSocket) -> None:
    """Read until the other side closes; whatever it sends is of no interest."""
    with suppress(RuntimeError):
        while (await websocket.receive())["type"] != "websocket.disconnect":
            pass
