"""The 3D view on the one port: viser's page and socket, passed on from servers that listen on loopback only.

viser itself has no login, no Origin check and lets every socket press every button, so nothing reaches it but
through here: same origin only, known message types only, a limited number of viewers, and a viewer that stops
reading is dropped. A mission has the page ``/viser/MISSION/`` and, as viser's page derives its socket's
address from its own, the socket ``/viser/MISSION``.
"""

from __future__ import annotations

import asyncio
from collections import Counter
from collections.abc import Callable, Mapping
from typing import Protocol
from urllib.parse import urlsplit

import msgspec
import websockets
from fastapi import FastAPI, Request, WebSocket
from fastapi.responses import FileResponse, PlainTextResponse, RedirectResponse, Response
from starlette.requests import HTTPConnection
from starlette.websockets import WebSocketDisconnect
from websockets.asyncio.client import ClientConnection

from web.viser.page import CLIENT_PAGE

ALLOWED_MESSAGE_TYPES = frozenset({"ViewerCameraMessage", "GuiUpdateMessage"})
"""What a browser may send on: where its camera is, and the buttons that move its own camera."""
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
    """Knows on which loopback port the 3D scene of a mission is served."""

    def port(self, mission_id: str, theme: str = "dark") -> int | None:
        """Return the port, or None when the mission has no scene in that theme."""


Gate = Callable[[HTTPConnection, str], asyncio.Event | None]
"""Whether a connection may see a mission: None where not, else what is set once it may no more."""


def mount_proxy(app: FastAPI, scenes: ScenePorts, gate: Gate) -> None:
    """Add the page and the socket of every mission's 3D scene under /viser."""
    viewers: Counter[str] = Counter()

    async def page(request: Request, mission_id: str, theme: str = "dark") -> Response:
        if gate(request, _mission_of(mission_id)) is None:
            return PlainTextResponse("Log in first, then open the console again.\n", status_code=401)
        if scenes.port(mission_id, theme) is None:
            return PlainTextResponse(
                "This mission has no 3D scene. Open the console and choose a running mission.\n",
                status_code=404,
            )
        return FileResponse(CLIENT_PAGE, headers=dict(VISER_HEADERS))

    async def page_without_slash(request: Request, mission_id: str, theme: str = "dark") -> Response:
        return RedirectResponse(request.url.replace(path=request.url.path + "/"), status_code=307)

    async def socket(websocket: WebSocket, mission_id: str, theme: str = "dark") -> None:
        port = scenes.port(mission_id, theme)
        over = gate(websocket, _mission_of(mission_id))
        if port is None or over is None or not same_origin(websocket.headers):
            await websocket.close(1008)  # before accept: the browser sees 403
            return
        if viewers[mission_id] >= MAX_VIEWERS_PER_MISSION:
            await websocket.close(1013)
            return
        viewers[mission_id] += 1
        try:
            await _pass_on(websocket, port, over)
        finally:
            viewers[mission_id] -= 1

    for address in ("/viser/{mission_id}", "/viser/{mission_id}/{theme}"):
        app.add_api_route(f"{address}/", page, methods=["GET", "HEAD"], include_in_schema=False)
        app.add_api_route(address, page_without_slash, methods=["GET", "HEAD"], include_in_schema=False)
        app.add_api_websocket_route(address, socket)


def _mission_of(key: str) -> str:
    """Return whose scene it is: one of a mission's past has a name of its own after an @."""
    return key.partition("@")[0]


def same_origin(headers: Mapping[str, str]) -> bool:
    """Return whether a page of ours opened the socket. Without an Origin it was no page at all."""
    origin = headers.get("origin")
    return origin is None or urlsplit(origin).netloc == headers.get("host")


async def _pass_on(websocket: WebSocket, port: int, over: asyncio.Event) -> None:
    """Join the browser's socket with viser's until either side ends, or whoever looks has been logged out."""
    try:
        upstream = await websockets.connect(
            f"ws://127.0.0.1:{port}",
            subprotocols=websocket.scope["subprotocols"],  # viser refuses a page of another version by it
            compression=None,
            max_size=None,
            ping_interval=None,
        )
    except (OSError, websockets.WebSocketException):
        await websocket.close(1013)
        return
    async with upstream:
        await websocket.accept(subprotocol=upstream.subprotocol)
        pumps = {
            asyncio.create_task(_to_browser(upstream, websocket)),
            asyncio.create_task(_to_viser(websocket, upstream)),
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


async def _to_viser(websocket: WebSocket, upstream: ClientConnection) -> None:
    try:
        while True:
            data = await websocket.receive_bytes()
            if message_type(data) in ALLOWED_MESSAGE_TYPES:
                await upstream.send(data)
    except (websockets.ConnectionClosed, WebSocketDisconnect, KeyError, RuntimeError):
        return


def message_type(data: bytes) -> str | None:
    """Return the type of a message from viser's page; None when it is too long or not one of its messages."""
    if len(data) > MAX_CLIENT_MESSAGE_BYTES:
        return None
    try:
        message = msgspec.msgpack.decode(data)
    except msgspec.DecodeError:
        return None
    kind = message.get("type") if isinstance(message, dict) else None
    return kind if isinstance(kind, str) else None
