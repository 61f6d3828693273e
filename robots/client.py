"""The client a robot carries: this one file, Python's standard library, nothing else of the project.

    client = RobotClient("http://control:8000", "mission-1", "r1") client.create_mission("Collapsed school")
    client.register(agent="server", start_pose={"x_m": 1.0, "y_m": 2.0, "yaw_rad": 0.0, "sd_m": 0.1, "sd_rad":
    0.02}) reply = client.post([{"seq": 0, "stamp_s": 0.05, "odometry": {...}}]) drive(reply["command"]) if
    not reply["stop"] else stand_still()

What ``say`` of a command holds goes to the robots in radio reach, as it is; what they said goes, in base64,
into ``heard`` of the next observation.

Observations may be posted again at any time: the server knows them by their ``seq``. In radio silence call
``keep``; the next ``post`` sends everything kept, in order, in as many requests as the server's limits ask
for.
"""

from __future__ import annotations

import json
import os
import socket
import threading
import time
from collections import deque
from collections.abc import Sequence
from contextlib import suppress
from http.client import HTTPConnection, HTTPException, HTTPResponse, HTTPSConnection
from typing import Any
from urllib.parse import quote, urlsplit

MAX_BATCH = 2000  # observations the server takes in one request
MAX_BODY = 4 * 1024 * 1024  # bytes
_ROOM = 256  # bytes of a body that are not observations
_REMEMBERED = 4000  # acknowledged observations kept, for a server that comes back without its last seconds
_FIRST_WAIT_S, _LONGEST_WAIT_S = 0.05, 2.0

Json = dict[str, Any]


class ClientError(Exception):
    """The server refused, or could not be reached.

    ``code`` is the server's, or "unreachable", "closed", "bad_reply".
    """

    def __init__(self, code: str, message: str, status: int | None = None, field: str | None = None) -> None:
        super().__init__(message)
        self.code = code
        self.status = status
        self.field = field


class _Item:
    """One observation waiting to be sent, encoded once."""

    __slots__ = ("data", "onboard", "seq")

    def __init__(self, seq: int, data: bytes, onboard: bytes | None) -> None:
        self.seq = seq
        self.data = data
        self.onboard = onboard

    @property
    def size(self) -> int:
        return len(self.data) + (len(self.onboard) + 1 if self.onboard is not None else 0) + 1


