"""The 3D view on the one port: viser's page and socket, passed on from servers that listen on loopback only.

viser itself has no login, no Origin check and lets every socket press every button, so nothing reaches it but
through here: same origin only, known message types only, a limited number of viewers, and a viewer that stops
reading is dropped. A mission has the page ``/viser/MISSION/`` and, as viser's page derives its socket's
address from its own, the socket ``/viser/MISSION``. A console's page puts its seat (``web/viser/seats.py``)
in the mission's place, and only from there do clicks pass.
"""

from __future__ import annotations

import asyncio
from collections import Counter
from collections.abc import Callable, Mapping
from math import isfinite
from typing import Any, Protocol
from urllib.parse import urlsplit

import msgspec
import websockets
from fastapi import FastAPI, Request, WebSocket
from fastapi.responses import FileResponse, PlainTextResponse, RedirectResponse, Response
from starlette.requests import HTTPConnection
from starlette.websockets import WebSocketDisconnect
from websockets.asyncio.client import ClientConnection

from web.viser.page import CLIENT_PAGE
from web.viser.seats import SEAT_HEADER, is_seat, mission_of

ALLOWED_MESSAGE_TYPES = frozenset({"ViewerCameraMessage", "GuiUpdateMessage"})
"""What a browser may send on: where its camera is, and the buttons that move its own camera."""
CLICK = "ScenePointerMessage"
"""What the page of a seat may send besides: a click, which selects in that page and nowhere else."""
MAX_VIEWERS_PER_MISSION = 32
SEND_TIMEOUT_S = 10.0
MAX_CLIENT_MESSAGE_BYTES = 64 * 1024

# Measured: viser's bundle runs without a violation under this policy. It evaluates code and has blob workers.
VISER_HEADERS: Mapping[str, str] = {
    "Content-Security-Policy": "; ".join(
        (
            "default-src 'none'",
            "script-src 'unsafe-inline' 'unsafe-eval' 'wasm-unsafe-eval' blob:",
            "worker-src blob:",
            "style-src 'unsafe-inline'",
            "img-src 'self' data: blob:",
            "connect-src 'self' blob: data:",
            "font-src data:",
            "base-uri 'none'",
            "form-action 'none'",
            "frame-ancestors 'self'",
        )
    ),
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cache-Control": "no-cache",
}


class ScenePorts(Protocol):
    """Knows on which loopback port the 3D scene of a mission is served, and who sits before it."""

    def port(self, key: str, theme: str = "dark") -> int | None:
        """Return the port behind a mission's id or a seat's key, or None when there is no scene."""

    def may_sit(self, key: str, over: asyncio.Event) -> bool:
        """Say whether a session, known by what is set when it ends, may open the view by this key."""


Gate = Callable[[HTTPConnection, str], asyncio.Event | None]
"""Whether a connection may see a mission: None where not, else what is set once it may no more."""


def mount_proxy(app: FastAPI, scenes: ScenePorts, gate: Gate) -> None:
    """Add the page and the socket of every mission's 3D scene under /viser."""
    viewers: Counter[str] = Counter()

    async def page(request: Request, key: str, theme: str = "dark") -> Response:
        over = gate(request, mission_of(key))
        if over is None:
            return PlainTextResponse("Log in first, then open the console again.\n", status_code=401)
        if not scenes.may_sit(key, over) or scenes.port(key, theme) is None:
            return PlainTextResponse(
                "This mission has no 3D scene. Open the console and choose a running mission.\n",
                status_code=404,
            )
        return FileResponse(CLIENT_PAGE, headers=dict(VISER_HEADERS))

    async def page_without_slash(request: Request, key: str, theme: str = "dark") -> Response:
        return RedirectResponse(request.url.replace(path=request.url.path + "/"), status_code=307)

    async def socket(websocket: WebSocket, key: str, theme: str = "dark") -> None:
        mission_id = mission_of(key)
        over = gate(websocket, mission_id)
        is_welcome = over is not None and same_origin(websocket.headers) and scenes.may_sit(key, over)
        port = scenes.port(key, theme) if is_welcome else None
        if port is None or over is None:
            await websocket.close(1008)  # before accept: the browser sees 403
            return
        if viewers[mission_id] >= MAX_VIEWERS_PER_MISSION:
            await websocket.close(1013)
            return
        viewers[mission_id] += 1
        try:
            await _pass_on(websocket, port, over, key if is_seat(key) else None)
        finally:
            viewers[mission_id] -= 1

    for address in ("/viser/{key}", "/viser/{key}/{theme}"):
        app.add_api_route(f"{address}/", page, methods=["GET", "HEAD"], include_in_schema=False)
        app.add_api_route(address, page_without_slash, methods=["GET", "HEAD"], include_in_schema=False)
        app.add_api_websocket_route(address, socket)


