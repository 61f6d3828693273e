"""STOP is in every reply, whatever becomes of agents, server and database."""

import os
import signal
import threading
import time
from dataclasses import astuple

from hypothesis import given
from hypothesis import strategies as st

from robots.types import Displacement, DistanceTurn, Observation, WheelEncoders
from server.stopping import Stopping

STILL = {"linear_mps": 0.0, "angular_radps": 0.0, "drop_tag": False, "writes": [], "say": None}


def moving(reply):
    return not reply["stop"] and (reply["command"]["linear_mps"], reply["command"]["angular_radps"]) != (
        0.0,
        0.0,
    )


def stopped(reply):
    return reply["stop"] and reply["command"] == STILL


def test_stop_and_resume(line, drive):
    """The agent goes on thinking meanwhile, and the robot goes on where it would have been."""
    replies = [line.send(wires) for wires in drive.wires[:20]]
    assert moving(replies[-1])
    answer = line.call("POST", "/stop", {"robots": ["r1"]})
    assert answer.json() == {"stopped": ["r1"]}
    assert stopped(line.send(drive.wires[19]))
    reply = line.send(drive.wires[20])
    assert stopped(reply)
    assert reply["pose"] == drive.expected(20)["pose"]
    with line.stream() as stream:
        assert stream.state["robot/r1"]["stopped"]
        assert line.call("POST", "/resume", {"robots": ["r1"]}).json() == {"stopped": []}
        stream.until(lambda s: not s.state["robot/r1"]["stopped"])
    reply = line.send(drive.wires[21])
    assert {name: reply[name] for name in ("pose", "command")} == drive.expected(21)
    assert moving(reply)
    assert [event["text"] for event in line.events("stop")] == ["STOP for r1 by operator."]
    assert [event["text"] for event in line.events("resume")] == ["r1 may go on, says operator."]


def test_stop_is_heard_by_who_speaks_again_after_the_reply_that_told_it(line, drive):
    board = line.control.missions.get(line.mission_id).board
    line.send(drive.wires[0])
    line.call("POST", "/stop", {"robots": ["r1"]})
    assert not board.get("robot/r1")["stop_heard"]
    line.send(drive.wires[1])  # it had not heard of STOP when it sent this
    assert not board.get("robot/r1")["stop_heard"]
    line.send(drive.wires[1])  # sent again: the reply may be lost
    assert not board.get("robot/r1")["stop_heard"]
    line.send(drive.wires[2])
    assert board.get("robot/r1")["stop_heard"]
    line.call("POST", "/resume", {"robots": ["r1"]})
    line.call("POST", "/stop", {"robots": ["r1"]})
    assert not board.get("robot/r1")["stop_heard"]  # a new order


ODOMETRY = st.one_of(
    st.builds(WheelEncoders, *[st.floats(-1, 1)] * 4),
    st.builds(DistanceTurn, st.floats(-1, 1), st.floats(-3, 3)),
    st.builds(Displacement, st.floats(-1, 1), st.floats(-1, 1), st.floats(-3, 3)),
)


@given(ODOMETRY, st.floats(0.05, 2.0), st.floats(0.0, 1e9))
def test_what_stands_still_has_no_speed_and_what_moves_or_turns_has_one(odometry, elapsed_s, now_s):
    stopping = Stopping()
    stopping.take([Observation(0, now_s, odometry), Observation(1, now_s + elapsed_s, odometry)], None)
    assert stopping.speed_mps is not None
    assert (stopping.speed_mps == 0.0) == all(value == 0.0 for value in astuple(odometry))
    stopping.take([Observation(2, now_s + 2 * elapsed_s)], now_s + elapsed_s)
    assert stopping.speed_mps is None


def test_stop_for_all_holds_for_robots_to_come(line, drive):
    line.register("r2")
    assert line.call("POST", "/stop", {"robots": None}).json() == {"stopped": ["r1", "r2"]}
    assert line.register("r3").json()["stopped"]
    assert stopped(line.send(drive.wires[0], "r3"))
    assert line.call("POST", "/resume", {"robots": ["r2"]}).json() == {"stopped": ["r1", "r3"]}
    assert line.call("POST", "/resume", {}).json() == {"stopped": []}
    assert not line.register("r4").json()["stopped"]


