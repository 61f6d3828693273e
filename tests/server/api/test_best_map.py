"""The best map: asked for, made beside the live map, shown, brought down and asked for again."""

import os
import signal
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from io import BytesIO

import numpy as np
import psutil
import pytest
from PIL import Image

from robots.se2 import Pose2
from robots.team import StartPose, TeamMap
from tests.held import best_maps_held


def state(stream):
    return stream.state.get("best_map", {"state": "none"})["state"]


def best(line):
    return line.control.missions.get(line.mission_id).best_map


def ended(line):
    return lambda: line.get("/best-map")["state"] in ("ready", "failed")


@contextmanager
def caught(line, wait_until):
    """The process that makes a best map, held as soon as it is there."""
    with best_maps_held() as held:
        assert line.call("POST", "/best-map").status_code == 202
        pid = held.get(timeout=60.0)
        wait_until(lambda: best(line).pid == pid)
    yield pid
    if psutil.pid_exists(pid):
        os.kill(pid, signal.SIGCONT)


@pytest.fixture
def half(line, drive, wait_until):
    """A mission whose robot has driven a third of the drive."""
    for wires in drive.wires[:40]:
        line.send(wires)
    with line.stream() as stream:
        stream.until(lambda s: "map" in s.state and s.kind("tag"))
        stream.settle()
    return line


def test_the_best_map_is_asked_for_and_shown_beside_the_live_one(driven, drive):
    line = driven
    before = line.get("/best-map")
    assert (before["state"], before["is_current"]) == ("none", False)
    assert (before["map"], before["robots"]) == (None, [])
    assert before["reason"]
    assert line.refused("GET", "/best-map.png") == (404, "no_best_map", None)
    with line.stream() as stream:
        stream.settle()
        live = {key: value for key, value in stream.state.items() if not key.startswith(("robot/", "event/"))}
        asked = line.call("POST", "/best-map")
        assert (asked.status_code, asked.json()["state"]) == (202, "solving")
        stream.until(lambda s: state(s) == "ready", 90.0)
        told = stream.state["best_map"]
        assert {key: stream.state[key] for key in live} == live
    found = line.get("/best-map")
    assert told == {name: found[name] for name in told}
    assert found["is_current"]
    assert (found["robots_done"], found["robots_total"], found["left_out"]) == (1, 1, [])
    last = drive.batches[-1][-1]
    (as_of,) = found["as_of"]
    assert (as_of["robot_id"], as_of["seq"], as_of["stamp_s"]) == ("r1", last.seq, last.stamp_s)
    assert found["explored_m2"] > 20.0

    # the tags, the way and where the robot is are those of the agent's smoothed graph, in the world
    team = TeamMap()
    start = line.words["start_pose"]
    team.add_robot("r1", StartPose(Pose2(start["x_m"], start["y_m"], start["yaw_rad"]), 0.05, 0.01))
    team.put("r1", drive.agent.smoothed())
    expected = team.solve()
    tags = {tag["tag_id"]: (tag["x_m"], tag["y_m"]) for tag in found["tags"]}
    assert tags == {tag.tag_id: pytest.approx((tag.x_m, tag.y_m), abs=1e-3) for tag in expected.tags}
    (robot,) = found["robots"]
    end = drive.agent.report()
    pose = Pose2.from_array(expected.robots[0].anchors[end.anchor]) @ end.anchor_from_base
    assert (robot["x_m"], robot["y_m"]) == pytest.approx((pose.x, pose.y), abs=1e-3)
    assert len(robot["points_m"]) >= 0.9 * len(live["trail/r1"]["points_m"])
    assert {victim["victim_id"] for victim in found["victims"]} == {v.victim_id for v in expected.victims}

    # the picture: where it drove is free
    picture = line.control.call("GET", found["map"]["png"].removeprefix("/api/v1"))
    assert picture.headers["content-type"] == "image/png"
    again = line.call("GET", "/best-map.png", headers={"If-None-Match": picture.headers["etag"]})
    assert again.status_code == 304
    classes = np.asarray(Image.open(BytesIO(picture.content)))
    assert classes.shape == (found["map"]["height"], found["map"]["width"])
    cells = (np.array(robot["points_m"]) - found["map"]["origin_m"]) / found["map"]["resolution_m"]
    columns, rows = cells.astype(int).T
    assert (classes[found["map"]["height"] - 1 - rows, columns] == 1).mean() > 0.95

    # nothing was observed since: the one that is there is the answer
    assert line.call("POST", "/best-map").json()["solved_unix_s"] == found["solved_unix_s"]
    assert best(line).pid is None


