"""What is decided about a request before anything reads it: its size, and where it may come from."""

from __future__ import annotations

import asyncio
import re
from contextlib import suppress
from urllib.parse import urlsplit

from starlette.datastructures import Headers
from starlette.exceptions import HTTPException
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from server.errors import error_response
from server.settings import is_loopback

_DRAIN_BODIES, _DRAIN_S = 16, 10.0  # how much of a body that is refused is read, as a multiple of the limit
_PICTURES = re.compile(r"/api/v1/missions/[^/]+/(photos|base-map)")
_SAFE = {"GET", "HEAD", "OPTIONS"}


def is_same_origin(headers: Headers) -> bool:
    """Say whether a browser's page of our own made the request; what is no browser sends no Origin."""
    origin = headers.get("origin")
    return origin is None or urlsplit(origin).netloc == headers.get("host")


def _host(headers: Headers) -> str:
    """Return the name by which the server was asked for, without the port."""
    return urlsplit(f"//{headers.get('host', '')}").hostname or ""


class Guard:
    """ASGI middleware that refuses bodies over a limit, announced or not, and changes by foreign pages.

    With ``loopback_only`` it also refuses every other name of this machine: a foreign page whose own name
    was made to lead here (DNS rebinding) would count as ours.
    """

    def __init__(self, app: ASGIApp, max_body_bytes: int, max_photo_bytes: int, loopback_only: bool) -> None:
        self._app = app
        self._loopback_only = loopback_only
        self._limit = max_body_bytes
        self._too_large = f"The body is larger than {max_body_bytes} bytes; send it in several requests."
        self._photo_limit = max_photo_bytes
        self._photo_too_large = (
            f"The picture is larger than {max_photo_bytes / 2**20:.0f} MiB; make it smaller and send it."
        )

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Refuse the request, or pass it on."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        headers = Headers(scope=scope)
        if self._loopback_only and not is_loopback(_host(headers)):
            message = (
                "Nobody logs in here, so only 127.0.0.1 and localhost are answered; open the console there."
            )
            if scope["type"] == "websocket":
                await receive()
                await send({"type": "websocket.close", "code": 1008, "reason": message})
                return
            await error_response(403, "foreign_host", message)(scope, receive, send)
            return
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        if scope["method"] not in _SAFE and not is_same_origin(headers):
            message = "Only this server's own pages may change a mission; open the console from this server."
            await error_response(403, "foreign_origin", message)(scope, receive, send)
            return
        is_photo = _PICTURES.fullmatch(scope["path"]) is not None
        limit = self._photo_limit if is_photo else self._limit
        too_large = self._photo_too_large if is_photo else self._too_large
        announced = headers.get("content-length", "0")
        if announced.isdigit() and int(announced) > limit:
            if "expect" not in headers:  # such a client waits to be told before it sends
                await self._drain(receive)
            response = error_response(413, "too_large", too_large, headers={"Connection": "close"})
            await response(scope, receive, send)
            return
        count = 0

        async def limited() -> Message:
            nonlocal count
            message = await receive()
            count += len(message.get("body", b""))
            if count > limit:
                if message.get("more_body"):
                    await self._drain(receive)
                raise HTTPException(413, too_large)
            return message

        await self._app(scope, limited, send)

    async def _drain(self, receive: Receive) -> None:
        """Read on and forget, within reason.

        A connection that is closed on a client in the middle of its body is reset, and the answer with it:
        the client would never learn why.
        """
        count = 0
        with suppress(TimeoutError):
            async with asyncio.timeout(_DRAIN_S):
                while count < _DRAIN_BODIES * self._limit:
                    message = await receive()
                    count += len(message.get("body", b""))
                    if not message.get("more_body"):
                        return
