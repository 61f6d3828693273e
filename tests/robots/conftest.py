"""A mission control small enough to read: it speaks the robot API, and fails when a test asks it to."""

import json
import threading
from collections.abc import Callable, Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any
from urllib.parse import unquote

import pytest


class FakeControl:
    """``decide(robot_id, observations) -> command`` leads; ``posts`` notes every body posted, by robot."""

    def __init__(self, decide: Callable[[str, list[dict[str, Any]]], dict[str, Any]]) -> None:
        self.decide = decide
        self.missions: dict[str, dict[str, Any]] = {}
        self.robots: dict[str, dict[str, Any]] = {}
        self.next_seq: dict[str, int] = {}
        self.posts: dict[str, list[dict[str, Any]]] = {}
        self.observations: dict[str, list[dict[str, Any]]] = {}
        self.stopped: set[str] = set()
        self.connections = 0
        self.failures: list[
            str
        ] = []  # for the next requests: "drop", "late" (dropped when done), or a status
        self.blocked = threading.Event()
        self.blocked.set()
        self._last: dict[str, dict[str, Any]] = {}
        self._lock = threading.Lock()
        self._server: ThreadingHTTPServer | None = None
        self._thread: threading.Thread | None = None
        self.port = 0
        self.down = False

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.port}"

    def start(self) -> None:
        control = self
        self.down = False

        class Handler(BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"
            disable_nagle_algorithm = True

            def setup(self) -> None:
                super().setup()
                control.connections += 1

            def log_message(self, *_: object) -> None:
                pass

            def do_GET(self) -> None:
                self._answer("GET")

            def do_POST(self) -> None:
                self._answer("POST")

            def _answer(self, method: str) -> None:
                data = self.rfile.read(int(self.headers.get("Content-Length", 0)))
                control.blocked.wait(10)
                with control._lock:
                    failure = control.failures.pop(0) if control.failures else None
                    if failure == "drop" or control.down:
                        self.close_connection = True
                        return
                    if failure is not None and failure.isdigit():
                        status, reply = (
                            int(failure),
                            {"error": {"code": "busy", "message": "later", "field": None}},
                        )
                    else:
                        status, reply = control._route(method, self.path, json.loads(data) if data else {})
                if failure == "late":
                    self.close_connection = True
                    return
                body = json.dumps(reply).encode()
                self.send_response(status)
                self.send_header("Content-Length", str(len(body)))
                self.end_headers()
                self.wfile.write(body)

        class Server(ThreadingHTTPServer):
            daemon_threads = True
            allow_reuse_address = True

            def handle_error(self, *_: object) -> None:
                pass  # a client that hangs up is no error here

        self._server = Server(("127.0.0.1", self.port), Handler)
        self.port = self._server.server_address[1]
        self._thread = threading.Thread(target=self._server.serve_forever, kwargs={"poll_interval": 0.02})
        self._thread.start()

    def stop(self) -> None:
        assert self._server is not None
        assert self._thread is not None
        self.down = True  # also for connections that are open
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()

    def _route(self, method: str, path: str, body: dict[str, Any]) -> tuple[int, dict[str, Any]]:
        parts = unquote(path).removeprefix("/api/v1/missions").strip("/").split("/")
        if parts == [""]:
            if body["mission_id"] in self.missions:
                return _error(409, "mission_exists", "there is such a mission")
            self.missions[body["mission_id"]] = {"mission_id": body["mission_id"], "name": body["name"]}
            return 201, self.missions[body["mission_id"]]
        if parts[0] not in self.missions:
            return _error(404, "unknown_mission", "there is no such mission")
        if len(parts) == 1:
            return 200, self.missions[parts[0]]
        if len(parts) == 2:
            known = self.robots.setdefault(body["robot_id"], body)
            if known != body:
                return _error(409, "different_robot", "registered with other words")
            return 200, {
                "robot_id": body["robot_id"],
                "next_seq": self.next_seq.setdefault(body["robot_id"], 0),
            }
        robot_id = parts[2]
        if len(parts) == 3:
            return 200, {"robot_id": robot_id, "next_seq": self.next_seq[robot_id]}
        return self._observe(robot_id, body)

    def _observe(self, robot_id: str, body: dict[str, Any]) -> tuple[int, dict[str, Any]]:
        self.posts.setdefault(robot_id, []).append(body)
        expected = self.next_seq[robot_id]
        if body["observations"][0]["seq"] > expected:
            return _error(409, "gap", f"next_seq is {expected}")
        fresh = [item for item in body["observations"] if item["seq"] >= expected]
        if fresh:
            self.next_seq[robot_id] = fresh[-1]["seq"] + 1
            self.observations.setdefault(robot_id, []).extend(fresh)
            self._last[robot_id] = self.decide(robot_id, fresh)
        stop = robot_id in self.stopped
        return 200, {
            "next_seq": self.next_seq[robot_id],
            "accepted": len(fresh),
            "duplicates": len(body["observations"]) - len(fresh),
            "stop": stop,
            "pose": {"x_m": 0.0, "y_m": 0.0, "yaw_rad": 0.0},
            "command": STILL if stop else self._last[robot_id],
            "differences": [],
            "orders": [],
        }


STILL = {"linear_mps": 0.0, "angular_radps": 0.0, "drop_tag": False, "writes": []}


def _error(status: int, code: str, message: str) -> tuple[int, dict[str, Any]]:
    return status, {"error": {"code": code, "message": message, "field": None}}


@pytest.fixture
def fake_control() -> Iterator[FakeControl]:
    control = FakeControl(lambda *_: dict(STILL))
    control.start()
    yield control
    control.blocked.set()
    control.stop()
