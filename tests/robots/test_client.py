import ast
import sys
import threading
from contextlib import closing
from pathlib import Path

import pytest

from robots import client as client_module
from robots.client import MAX_BATCH, MAX_BODY, ClientError, RobotClient


def observations(first: int, count: int, padding: int = 0) -> list[dict]:
    return [{"seq": first + k, "stamp_s": (first + k) / 20, "note": "x" * padding} for k in range(count)]


@pytest.fixture
def client(fake_control):
    client = RobotClient(fake_control.url, "m 1", "r1", patience_s=5.0)
    with closing(client):
        client.create_mission("A school")
        client.register(start_pose={"x_m": 1.0, "y_m": 2.0, "yaw_rad": 0.0, "sd_m": 0.1, "sd_rad": 0.1})
        yield client


def seqs(fake_control) -> list[int]:
    return [item["seq"] for item in fake_control.observations["r1"]]


def test_is_a_single_file_of_the_standard_library():
    tree = ast.parse(Path(client_module.__file__).read_text())
    roots = {node.module.split(".")[0] for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    roots |= {
        name.name.split(".")[0]
        for node in ast.walk(tree)
        if isinstance(node, ast.Import)
        for name in node.names
    }
    assert roots <= set(sys.stdlib_module_names)


def test_joins_a_mission_that_exists_and_registers_again(fake_control, client):
    again = RobotClient(fake_control.url, "m 1", "r1")
    assert again.create_mission("another name") == {"mission_id": "m 1", "name": "A school"}
    client.post(observations(0, 3))
    body = fake_control.robots["r1"]
    assert again.register(start_pose=body["start_pose"])["next_seq"] == 3
    with pytest.raises(ClientError, match="other words") as error:
        again.register(agent="onboard")
    assert (error.value.code, error.value.status) == ("different_robot", 409)
    again.close()


def test_posts_over_one_connection(fake_control, client):
    before = fake_control.connections
    for k in range(20):
        assert client.post(observations(4 * k, 4))["next_seq"] == 4 * k + 4
    assert fake_control.connections == before
    assert seqs(fake_control) == list(range(80))


def test_sends_a_backlog_in_order_and_within_the_limits(fake_control, client):
    client.keep(observations(0, 4500))
    assert client.waiting == 4500
    reply = client.post(observations(4500, 4))
    assert reply["next_seq"] == 4504
    assert client.waiting == 0
    assert [len(post["observations"]) for post in fake_control.posts["r1"]] == [MAX_BATCH, MAX_BATCH, 504]
    assert seqs(fake_control) == list(range(4504))


def test_splits_by_bytes_too(fake_control, client):
    client.post(observations(0, 12, padding=MAX_BODY // 5))
    assert [len(post["observations"]) for post in fake_control.posts["r1"]] == [4, 4, 4]


def test_an_observation_larger_than_a_body_is_refused_by_name(client):
    with pytest.raises(ClientError, match="observation 0 alone"):
        client.post(observations(0, 1, padding=MAX_BODY))


def test_onboard_decisions_travel_with_their_observations(fake_control, client):
    client.keep(observations(0, 2001), [{"seq": k, "pose": {}, "command": {}} for k in range(2001)])
    client.post()
    first, second = fake_control.posts["r1"]
    assert [item["seq"] for item in first["onboard"]] == list(range(2000))
    assert [item["seq"] for item in second["onboard"]] == [2000]


@pytest.mark.parametrize("failure", ["drop", "late", "503", "500", "429"])
def test_sends_again_when_an_exchange_fails(fake_control, client, failure):
    client.post(observations(0, 4))
    fake_control.failures = [failure, failure]
    reply = client.post(observations(4, 4))
    assert reply["next_seq"] == 8
    assert reply["duplicates"] == (4 if failure == "late" else 0)
    assert seqs(fake_control) == list(range(8))


def test_survives_a_server_that_restarts(fake_control, client):
    client.post(observations(0, 4))
    fake_control.stop()
    restart = threading.Timer(0.3, fake_control.start)
    restart.start()
    assert client.post(observations(4, 4))["next_seq"] == 8
    restart.join()


def test_out_of_patience_nothing_is_lost(fake_control, client):
    client.post(observations(0, 4))
    fake_control.stop()
    client.patience_s = 0.1
    with pytest.raises(ClientError, match=r"no answer from 127.0.0.1") as error:
        client.post(observations(4, 4))
    assert error.value.code == "unreachable"
    assert client.waiting == 4
    fake_control.start()
    client.post(observations(8, 1))
    assert seqs(fake_control) == list(range(9))


def test_goes_back_where_the_server_forgot(fake_control, client):
    for k in range(10):
        client.post(observations(4 * k, 4))
    fake_control.next_seq["r1"] = 25
    fake_control.observations["r1"] = fake_control.observations["r1"][:25]
    assert client.post(observations(40, 4))["next_seq"] == 44
    assert seqs(fake_control) == list(range(44))


def test_a_gap_that_cannot_be_closed_is_an_error(client):
    with pytest.raises(ClientError, match="next_seq is 0") as error:
        client.post(observations(5, 1))
    assert error.value.code == "gap"


def test_refusals_are_errors_at_once(fake_control):
    stranger = RobotClient(fake_control.url, "nowhere", "r1")
    with pytest.raises(ClientError, match="no such mission") as error:
        stranger.register()
    assert (error.value.code, error.value.status) == ("unknown_mission", 404)
    stranger.close()


def test_an_exchange_times_out(fake_control, client):
    impatient = RobotClient(fake_control.url, "m 1", "r1", timeout_s=0.1, patience_s=0.2)
    fake_control.blocked.clear()
    with pytest.raises(ClientError, match="no answer"):
        impatient.post(observations(0, 1))
    impatient.close()


def test_close_wakes_a_waiting_post(fake_control, client):
    fake_control.blocked.clear()
    timer = threading.Timer(0.2, client.close)
    timer.start()
    with pytest.raises(ClientError, match="closed"):
        client.post(observations(0, 1))
    timer.join()


@pytest.mark.parametrize("url", ["control:8000", "ftp://control", "http://"])
def test_an_address_that_is_none(url):
    with pytest.raises(ClientError, match="not the address"):
        RobotClient(url, "m", "r")


def test_not_a_number_never_leaves(client):
    with pytest.raises(ValueError, match=r"not JSON compliant|Out of range"):
        client.post([{"seq": 0, "stamp_s": float("nan")}])