class RobotClient:
    """One robot's line to mission control.

    Use it from one thread at a time; only ``close`` may come from another.
    ``token``: what mission control made for this robot, by default WAYMARK_TOKEN of the environment.
    ``timeout_s`` is for one exchange; for ``patience_s`` a request is sent again while the server is
    unreachable, busy or failing, then ClientError "unreachable" is raised. Nothing posted is lost by that:
    the next ``post`` takes it along.
    """

    def __init__(
        self,
        url: str,
        mission_id: str,
        robot_id: str,
        *,
        timeout_s: float = 10.0,
        patience_s: float = 30.0,
        token: str | None = None,
        headers: dict[str, str] | None = None,
    ) -> None:
        parts = urlsplit(url)
        if parts.scheme not in ("http", "https") or not parts.hostname:
            raise ClientError("bad_url", f"{url!r} is not the address of a server; use http://HOST:PORT")
        self._secure = parts.scheme == "https"
        self._host, self._port = parts.hostname, parts.port
        self._root = f"{parts.path.rstrip('/')}/api/v1/missions"
        self._mission_id, self._robot_id = mission_id, robot_id
        self._mission = f"{self._root}/{quote(mission_id, safe='')}"
        self._robot = f"{self._mission}/robots/{quote(robot_id, safe='')}"
        self._timeout_s, self.patience_s = timeout_s, patience_s
        self._headers = {"Content-Type": "application/json", "Accept": "application/json", **(headers or {})}
        token = token or os.environ.get("WAYMARK_TOKEN")
        if token:
            self._headers["Authorization"] = f"Bearer {token}"
        self._connection: HTTPConnection | None = None
        self._answered = False  # something came over the present connection
        self._busy = threading.Lock()
        self._closing = threading.Event()
        self._backlog: deque[_Item] = deque()
        self._sent: deque[_Item] = deque(maxlen=_REMEMBERED)

    @property
    def waiting(self) -> int:
        """Observations kept that the server has not acknowledged."""
        return len(self._backlog)

    def create_mission(self, name: str, tag_key: str | None = None) -> Json:
        """Open the mission, or join it where it exists. Return the server's description of it.

        ``tag_key``: seals what its robots write into tags, in hexadecimal digits; the server makes one up.
        """
        body = {"name": name, "mission_id": self._mission_id, "tag_key": tag_key}
        try:
            return self.request("POST", self._root, body)
        except ClientError as error:
            if error.status != 409:
                raise
        return self.request("GET", self._mission)

    def register(
        self,
        agent: str = "server",
        start_pose: Json | None = None,
        silence: Json | None = None,
        config: Json | None = None,
    ) -> Json:
        """Register the robot, or join again with the same words.

        The reply's ``next_seq`` is where to go on.
        """
        body: Json = {"robot_id": self._robot_id, "agent": agent}
        for name, value in (("silence", silence), ("start_pose", start_pose), ("config", config)):
            if value is not None:
                body[name] = value
        return self.request("POST", f"{self._mission}/robots", body)

    def keep(self, observations: Sequence[Json], onboard: Sequence[Json] | None = None) -> None:
        """Keep observations for the next ``post``.

        ``onboard`` are what an agent on board made of them, by ``seq``.
        """
        decisions = {item["seq"]: _encode(item) for item in onboard or ()}
        for observation in observations:
            seq = observation["seq"]
            item = _Item(seq, _encode(observation), decisions.get(seq))
            if item.size + _ROOM > MAX_BODY:
                raise ClientError("too_large", f"observation {seq} alone is larger than the server takes")
            self._backlog.append(item)

    def post(self, observations: Sequence[Json] = (), onboard: Sequence[Json] | None = None) -> Json:
        """Send observations after all that was kept; return the reply to the last request.

        Raises:
            ClientError: refused, or out of patience. One that is refused (the mission was closed, or is a
                draft still) stands still.
        """
        self.keep(observations, onboard)
        reply = self._post_batch()
        while self._backlog:
            reply = self._post_batch()
        return reply

    def request(self, method: str, path: str, body: Json | bytes | None = None) -> Json:
        """Exchange one request, again and again until it gets an answer; return the reply's JSON object.

        Raises:
            ClientError: refused, or out of patience.
        """
        data = body if isinstance(body, bytes) or body is None else _encode(body)
        give_up = time.monotonic() + self.patience_s
        wait_s = _FIRST_WAIT_S
        while True:
            if self._closing.is_set():
                raise ClientError("closed", "the client was closed")
            try:
                with self._busy:
                    status, reply = self._exchange(method, path, data)
                if status < 500 and status != 429:
                    return _checked(status, reply)
                trouble = f"status {status}"
            except (OSError, HTTPException) as error:
                stale = self._answered  # the server may just have hung up on a quiet connection
                self._hang_up()
                if stale:
                    continue
                trouble = str(error) or type(error).__name__
            if time.monotonic() + wait_s > give_up:
                server = f"{self._host}:{self._port}" if self._port else self._host
                raise ClientError(
                    "unreachable", f"no answer from {server} ({trouble}); is the server running?"
                )
            self._closing.wait(wait_s)
            wait_s = min(2.0 * wait_s, _LONGEST_WAIT_S)

    def close(self) -> None:
        """Give up at once whatever goes on, from any thread, and hang up."""
        self._closing.set()
        connection = self._connection
        if connection is not None and connection.sock is not None:
            with suppress(OSError):  # gone already
                connection.sock.shutdown(socket.SHUT_RDWR)  # wakes the thread that waits for a reply
        with self._busy:
            self._hang_up()

    def _post_batch(self) -> Json:
        batch: list[_Item] = []
        size = _ROOM
        for item in self._backlog:
            if len(batch) == MAX_BATCH or size + item.size > MAX_BODY:
                break
            batch.append(item)
            size += item.size
        body = b'{"observations":[' + b",".join(item.data for item in batch) + b"]"
        decisions = [item.onboard for item in batch if item.onboard is not None]
        if decisions:
            body += b',"onboard":[' + b",".join(decisions) + b"]"
        try:
            reply = self.request("POST", f"{self._robot}/observations", body + b"}")
        except ClientError as error:
            if error.code != "gap" or not self._rewind():
                raise
            return self._post_batch()
        for _ in batch:
            self._sent.append(self._backlog.popleft())
        return reply

    def _rewind(self) -> bool:
        """Put back what the server has not got after all; return False where that cannot close the gap."""
        next_seq = self.request("GET", self._robot)["next_seq"]
        first = self._backlog[0].seq if self._backlog else None
        while self._sent and self._sent[-1].seq >= next_seq:
            self._backlog.appendleft(self._sent.pop())
        return bool(self._backlog) and self._backlog[0].seq <= next_seq and self._backlog[0].seq != first

    def _exchange(self, method: str, path: str, data: bytes | None) -> tuple[int, bytes]:
        """Return status and body, over the open connection if there is one."""
        connection = self._connection
        if connection is None:
            kind = HTTPSConnection if self._secure else HTTPConnection
            connection = self._connection = kind(self._host, self._port, timeout=self._timeout_s)
        connection.request(method, path, body=data, headers=self._headers)
        response: HTTPResponse = connection.getresponse()
        reply = response.read()
        self._answered = True
        if response.will_close:
            self._hang_up()
        return response.status, reply

    def _hang_up(self) -> None:
        connection, self._connection = self._connection, None
        self._answered = False
        if connection is not None:
            connection.close()


def _encode(value: Json) -> bytes:
    return json.dumps(value, separators=(",", ":"), allow_nan=False).encode()


def _checked(status: int, data: bytes) -> Json:
    """Return the JSON object of a reply.

    Raises ClientError for a refusal or for something else than our server.
    """
    try:
        reply = json.loads(data)
    except ValueError:
        reply = None
    if 200 <= status < 300 and isinstance(reply, dict):
        return reply
    error = reply.get("error") if isinstance(reply, dict) else None
    if isinstance(error, dict):
        code, message = str(error.get("code")), str(error.get("message"))
        raise ClientError(code, message, status, error.get("field"))
    raise ClientError(
        "bad_reply", f"status {status}: the answer is not mission control's; check the address", status
    )
