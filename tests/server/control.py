"""Mission control on a free port with its real agents, for tests."""

from __future__ import annotations

import itertools
import json
import socket
import sqlite3
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any, ClassVar

import httpx
import uvicorn
from websockets.sync.client import ClientConnection, connect

from server.app import create_app
from server.missions import Missions
from server.settings import Settings

Json = dict[str, Any]
CONFIG: Json = {"deployment": {"spacing_m": 2.0, "rate_per_m": 3.0}}
START: Json = {"x_m": 5.0, "y_m": 1.0, "yaw_rad": 0.0, "sd_m": 0.05, "sd_rad": 0.01}
_numbers = itertools.count(1)


class Line:
    """One mission on a server, with a robot r1 as most tests have it."""

    words: ClassVar[Json] = {"config": CONFIG, "start_pose": START}

    def __init__(self, control: Control, mission_id: str) -> None:
        self.control = control
        self.mission_id = mission_id
        self.at = f"/missions/{mission_id}"

    def call(self, method: str, path: str, body: object = None, **more: Any) -> httpx.Response:
        return self.control.call(method, self.at + path, body, **more)

    def get(self, path: str = "") -> Json:
        response = self.call("GET", path)
        assert response.status_code == 200, response.text
        found: Json = response.json()
        return found

    def register(self, robot_id: str = "r1", **words: Any) -> httpx.Response:
        return self.call("POST", "/robots", {"robot_id": robot_id, **words})

    def refused(
        self, method: str, path: str, body: object = None, **more: Any
    ) -> tuple[int, str, str | None]:
        """The status, code and field of a refusal, whose message is a sentence."""
        response = self.call(method, path, body, **more)
        error = response.json()["error"]
        assert response.json().keys() == {"error"}
        assert error.keys() == {"code", "message", "field"}
        assert error["message"].endswith("."), error
        return response.status_code, error["code"], error["field"]

    def refused_post(self, observations: object, **more: Any) -> tuple[int, str, str | None]:
        return self.refused("POST", "/robots/r1/observations", {"observations": observations, **more})

    def post(self, observations: list[Json], robot_id: str = "r1", **more: Any) -> httpx.Response:
        return self.call("POST", f"/robots/{robot_id}/observations", {"observations": observations, **more})

    def send(self, observations: list[Json], robot_id: str = "r1", **more: Any) -> Json:
        response = self.post(observations, robot_id, **more)
        assert response.status_code == 200, response.text
        reply: Json = response.json()
        return reply

    def events(self, kind: str) -> list[Json]:
        return [event for event in self.get("/events?limit=1000")["events"] if event["kind"] == kind]

    def agent_pid(self, robot_id: str = "r1") -> int | None:
        return self.control.missions.get(self.mission_id).roster.get(robot_id).host.pid

    def team_pid(self) -> int | None:
        return self.control.missions.get(self.mission_id).shared_map.pid

    @contextmanager
    def stream(self, **more: Any) -> Iterator[Stream]:
        url = f"ws://127.0.0.1:{self.control.port}/api/v1{self.at}/stream"
        with connect(url, max_size=None, compression=None, **more) as connection:
            yield Stream(connection)


class Stream:
    """A board as it is seen through the stream."""

    def __init__(self, connection: ClientConnection) -> None:
        self._connection = connection
        first = json.loads(connection.recv(timeout=60))
        assert first["type"] == "snapshot"
        self.state: Json = first["state"]

    def next(self) -> Json:
        message: Json = json.loads(self._connection.recv(timeout=60))
        assert message["type"] == "changes"
        self.state |= message["set"]
        for key in message["delete"]:
            self.state.pop(key)
        return message

    def kind(self, kind: str) -> list[Json]:
        return [value for key, value in self.state.items() if key.startswith(f"{kind}/")]

    def settle(self) -> None:
        """Read until nothing changes for a second."""
        while (message := self.next())["set"] or message["delete"]:
            pass

    def until(self, condition: Callable[[Stream], object], seconds: float = 60.0) -> Json:
        """The state once the condition holds."""
        deadline = time.monotonic() + seconds
        while not condition(self):
            assert time.monotonic() < deadline, sorted(self.state)
            self.next()
        return self.state


class Control:
    """A server in a thread of its own, with the settings given; ``start`` and ``stop`` as often as needed."""

    def __init__(self, folder: Path, **settings: Any) -> None:
        self.settings = Settings(data_dir=folder, **{"login": "off", "reply_s": 60.0, **settings})
        self.port = 0
        self.missions: Missions
        self._server: uvicorn.Server
        self._thread: threading.Thread
        self._client: httpx.Client

    def start(self) -> None:
        self._app = create_app(self.settings)
        config = uvicorn.Config(
            self._app, log_level="critical", ws_per_message_deflate=False, timeout_graceful_shutdown=1
        )
        self._server = uvicorn.Server(config)
        listening = socket.create_server(("127.0.0.1", 0))
        self.port = listening.getsockname()[1]
        self._thread = threading.Thread(target=self._server.run, args=([listening],))
        self._thread.start()
        self._client = httpx.Client(base_url=f"http://127.0.0.1:{self.port}/api/v1", timeout=90.0)
        wait_until(lambda: self._server.started or not self._thread.is_alive())
        self.missions = self._app.state.missions

    def stop(self) -> None:
        if self._server.should_exit:
            return
        self._client.close()
        self._server.should_exit = True
        self._thread.join(timeout=60)
        assert not self._thread.is_alive(), "the server did not stop"

    @property
    def database(self) -> Path:
        return Path(self.settings.database_target)

    def sql(self, statement: str) -> list[tuple[Any, ...]]:
        """Run a statement on the database behind the server's back."""
        with closing(sqlite3.connect(self.database)) as connection, connection:
            return connection.execute(statement).fetchall()

    @contextmanager
    def failing(self, *tables: str, on: str = "INSERT") -> Iterator[None]:
        """The database refuses changes of these tables for a while."""
        for table in tables:
            raise_ = "SELECT RAISE(ABORT, 'disk is full')"
            self.sql(f"CREATE TRIGGER fail_{table} BEFORE {on} ON {table} BEGIN {raise_}; END")
        try:
            yield
        finally:
            for table in tables:
                self.sql(f"DROP TRIGGER fail_{table}")

    def call(self, method: str, path: str, body: object = None, **more: Any) -> httpx.Response:
        return self._client.request(method, path, json=body, **more)

    def forget_cookies(self) -> None:
        """Leave it to each call to say who it comes from."""
        self._client.cookies.clear()

    def line(self, mission_id: str) -> Line:
        """A mission that is there already."""
        return Line(self, mission_id)

    def open(self, mission_id: str | None = None, tag_key: str | None = "") -> Line:
        """A new mission."""
        mission_id = mission_id or f"m{next(_numbers)}"
        words = {"name": mission_id.upper(), "mission_id": mission_id, "tag_key": tag_key}
        response = self.call("POST", "/missions", words)
        assert response.status_code == 201, response.text
        return Line(self, mission_id)


def wait_until(condition: Callable[[], object], seconds: float = 60.0) -> None:
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline, "it did not happen in time"
        time.sleep(0.02)
