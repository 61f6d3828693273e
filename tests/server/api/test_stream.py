"""The stream: snapshot first, coalesced changes, a heartbeat; and readers that must not disturb others."""

import json
import socket
import time

import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect


def test_an_empty_change_is_the_heartbeat(line):
    with line.stream() as stream:
        assert stream.state["mission"]["mission_id"] == line.mission_id
        stream.settle()
        began = time.monotonic()
        message = stream.next()
    assert (message["set"], message["delete"]) == ({}, [])
    assert time.monotonic() - began > 0.5
    assert abs(message["server_unix_s"] - time.time()) < 5.0


def test_changes_are_coalesced(line):
    """A thousand changes at once are a message or two, and the last state is in the end."""
    board = line.control.missions.get(line.mission_id).board

    def burst():
        for x in range(1000):
            board.publish({"trail/r9": {"points_m": [[float(x), 0.5]]}})

    with line.stream() as stream:
        stream.settle()
        _loop_of(line).call_soon_threadsafe(burst)
        count = 0
        while stream.state.get("trail/r9") != {"points_m": [[999.0, 0.5]]}:
            count += bool(stream.next()["set"])
    assert 1 <= count <= 3


def test_what_a_reader_sends_is_of_no_interest(line):
    url = f"ws://127.0.0.1:{line.control.port}/api/v1{line.at}/stream"
    with connect(url) as connection:
        connection.recv()
        connection.send("hello")
        connection.send(b"\x00\xff")
        for _ in range(3):
            assert json.loads(connection.recv(timeout=60))["type"] == "changes"


def test_one_that_never_reads_holds_nobody_up(line, drive):
    """It asks for the stream and never reads a byte, while the board changes by ten megabytes."""
    board = line.control.missions.get(line.mission_id).board
    request = (
        f"GET /api/v1{line.at}/stream HTTP/1.1\r\nHost: 127.0.0.1:{line.control.port}\r\n"
        "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
    )
    raw = socket.socket()
    raw.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    with raw:
        raw.connect(("127.0.0.1", line.control.port))
        raw.sendall(request.encode())
        with line.stream() as stream:
            loop = _loop_of(line)
            for number, wires in enumerate(drive.wires[:30]):
                value = {"points_m": [[float(number), 0.5]] * 20_000}
                loop.call_soon_threadsafe(board.publish, {"trail/r9": value})
                line.send(wires)  # answered, though one watcher reads nothing
            last = drive.batches[29][-1].stamp_s
            stream.until(lambda s: s.state.get("robot/r1", {}).get("stamp_s") == last)
            stream.until(lambda s: s.state["trail/r9"]["points_m"][0] == [29.0, 0.5])


def test_a_foreign_page_may_not_listen_or_change(line):
    with pytest.raises(InvalidStatus) as refused, line.stream(origin="http://evil.example"):
        pass
    assert refused.value.response.status_code == 403
    with line.stream(origin=f"http://127.0.0.1:{line.control.port}") as stream:
        assert stream.state
    headers = {"Origin": "http://evil.example"}
    assert line.refused("POST", "/stop", {}, headers=headers)[:2] == (403, "foreign_origin")
    assert line.call("GET", "/robots", headers=headers).status_code == 200
    own = {"Origin": f"http://127.0.0.1:{line.control.port}"}
    assert line.call("POST", "/stop", {}, headers=own).status_code == 200
    assert line.refused("POST", "/stop", {}, headers={"Origin": "null"})[0] == 403


def test_an_unknown_mission_is_told(control):
    url = f"ws://127.0.0.1:{control.port}/api/v1/missions/nowhere/stream"
    with connect(url) as connection, pytest.raises(ConnectionClosed) as closed:
        connection.recv(timeout=60)
    assert closed.value.rcvd.code == 4404
    assert "nowhere" in closed.value.rcvd.reason


def _loop_of(line):
    return line.control.missions.get(line.mission_id).shared_map._team._task.get_loop()