def same_origin(headers: Mapping[str, str]) -> bool:
    """Return whether a page of ours opened the socket. Without an Origin it was no page at all."""
    origin = headers.get("origin")
    return origin is None or urlsplit(origin).netloc == headers.get("host")


async def _pass_on(websocket: WebSocket, port: int, over: asyncio.Event, seat: str | None) -> None:
    """Join the browser's socket with viser's until either side ends, or whoever looks has been logged out."""
    try:
        upstream = await websockets.connect(
            f"ws://127.0.0.1:{port}",
            subprotocols=websocket.scope["subprotocols"],  # viser refuses a page of another version by it
            compression=None,
            max_size=None,
            ping_interval=None,
            additional_headers={} if seat is None else {SEAT_HEADER: seat},
        )
    except (OSError, websockets.WebSocketException):
        await websocket.close(1013)
        return
    async with upstream:
        await websocket.accept(subprotocol=upstream.subprotocol)
        pumps = {
            asyncio.create_task(_to_browser(upstream, websocket)),
            asyncio.create_task(_to_viser(websocket, upstream, seat is not None)),
            asyncio.create_task(_set(over)),
        }
        try:
            await asyncio.wait(pumps, return_when=asyncio.FIRST_COMPLETED)
        finally:
            for pump in pumps:
                pump.cancel()
            await asyncio.gather(*pumps, return_exceptions=True)
    if websocket.client_state.name == "CONNECTED" and websocket.application_state.name == "CONNECTED":
        # "service restart": the page tries again by itself; "policy violation" when logged out
        await websocket.close(1008 if over.is_set() else 1012)


async def _set(event: asyncio.Event) -> None:
    await event.wait()


async def _to_browser(upstream: ClientConnection, websocket: WebSocket) -> None:
    try:
        async for message in upstream:
            data = message if isinstance(message, bytes) else message.encode()
            await asyncio.wait_for(websocket.send_bytes(data), SEND_TIMEOUT_S)
    except (TimeoutError, websockets.ConnectionClosed, WebSocketDisconnect, RuntimeError):
        return  # the viewer is gone, or reads nothing any more


async def _to_viser(websocket: WebSocket, upstream: ClientConnection, may_click: bool) -> None:
    try:
        while True:
            data = await websocket.receive_bytes()
            message = message_of(data)
            kind = message.get("type")
            if kind in ALLOWED_MESSAGE_TYPES or (kind == CLICK and may_click and is_click(message)):
                await upstream.send(data)
    except (websockets.ConnectionClosed, WebSocketDisconnect, KeyError, RuntimeError):
        return


def message_of(data: bytes) -> dict[str, Any]:
    """Return a message from viser's page; empty when it is too long or none of its messages."""
    if len(data) > MAX_CLIENT_MESSAGE_BYTES:
        return {}
    try:
        message = msgspec.msgpack.decode(data)
    except msgspec.DecodeError:
        return {}
    return message if isinstance(message, dict) and isinstance(message.get("type"), str) else {}


def is_click(message: Mapping[str, Any]) -> bool:
    """Say whether a message about the pointer is a click, with a ray of finite numbers."""
    rays = (message.get("ray_origin"), message.get("ray_direction"))
    place = message.get("screen_pos")
    if message.get("event_type") != "click" or not (isinstance(place, list) and place):
        return False
    return all(
        isinstance(ray, list)
        and len(ray) == 3
        and all(isinstance(v, int | float) and isfinite(v) for v in ray)
        for ray in rays
    )