def test_nobody_is_stopped_when_one_name_is_wrong(line):
    body = {"robots": ["r1", "r9"]}
    assert line.refused("POST", "/stop", body) == (404, "unknown_robot", None)
    assert not line.get("/robots/r1")["stopped"]
    assert line.refused("POST", "/stop", {"robots": []}) == (422, "invalid", "robots")


def test_stop_survives_a_restart(tmp_path, make_control, drive):
    control = make_control(tmp_path)
    some, everybody = control.open("some"), control.open("everybody")
    for line in (some, everybody):
        line.register("r1")
        line.register("r2")
    some.call("POST", "/stop", {"robots": ["r1"]})
    everybody.call("POST", "/stop", {"robots": ["r2"]})
    everybody.call("POST", "/stop", {"robots": None})
    control.stop()
    control.start()
    for line, all_ in ((some, False), (everybody, True)):
        assert stopped(line.send(drive.wires[0], "r1"))
        assert line.send(drive.wires[0], "r2")["stop"] is all_
        assert line.register("r3").json()["stopped"] is all_
        line.call("POST", "/resume", {"robots": None})
    control.stop()
    assert control.sql("SELECT stopped_all FROM missions") == [(0,), (0,)]
    assert control.sql("SELECT DISTINCT stopped FROM robots") == [(0,)]


def test_a_stopped_robot_is_told_at_once_while_its_agent_is_stuck(line, drive, wait_until):
    for wires in drive.wires[:10]:
        line.send(wires)
    pid = line.agent_pid()
    os.kill(pid, signal.SIGSTOP)  # neither dead nor answering
    try:
        waiting: list = []
        thread = threading.Thread(target=lambda: waiting.append(line.send(drive.wires[10])))
        thread.start()
        wait_until(lambda: line.get("/robots/r1")["next_seq"] == 44)
        line.call("POST", "/stop", {"robots": None})
        thread.join()
        assert stopped(waiting[0])  # also the request that waited already
        reply = line.send(drive.wires[11])
        assert stopped(reply)
        assert (reply["accepted"], reply["next_seq"]) == (4, 48)
        board = line.control.missions.get(line.mission_id).board
        sent_unix_s = time.time()
        line.send(drive.wires[12])
        wait_until(lambda: board.get("robot/r1")["heard_unix_s"] >= sent_unix_s)
        assert board.get("robot/r1")["link"] == "live"  # not told only once it was silent
        known = board.get("robot/r1")
        assert (known["stopped"], known["stop_heard"], known["agent_down"]) == (True, True, True)
        assert known["speed_mps"] > 0.03  # by its wheels: nobody obeyed
    finally:
        os.kill(pid, signal.SIGCONT)
    line.call("POST", "/resume", {"robots": None})
    wait_until(lambda: not board.get("robot/r1")["agent_down"])
    reply = line.send(drive.wires[13])
    assert {name: reply[name] for name in ("pose", "command")} == drive.expected(13)


def test_a_stopped_robot_is_told_at_once_while_its_agent_is_killed(line, drive):
    for wires in drive.wires[:10]:
        line.send(wires)
    line.call("POST", "/stop", {"robots": None})
    os.kill(line.agent_pid(), signal.SIGKILL)
    assert stopped(line.send(drive.wires[10]))
    line.call("POST", "/resume", {"robots": None})
    reply = line.send(drive.wires[11])
    assert {name: reply[name] for name in ("pose", "command")} == drive.expected(11)


def test_stop_holds_when_it_cannot_be_saved(line, drive):
    line.send(drive.wires[0])
    with line.control.failing("observations"), line.control.failing("robots", on="UPDATE"):
        response = line.call("POST", "/stop", {"robots": ["r1"]})
        assert (response.status_code, response.json()["error"]["code"]) == (503, "stop_not_saved")
        assert "holds" in response.json()["error"]["message"]
        reply = line.send(drive.wires[1])
        assert stopped(reply)
        assert (reply["accepted"], reply["duplicates"], reply["next_seq"]) == (0, 0, 4)
        assert line.refused("POST", "/resume", {"robots": ["r1"]}) == (503, "database", None)
        assert line.refused_post(drive.wires[1]) == (503, "database", None)
        assert line.get("/robots/r1")["next_seq"] == 4
    assert line.send(drive.wires[1])["pose"] == drive.expected(1)["pose"]
