"""One scene, many pages: each has its own selection, marked and clicked in its own view alone."""

from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncIterator, Awaitable, Callable, Mapping, Sequence
from contextlib import asynccontextmanager
from typing import Any

import httpx
import pytest
import websockets
from fastapi import FastAPI

from tests.web.viser_page import SUBPROTOCOL, camera, click, receive_until
from web.mount import mount_web
from web.viser.scenes import MAX_SEATS, Scenes
from web.viser.seats import Seat, Wish, seat_key

STATE: dict[str, dict[str, Any]] = {
    "tag/A1": {"tag_id": "A1", "x_m": 0.0, "y_m": 0.0},
    "tag/A2": {"tag_id": "A2", "x_m": 6.0, "y_m": 0.5},
}
FROM_ABOVE = ((6.0, 0.5, 20.0), (0.0, 0.0, -1.0))


class StillBoard:
    """A board on which nothing changes."""

    def snapshot(self) -> dict[str, dict[str, Any]]:
        return dict(STATE)

    async def subscribe(self) -> AsyncIterator[tuple[Mapping[str, dict[str, Any]], Sequence[str]]]:
        await asyncio.Event().wait()
        yield {}, ()


class House:
    """A served mission with two pages before it, of two sessions, ada and ben; cookies name them."""

    def __init__(self) -> None:
        self.scenes = Scenes()
        self.sessions = {"ada": asyncio.Event(), "ben": asyncio.Event()}
        self.seats: dict[str, Seat] = {}
        self.host = ""

    def app(self) -> FastAPI:
        @asynccontextmanager
        async def lifespan(_app: FastAPI) -> AsyncIterator[None]:
            await self.scenes.start("m1", StillBoard())
            for name, over in self.sessions.items():
                seat = self.scenes.take_seat("m1", name * 8, over)
                assert seat is not None
                self.seats[name] = seat
            yield
            await self.scenes.close()

        app = FastAPI(lifespan=lifespan)
        mount_web(app, (self.scenes, lambda connection, _mission: self.sessions[connection.cookies["who"]]))
        return app

    def connect(self, key: str, who: str) -> websockets.connect:
        return websockets.connect(
            f"ws://{self.host}/viser/{key}",
            subprotocols=[SUBPROTOCOL],
            max_size=None,
            additional_headers={"Cookie": f"who={who}", "X-Waymark-Seat": "m1@forged"},
        )

    def look(self, name: str) -> websockets.connect:
        return self.connect(self.seats[name].key, name)


@pytest.fixture
def house(serve: Callable[[FastAPI], str]) -> House:
    house = House()
    house.host = serve(house.app())
    deadline = time.monotonic() + 60.0
    while len(house.seats) < 2:
        assert time.monotonic() < deadline, "the server did not start"
        time.sleep(0.01)
    return house


def run(story: Callable[[], Awaitable[None]]) -> None:
    asyncio.run(story())


def named(messages: list[dict[str, Any]], name: str) -> list[dict[str, Any]]:
    return [message for message in messages if message.get("name") == name]


async def for_a_while(socket: websockets.ClientConnection) -> list[dict[str, Any]]:
    """All that comes within as long as several drawings take."""
    seen: list[dict[str, Any]] = []
    try:
        async with asyncio.timeout(0.6):
            await receive_until(socket, lambda messages: bool(seen.extend(messages)))
    except TimeoutError:
        pass
    return seen


def test_what_a_page_selects_is_marked_in_its_own_view_alone(house: House) -> None:
    async def story() -> None:
        async with house.look("ada") as ada, house.look("ben") as ben:
            for socket in (ada, ben):
                await socket.send(camera())
                await receive_until(socket, lambda seen: bool(named(seen, "/tags/points")))
            house.seats["ada"].wish = Wish(("tag", "A2"))
            seen = await receive_until(ada, lambda seen: bool(named(seen, "/selected/label")))
            labels = [
                message["props"]["text"] for message in named(seen, "/selected/label") if "props" in message
            ]
            assert labels == ["A2"]
            place = [m["position"] for m in named(seen, "/selected") if m["type"] == "SetPositionMessage"]
            assert place[-1][:2] == pytest.approx((6.0, 0.5))
            assert not any("/selected" in message.get("name", "") for message in await for_a_while(ben))
            house.seats["ada"].wish = Wish()
            await receive_until(
                ada, lambda seen: any(m["type"] == "RemoveSceneNodeMessage" for m in named(seen, "/selected"))
            )

    run(story)


def test_a_page_that_is_late_or_comes_again_finds_its_mark(house: House) -> None:
    async def story() -> None:
        house.seats["ada"].wish = Wish(("tag", "A1"))
        for _ in range(2):
            async with house.look("ada") as socket:
                await socket.send(camera())
                await receive_until(socket, lambda seen: bool(named(seen, "/selected/ring")))

    run(story)


