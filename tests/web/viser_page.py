"""The browser's side of viser's socket, as far as tests need it."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Any

import msgspec
import viser
import websockets
import zstandard

SUBPROTOCOL = websockets.Subprotocol(f"viser-v{viser.__version__}")


def camera(kind: str = "ViewerCameraMessage", **other: Any) -> bytes:
    """Return what viser's page sends about its camera; viser welcomes a client at the first of them."""
    return msgspec.msgpack.encode(
        {
            "type": kind, "wxyz": [1.0, 0.0, 0.0, 0.0], "position": [0.0, 0.0, 10.0], "fov": 1.2,
            "near": 0.01, "far": 1000.0, "image_height": 600, "image_width": 800, "look_at": [0.0, 0.0, 0.0],
            "up_direction": [0.0, 0.0, 1.0],
        }
        | other
    )  # fmt: skip


def messages_of(frame: bytes) -> list[dict[str, Any]]:
    """Return a frame's messages: two lengths of 8 bytes, the packed messages under zstd, raw buffers."""
    size = int.from_bytes(frame[8:16], "little")
    return list(msgspec.msgpack.decode(zstandard.decompress(frame[16 : 16 + size]))["messages"])


async def receive_until(
    socket: websockets.ClientConnection, is_complete: Callable[[list[dict[str, Any]]], bool]
) -> list[dict[str, Any]]:
    messages: list[dict[str, Any]] = []
    async with asyncio.timeout(10):
        while not is_complete(messages):
            frame = await socket.recv()
            assert isinstance(frame, bytes)
            messages += messages_of(frame)
    return messages


def click(origin: tuple[float, float, float], direction: tuple[float, float, float], **other: Any) -> bytes:
    """Return what viser's page sends when somebody clicks into the scene."""
    return msgspec.msgpack.encode(
        {
            "type": "ScenePointerMessage", "event_type": "click", "ray_origin": origin,
            "ray_direction": direction, "screen_pos": [[0.5, 0.5]], "modifier": None,
        }
        | other
    )  # fmt: skip
