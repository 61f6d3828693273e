"""The way to viser: who may connect, what may pass, and that a scene really arrives."""

from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncIterator, Awaitable, Callable, Mapping, Sequence
from contextlib import asynccontextmanager
from typing import Any

import httpx
import msgspec
import numpy as np
import pytest
import websockets
from fastapi import FastAPI

import web.proxy
from tests.web.viser_page import SUBPROTOCOL, camera, receive_until
from web.mount import mount_web
from web.viser.colors import THEMES
from web.viser.scenes import Scenes

ROBOT = {
    "robot_id": "r1", "x_m": 2.0, "y_m": 1.0, "yaw_rad": 0.5, "link": "live",
    "covariance": [0.04, 0.0, 0.01, 0.001],
}  # fmt: skip
STATE: dict[str, dict[str, Any]] = {
    "robot/r1": ROBOT,
    "trail/r1": {"robot_id": "r1", "points_m": [[0.0, 0.0], [1.0, 0.5], [2.0, 1.0]]},
    "tag/A1": {"tag_id": "A1", "x_m": 0.0, "y_m": 0.0},
    "tag/A2": {"tag_id": "A2", "x_m": 1.0, "y_m": 0.5},
    "links": {"pairs": [["A1", "A2"]]},
    "victim/V1": {"victim_id": "V1", "x_m": 3.0, "y_m": 1.0, "confidence": 0.8, "status": "suspected"},
}


class FixedBoard:
    """A board that stands at STATE; ``later`` changes once it was asked for changes."""

    def __init__(self, later: Mapping[str, dict[str, Any]] | None = None):
        self.later = later

    def snapshot(self) -> dict[str, dict[str, Any]]:
        return dict(STATE)

    async def subscribe(self) -> AsyncIterator[tuple[Mapping[str, dict[str, Any]], Sequence[str]]]:
        if self.later:
            yield self.later, ("victim/V1",)
        await asyncio.Event().wait()


class Site:
    """A served application with one mission's scene."""

    def __init__(self, host: str, scenes: Scenes):
        self.host = host
        self.scenes = scenes

    def connect(self, mission: str = "m1", origin: str | None = "same", **options: Any) -> websockets.connect:
        given = websockets.Origin(f"http://{self.host}" if origin == "same" else origin) if origin else None
        return websockets.connect(
            f"ws://{self.host}/viser/{mission}",
            origin=given,
            subprotocols=[SUBPROTOCOL],
            max_size=None,
            **options,
        )


@pytest.fixture
def site(serve: Callable[[FastAPI], str]) -> Site:
    scenes = Scenes()

    @asynccontextmanager
    async def lifespan(_app: FastAPI) -> AsyncIterator[None]:
        await scenes.start("m1", FixedBoard({"robot/r1": ROBOT | {"x_m": 5.0}}))
        scenes.update_map("m1", np.array([[-1, 0], [100, 100]], np.int8), (-1.0, -2.0), 0.5)
        yield
        await scenes.close()

    app = FastAPI(lifespan=lifespan)
    mount_web(app, (scenes, lambda connection, mission_id: asyncio.Event()))
    host = serve(app)
    deadline = time.monotonic() + 60.0
    while scenes.port("m1") is None:
        assert time.monotonic() < deadline, "the server did not start"
        time.sleep(0.01)
    return Site(host, scenes)


def run(story: Callable[[], Awaitable[None]]) -> None:
    asyncio.run(story())


def test_the_scene_arrives_layer_by_layer(site: Site) -> None:
    wanted = {"/map/floor", "/map/walls", "/robots/1/body", "/robots/1/label", "/ellipses/1", "/trails/1"}
    wanted |= {"/tags/points", "/tags/links"}

    def names(messages: list[dict[str, Any]]) -> set[str]:
        return {message["name"] for message in messages if "name" in message}

    async def story() -> None:
        async with site.connect() as socket:
            assert socket.subprotocol == SUBPROTOCOL
            await socket.send(camera())
            messages = await receive_until(socket, lambda seen: wanted <= names(seen))
        positions = [
            message["position"]
            for message in messages
            if message["type"] == "SetPositionMessage" and message["name"] == "/robots/1"
        ]
        assert positions[-1][:2] == pytest.approx((5.0, 1.0)), (
            "the board's change counts, not its first state"
        )
        labels = [message["props"]["text"] for message in messages if message["type"] == "LabelMessage"]
        assert labels == ["r1"], "the victim was deleted before anybody looked"

    run(story)