def test_the_camera_goes_where_the_page_asks_for_it_and_for_nobody_else(house: House) -> None:
    def looks(messages: list[dict[str, Any]]) -> list[Any]:
        return [m["look_at"][:2] for m in messages if m["type"] == "SetCameraLookAtMessage"]

    async def story() -> None:
        async with house.look("ada") as ada, house.look("ben") as ben:
            for socket in (ada, ben):
                await socket.send(camera())
                await receive_until(socket, lambda seen: bool(named(seen, "/tags/points")))
                await for_a_while(socket)
            house.seats["ada"].wish = Wish(("tag", "A2"))
            assert looks(await for_a_while(ada)) == [], "selecting alone moves nothing"
            house.seats["ada"].wish = Wish(("tag", "A2"), centred=1)
            seen = await receive_until(ada, lambda seen: bool(looks(seen)))
            assert looks(seen)[-1] == pytest.approx((6.0, 0.5))
            assert looks(await for_a_while(ben)) == []

    run(story)


def test_a_click_reaches_the_page_of_that_view_alone(house: House) -> None:
    async def story() -> None:
        async with house.look("ada") as ada, house.connect("m1", "ben") as bare:
            for socket in (ada, bare):
                await socket.send(camera())
                await receive_until(
                    socket, lambda seen: any(m["type"] == "ScenePointerEnableMessage" for m in seen)
                )
                await socket.send(click(*FROM_ABOVE, screen_pos=[]))
                await socket.send(click((float("nan"), 0.0, 1.0), (0.0, 0.0, -1.0)))
                await socket.send(click(*FROM_ABOVE, ray_origin=["6", "0.5", "20"]))
                await socket.send(click(*FROM_ABOVE, event_type="rect-select"))
                await socket.send(click((40.0, 40.0, 20.0), (0.0, 0.0, -1.0)))  # nothing is there
                await socket.send(click(*FROM_ABOVE))
            future = asyncio.run_coroutine_threadsafe(house.seats["ada"].clicked(), house.seats["ada"]._loop)
            assert await asyncio.to_thread(future.result, 10.0) == ("tag", "A2")
            await asyncio.sleep(0.3)
            assert house.seats["ada"]._clicks.empty(), "one click, one thing"
            assert house.seats["ben"]._clicks.empty()

    run(story)


def test_the_seat_of_another_session_and_one_that_nobody_took_are_refused(house: House) -> None:
    async def story() -> None:
        for key, who in ((house.seats["ada"].key, "ben"), ("m1@" + "0" * 32, "ada")):
            with pytest.raises(websockets.InvalidStatus) as refusal:
                async with house.connect(key, who):
                    pass
            assert refusal.value.response.status_code == 403

    run(story)
    with httpx.Client(base_url=f"http://{house.host}", cookies={"who": "ben"}) as client:
        assert client.get(f"/viser/{house.seats['ben'].key}/dark/").status_code == 200
        assert client.get(f"/viser/{house.seats['ada'].key}/dark/").status_code == 404


def test_viser_tells_whose_socket_it_is_by_the_proxys_header_and_by_no_other(house: House) -> None:
    """The contract with viser 1.1.1: the request of a client can be read, and the proxy writes it alone."""

    async def story() -> None:
        server = house.scenes._running["m1"].scene("dark")._server
        for key, who, expected in (
            (house.seats["ada"].key, "ada", house.seats["ada"].key),
            ("m1", "ben", None),
        ):
            async with house.connect(key, who) as socket:
                await socket.send(camera())
                await receive_until(socket, lambda seen: any(m["type"] == "GuiButtonMessage" for m in seen))
                newest = max(server.get_clients())
                assert seat_key(server, newest) == expected

    run(story)


def test_seats_are_limited_and_taking_ones_own_again_ends_the_first() -> None:
    async def story() -> None:
        scenes, over = Scenes(), asyncio.Event()
        first = scenes.take_seat("m", "0", over)
        assert first is not None
        assert scenes.take_seat("m", "0", asyncio.Event()) is None, "it is another session's"
        again = scenes.take_seat("m", "0", over)
        assert again is not None
        assert first.gone.is_set()
        scenes.leave_seat(first)
        assert scenes.may_sit(again.key, over), "who was put out takes nobody's seat away"
        for k in range(1, MAX_SEATS):
            assert scenes.take_seat("m", str(k), over) is not None
        assert scenes.take_seat("m", "more", over) is None
        assert scenes.take_seat("other", "more", over) is not None

    run(story)
