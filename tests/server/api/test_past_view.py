"""The past in 3D: a scene of one's own that follows the moment, and a recording of all of it."""

import json

import msgspec
import pytest
import zstandard
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from web.viser.scenes import MAX_PAST_SCENES


def view(line):
    return connect(f"ws://127.0.0.1:{line.control.port}/api/v1{line.at}/history/view")


def page(line, key):
    return line.control.call("GET", f"http://127.0.0.1:{line.control.port}/viser/{key}/").status_code


def drawn(line, key):
    """Where the robot stands in somebody's scene, None where it is not there."""
    scene = line.control._app.state.scenes._past[key].scene
    robot = scene._robots._robots.get("r1")
    return None if robot is None else tuple(robot.frame.position)


def test_a_scene_shows_the_moment_that_is_asked_for(driven, wait_until):
    index = driven.get("/history")
    with view(driven) as socket:
        key = json.loads(socket.recv(timeout=60))["scene"]
        assert key.startswith("driven@")
        assert page(driven, key) == 200
        for share in (0.9, 0.5, 0.0):
            moment = index["begins_unix_s"] + share * (index["ends_unix_s"] - index["begins_unix_s"])
            socket.send(json.dumps({"unix_s": moment}))
            assert json.loads(socket.recv(timeout=60))["shown_unix_s"] == moment
            robot = driven.get(f"/history/state?unix_s={moment}")["state"].get("robot/r1")
            place = drawn(driven, key)
            if robot is None:
                assert place is None
            else:
                assert place == pytest.approx((robot["x_m"], robot["y_m"], 0.03))
    wait_until(lambda: page(driven, key) == 404)  # it ends with the socket
    assert page(driven, "driven@guessed") == 404


def test_scenes_are_limited_and_nonsense_ends_them(driven, wait_until):
    scenes = driven.control._app.state.scenes
    for nonsense in ("nan", "7", '{"unix_s": -1}', '{"unix_s": NaN}', "x", '{"unix_s": 1e12}', "9" * 2000):
        with view(driven) as socket:
            socket.recv(timeout=60)
            socket.send(nonsense)
            with pytest.raises(ConnectionClosed):
                socket.recv(timeout=60)
    wait_until(lambda: not scenes._past)
    sockets = [view(driven) for _ in range(MAX_PAST_SCENES)]
    for socket in sockets:
        socket.recv(timeout=60)
    with view(driven) as socket, pytest.raises(ConnectionClosed) as closed:
        socket.recv(timeout=60)
    assert "too many people" in str(closed.value)
    for socket in sockets:
        socket.close()
    wait_until(lambda: not scenes._past, seconds=30.0)


def test_the_recording_is_as_long_as_the_mission_and_holds_its_robot(driven):
    response = driven.call("GET", "/history/recording.viser")
    assert response.status_code == 200
    content = zstandard.ZstdDecompressor().decompressobj().decompress(response.content[8:])
    length = int.from_bytes(content[:8], "little")
    film = msgspec.msgpack.decode(content[8 : 8 + length])
    index = driven.get("/history")
    assert 0.0 < film["durationSeconds"] <= index["ends_unix_s"] - index["begins_unix_s"] + 25.0
    texts = [message.get("props", {}).get("text") for _, message in film["messages"]]
    assert "r1" in texts
    poses = {
        tuple(message["position"])
        for _, message in film["messages"]
        if message["type"] == "SetPositionMessage" and message["name"] == "/robots/1"
    }
    assert len(poses) > 1
    walls = [message for _, message in film["messages"] if message.get("name") == "/map/walls"]
    assert walls


def test_nothing_of_another_mission_is_recorded(control):
    line = control.open()
    line.at = "/missions/nowhere"
    assert line.refused("GET", "/history/recording.viser")[:2] == (404, "unknown_mission")