def test_the_page_is_viser_under_its_own_policy(site: Site) -> None:
    with httpx.Client(base_url=f"http://{site.host}") as client:
        response = client.get("/viser/m1/")
        assert response.status_code == 200
        assert "viser" in response.text.lower()
        assert "frame-ancestors 'self'" in response.headers["content-security-policy"]
        assert client.head("/viser/m1/").status_code == 200
        assert client.get("/viser/m1").headers["location"].endswith("/viser/m1/")
        missing = client.get("/viser/other/")
        assert missing.status_code == 404
        assert "no 3D scene" in missing.text


def test_each_theme_is_a_scene_of_its_own(site: Site) -> None:
    assert site.scenes.port("m1", "daylight") != site.scenes.port("m1", "dark") == site.scenes.port("m1")
    with httpx.Client(base_url=f"http://{site.host}") as client:
        assert client.get("/viser/m1/daylight/").status_code == 200
        assert client.get("/viser/m1/neon/").status_code == 404

    async def story() -> None:
        async with site.connect("m1/daylight") as socket:
            await socket.send(camera())
            messages = await receive_until(socket, lambda found: _named(found, "/robots/1/body"))
            body = next(m for m in messages if m.get("name") == "/robots/1/body" and "props" in m)
            assert tuple(body["props"]["color"]) == THEMES["daylight"]["robot-1"]

    run(story)


def _named(messages: list[dict[str, Any]], name: str) -> bool:
    return any(message.get("name") == name for message in messages)


@pytest.mark.parametrize("origin", ["http://evil.example", "null", "http://127.0.0.1"])
def test_a_page_of_another_site_is_refused(site: Site, origin: str) -> None:
    async def story() -> None:
        with pytest.raises(websockets.InvalidStatus) as refusal:
            async with site.connect(origin=origin):
                pass
        assert refusal.value.response.status_code == 403

    run(story)


def test_an_unknown_mission_is_refused(site: Site) -> None:
    async def story() -> None:
        with pytest.raises(websockets.InvalidStatus):
            async with site.connect("other"):
                pass

    run(story)


def test_only_known_messages_reach_viser(site: Site) -> None:
    running = site.scenes._running["m1"].scenes["dark"]._server
    heard: list[str] = []
    handle = running._websock_server._handle_incoming_message

    async def listen(client_id: Any, message: Any) -> None:
        heard.append(type(message).__name__)
        await handle(client_id, message)

    running._websock_server._handle_incoming_message = listen
    forbidden = [
        msgspec.msgpack.encode({"type": "ShareUrlRequest"}),
        camera("SceneNodeClickMessage"),
        b"\xc1 not msgpack",
        msgspec.msgpack.encode(["ViewerCameraMessage"]),
        camera(padding="x" * web.proxy.MAX_CLIENT_MESSAGE_BYTES),
    ]

    async def story() -> None:
        async with site.connect() as socket:
            for message in forbidden:
                await socket.send(message)
            await socket.send(camera())
            await receive_until(socket, lambda seen: any(m["type"] == "GuiButtonMessage" for m in seen))

    run(story)
    assert set(heard) == {"ViewerCameraMessage"}


def test_viewers_are_limited_and_a_place_becomes_free_again(
    site: Site, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(web.proxy, "MAX_VIEWERS_PER_MISSION", 1)

    async def story() -> None:
        async with site.connect():
            with pytest.raises(websockets.InvalidStatus):
                async with site.connect():
                    pass
        async with asyncio.timeout(5):
            while True:
                try:
                    async with site.connect():
                        return
                except websockets.InvalidStatus:
                    await asyncio.sleep(0.05)

    run(story)


def test_a_viewer_that_stops_reading_is_dropped(site: Site, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(web.proxy, "SEND_TIMEOUT_S", 0.3)
    scene = site.scenes._running["m1"].scenes["dark"]

    async def story() -> None:
        socket = await site.connect(max_queue=1)
        await socket.send(camera())
        await asyncio.sleep(0.3)
        noise = np.random.default_rng(0)
        async with asyncio.timeout(20):
            while scene._server.get_clients():  # nobody reads: the buffers between fill up
                pixels = noise.integers(0, 255, (400, 400, 3), np.uint8)
                scene._server.scene.add_image("/noise", pixels, 1.0, 1.0, format="png")
                await asyncio.sleep(0.05)
        socket.transport.abort()

    run(story)


def test_a_stopped_scene_ends_its_sockets(site: Site) -> None:
    async def story() -> None:
        async with site.connect() as socket:
            await socket.send(camera())
            await asyncio.to_thread(site.scenes._running["m1"].scenes["dark"].stop)
            async with asyncio.timeout(10):
                await socket.wait_closed()
            assert socket.close_code == 1012

    run(story)
