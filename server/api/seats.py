"""What the socket of a 3D view carries besides its scene: the page's wishes in, what was clicked out."""

from __future__ import annotations

import asyncio
from contextlib import suppress
from typing import Annotated, Any, Literal

import msgspec
from fastapi import WebSocket, WebSocketDisconnect

from web.viser.seats import Seat, Wish

SEND_S = 10.0
LONGEST_MESSAGE = 1024
FULL, NOT_LOGGED_IN, ELSEWHERE = 4429, 4401, 4409

Id = Annotated[str, msgspec.Meta(min_length=1, max_length=200)]
Kind = Literal["robot", "victim", "tag", "note", "sector"]
Moment = Annotated[float, msgspec.Meta(ge=0.0, le=1e11)]
Count = Annotated[int, msgspec.Meta(ge=0, le=2**53)]


class Told(msgspec.Struct, forbid_unknown_fields=True):
    """A page's message: its wish, or in the past which moment to show (Unix seconds)."""

    selected: tuple[Kind, Id] | None = None
    follows: bool = False
    centred: Count = 0
    unix_s: Moment | None = None

    def wish(self) -> Wish:
        """Return what the page wants of its view."""
        return Wish(self.selected, self.follows, self.centred)


async def read(websocket: WebSocket) -> Told | None:
    """Return the next message; None when the other side has closed, or says anything else."""
    with suppress(WebSocketDisconnect, RuntimeError, KeyError, msgspec.DecodeError):
        text = await websocket.receive_text()
        if len(text) <= LONGEST_MESSAGE:
            return msgspec.json.decode(text, type=Told)
    return None


class Line:
    """The way out: one message at a time, and whoever takes none for ten seconds is not there any more."""

    def __init__(self, websocket: WebSocket) -> None:
        self._websocket = websocket
        self._lock = asyncio.Lock()

    async def send(self, message: dict[str, Any]) -> None:
        """Send a message.

        Raises:
            TimeoutError, WebSocketDisconnect, RuntimeError: nobody takes it.
        """
        async with self._lock:
            await asyncio.wait_for(self._websocket.send_json(message), SEND_S)


async def tell_clicks(line: Line, seat: Seat) -> None:
    """Tell the page what is clicked in its view, until it is gone."""
    with suppress(WebSocketDisconnect, RuntimeError, TimeoutError):
        while True:
            kind, thing_id = await seat.clicked()
            await line.send({"clicked": {"kind": kind, "id": thing_id}})


async def until_first(*waits: Any) -> None:
    """Wait for the first of several to end, and end the others."""
    tasks = [asyncio.ensure_future(wait) for wait in waits]
    try:
        await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
    finally:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
