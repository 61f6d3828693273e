"""A page's line to its 3D view: where the scene is, what is to be marked, and what ends it."""

import json
from contextlib import ExitStack

import pytest
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from web.viser.seats import Wish

SEAT = "0123456789abcdef" * 2


def view(line, seat=SEAT):
    return connect(f"ws://127.0.0.1:{line.control.port}/api/v1{line.at}/view?seat={seat}")


def page(line, key):
    return line.control.call("GET", f"http://127.0.0.1:{line.control.port}/viser/{key}/dark/").status_code


def test_a_seat_is_there_as_long_as_its_socket_and_takes_the_wishes(driven, wait_until):
    scenes = driven.control._app.state.scenes
    with view(driven) as socket:
        key = json.loads(socket.recv(timeout=60))["scene"]
        assert key == f"driven@{SEAT}"
        assert page(driven, key) == 200
        socket.send(json.dumps({"selected": ["tag", "A1"], "follows": True, "centred": 2}))
        wait_until(lambda: scenes._seats[key].wish == Wish(("tag", "A1"), True, 2))
        scenes._seats[key].click(("robot", "r1"))
        assert json.loads(socket.recv(timeout=60)) == {"clicked": {"kind": "robot", "id": "r1"}}
    wait_until(lambda: page(driven, key) == 404)


def test_a_page_that_lost_its_line_opens_it_again(driven):
    with view(driven) as first:
        key = json.loads(first.recv(timeout=60))["scene"]
        with view(driven) as second:
            assert json.loads(second.recv(timeout=60))["scene"] == key
            with pytest.raises(ConnectionClosed) as closed:
                first.recv(timeout=60)
            assert closed.value.rcvd.code == 4409
            assert page(driven, key) == 200


@pytest.mark.parametrize(
    "nonsense",
    [
        "nan",
        "[]",
        '{"selected": ["mission", "x"]}',
        '{"selected": ["tag", ""]}',
        '{"selected": ["tag"]}',
        '{"centred": -1}',
        '{"more": 1}',
        '{"selected": ["tag", "' + "x" * 2000 + '"]}',
    ],
)
def test_nonsense_ends_it(driven, nonsense):
    with view(driven) as socket:
        socket.recv(timeout=60)
        socket.send(nonsense)
        with pytest.raises(ConnectionClosed) as closed:
            socket.recv(timeout=60)
        assert closed.value.rcvd.code == 1008


@pytest.mark.parametrize("seat", ["", "x", "0" * 31, "0" * 33, "G" * 32, "../" + "0" * 29])
def test_a_seat_has_to_be_a_secret(driven, seat):
    with ExitStack() as stack, pytest.raises(Exception, match="403"):
        stack.enter_context(view(driven, seat))


def test_an_unknown_mission_has_no_seats(control):
    line = control.open()
    line.at = "/missions/nowhere"
    with view(line) as socket, pytest.raises(ConnectionClosed) as closed:
        socket.recv(timeout=60)
    assert closed.value.rcvd.code == 4404