def test_without_observations_there_is_nothing_to_solve(line):
    assert line.refused("POST", "/best-map") == (409, "nothing_observed", None)
    assert line.get("/best-map")["state"] == "none"
    with line.stream() as stream:
        assert "best_map" not in stream.state


def test_many_who_ask_have_one_made(half, wait_until):
    with caught(half, wait_until) as pid, ThreadPoolExecutor(8) as pool:
        answers = list(pool.map(lambda _: half.call("POST", "/best-map"), range(8)))
        assert {(a.status_code, a.json()["state"]) for a in answers} == {(202, "solving")}
        assert len({a.json()["asked_unix_s"] for a in answers}) == 1
        assert best(half).pid == pid
        assert psutil.Process(half.agent_pid()).nice() == psutil.Process().nice()
    wait_until(ended(half), 90.0)
    assert half.get("/best-map")["state"] == "ready"
    wait_until(lambda: not psutil.pid_exists(pid))


def test_a_robot_goes_on_while_the_best_map_is_made(half, drive, wait_until):
    with caught(half, wait_until), half.stream() as stream:
        version = stream.state["map"]["version"]
        for number, wires in enumerate(drive.wires[40:60], 40):
            reply = half.send(wires)
            assert {name: reply[name] for name in ("pose", "command")} == drive.expected(number)
        stream.until(lambda s: s.state["map"]["version"] > version)
        assert state(stream) == "solving"
    wait_until(ended(half), 90.0)
    found = half.get("/best-map")
    assert (found["state"], found["as_of"][0]["seq"], found["is_current"]) == ("ready", 159, False)
    assert half.call("POST", "/best-map").json()["state"] == "solving"  # it has grown old
    wait_until(ended(half), 90.0)
    assert half.get("/best-map")["as_of"][0]["seq"] == 239


def test_a_killed_process_is_a_failure_that_says_so_and_can_be_asked_again(half, drive, wait_until):
    half.call("POST", "/best-map")
    wait_until(ended(half), 90.0)
    first = half.get("/best-map")
    half.send(drive.wires[40])
    with half.stream() as stream, caught(half, wait_until) as pid:
        os.kill(pid, signal.SIGKILL)
        stream.until(lambda s: state(s) == "failed")
        assert stream.state["best_map"]["reason"].startswith("The process that made the best map ended")
        assert stream.state["best_map"]["reason"].endswith(".")
        found = half.get("/best-map")
        assert (found["map"], found["tags"]) == (first["map"], first["tags"])  # the earlier one stays
        assert half.call("POST", "/best-map").json()["state"] == "solving"
        stream.until(lambda s: state(s) == "ready", 90.0)
    assert half.get("/best-map")["map"]["version"] > first["map"]["version"]
    assert half.get("/best-map")["reason"] == ""


def test_a_robot_that_is_down_brings_its_last_snapshot(tmp_path, make_control, drive, wait_until):
    """r1 has a snapshot and a log that its agent cannot take; r2 cannot start; r3 has not sent anything."""
    control = make_control(tmp_path, snapshot_every=70, snapshot_every_s=1000.0)
    line = control.open("school")
    for robot_id in ("r1", "r2", "r3"):
        line.register(robot_id, **line.words)
    line.send(drive.wires[0], "r2")
    for wires in drive.wires[:18]:
        line.send(wires, "r1")
    wait_until(lambda: line.control.sql("SELECT seq FROM agent_snapshots"))
    for wires in drive.wires[18:25]:
        line.send(wires, "r1")
    ((seq,),) = line.control.sql("SELECT seq FROM agent_snapshots")
    control.stop()
    control.sql("UPDATE robots SET config = X'7B7D' WHERE robot_id = 'r2'")
    control.sql("UPDATE observations SET body = X'7B7D' WHERE robot_id = 'r1' AND seq < 99")
    control.start()
    wait_until(lambda: line.call("POST", "/best-map").status_code == 202)
    wait_until(ended(line), 90.0)
    found = line.get("/best-map")
    assert found["state"] == "ready", found
    assert [(as_of["robot_id"], as_of["seq"]) for as_of in found["as_of"]] == [("r1", seq)]
    assert [left["robot_id"] for left in found["left_out"]] == ["r2"]
    assert [robot["robot_id"] for robot in found["robots"]] == ["r1"]
    control.sql("UPDATE agent_snapshots SET body = X'00'")
    line.call("POST", "/best-map")
    wait_until(ended(line), 90.0)
    failed = line.get("/best-map")
    assert failed["state"] == "failed"
    assert "r1: not a snapshot of this version" in failed["reason"]
    assert failed["map"] == found["map"]
