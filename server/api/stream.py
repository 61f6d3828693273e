"""The stream: a snapshot of the board, then its changes as they come; the latest state of a key wins."""

from __future__ import annotations

import asyncio
import time
from contextlib import suppress

from fastapi import APIRouter, WebSocket, WebSocketDisconnect

from server.errors import ApiError
from server.guard import is_same_origin
from server.missions import Missions

router = APIRouter(prefix="/missions/{mission_id}")
_PAUSE_S = 0.02  # changes are sent at most this often
_HEARTBEAT_S = 1.0
_SEND_S = 10.0  # who takes longer to accept a message is not reading any more
_UNKNOWN, _FOREIGN = 4404, 4403


@router.websocket("/stream")
async def stream(websocket: WebSocket, mission_id: str) -> None:
    """Send a snapshot, then coalesced changes, and an empty change each second as a heartbeat."""
    missions: Missions = websocket.app.state.missions
    if not is_same_origin(websocket.headers):
        await websocket.close(_FOREIGN, "this page belongs to another server")
        return
    try:
        board = missions.get(mission_id).board
    except ApiError as error:
        await websocket.accept()
        await websocket.close(_UNKNOWN, error.message)
        return
    await websocket.accept()
    listening = asyncio.create_task(_until_closed(websocket))
    try:
        with board.subscribe() as subscription, suppress(WebSocketDisconnect, RuntimeError, TimeoutError):
            text = '{"type":"snapshot","server_unix_s":%.3f,"state":%s}'
            await _send(websocket, text % (time.time(), board.snapshot_text()))
            while not listening.done():
                keys = await subscription.next_keys(_HEARTBEAT_S)
                there, gone = board.changes_text(keys)
                text = '{"type":"changes","server_unix_s":%.3f,"set":%s,"delete":%s}'
                await _send(websocket, text % (time.time(), there, gone))
                await asyncio.sleep(_PAUSE_S)
    finally:
        listening.cancel()
        with suppress(WebSocketDisconnect, RuntimeError, TimeoutError):
            await asyncio.wait_for(websocket.close(), 1.0)


async def _send(websocket: WebSocket, text: str) -> None:
    await asyncio.wait_for(websocket.send_text(text), _SEND_S)


async def _until_closed(websocket: WebSocket) -> None:
    """Read until the other side closes; whatever it sends is of no interest."""
    with suppress(RuntimeError):
        while (await websocket.receive())["type"] != "websocket.disconnect":
            pass
