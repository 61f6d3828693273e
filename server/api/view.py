"""Looking at a mission in 3D: a seat of one's own before the scene that all share."""

from __future__ import annotations

from contextlib import suppress
from typing import Annotated

from fastapi import APIRouter, Query, WebSocket, WebSocketDisconnect

from server.api.seats import ELSEWHERE, FULL, NOT_LOGGED_IN, Line, read, tell_clicks, until_first
from server.api.stream import entered
from web.viser.scenes import Scenes
from web.viser.seats import Seat

router = APIRouter(prefix="/missions/{mission_id}")
_SECRET = r"^[0-9a-f]{32}$"  # 128 bits: nobody guesses another page's seat


@router.websocket("/view")
async def view(websocket: WebSocket, mission_id: str, seat: Annotated[str, Query(pattern=_SECRET)]) -> None:
    """Say where the scene is (`{"scene": address}`) and what is clicked in it; take what to mark there.

    The seat ends with the socket.
    """
    found = await entered(websocket, mission_id)
    if found is None:
        return
    _, actor = found
    scenes: Scenes = websocket.app.state.scenes
    taken = scenes.take_seat(mission_id, seat, actor.over)
    if taken is None:
        await websocket.close(
            FULL, "too many people look at this mission in 3D; close another page or use 2D"
        )
        return
    line = Line(websocket)
    try:
        with suppress(WebSocketDisconnect, RuntimeError, TimeoutError):
            await line.send({"scene": taken.key})
            await until_first(
                _listen(websocket, taken), tell_clicks(line, taken), actor.over.wait(), taken.gone.wait()
            )
    finally:
        scenes.leave_seat(taken)
    with suppress(WebSocketDisconnect, RuntimeError):
        if actor.over.is_set():
            await websocket.close(NOT_LOGGED_IN, "you have been logged out")
        elif taken.gone.is_set():
            await websocket.close(ELSEWHERE, "this view was opened again")
        else:
            await websocket.close(1008, "this is no message of a 3D view")


async def _listen(websocket: WebSocket, seat: Seat) -> None:
    while (told := await read(websocket)) is not None:
        seat.wish = told.wish()
