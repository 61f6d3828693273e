"""The story: a robot joins, drives, is seen; the server is started anew; everything is there; it goes on."""

from datetime import datetime
from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from robots.se2 import Pose2

HALF = 80  # batches before the restart


@pytest.fixture
def story(tmp_path, make_control, drive, wait_until):
    """A mission on a server of its own, whose robot has driven until HALF."""
    line = make_control(tmp_path, snapshot_every=1).open("school")
    reply = line.register(**line.words)
    assert (reply.status_code, reply.json()["next_seq"]) == (201, 0)
    robot = line.control.missions.get("school").roster.get("r1")
    for number in range(HALF):
        if number == HALF - 1:
            wait_until(robot.snapshot_task.done)  # so that the last batch has one of its own
        reply = line.send(drive.wires[number])
        assert {name: reply[name] for name in ("pose", "command")} == drive.expected(number), number
    last = [(4 * HALF - 1,)]
    wait_until(lambda: line.control.sql("SELECT seq FROM agent_snapshots") == last)
    return line


def shown(stream):
    """What people see of robots and findings, without what hangs at the time."""
    state = {
        key: value
        for key, value in stream.state.items()
        if not key.startswith(("event/", "map", "trail/", "person/"))
    }
    return {
        key: {name: item for name, item in value.items() if name not in ("heard_unix_s", "link", "speed_mps")}
        for key, value in state.items()
    }


def settled(tags):
    return lambda s: "map" in s.state and s.kind("victim") and s.kind("trail") and len(s.kind("tag")) == tags


def test_everything_is_there_after_a_restart_and_the_robot_goes_on(story, drive):
    line, control = story, story.control
    tags = max(
        len(update.graph.tag_ids) for batch in drive.updates[:HALF] for update in batch if update.graph
    )
    with line.stream() as stream:
        stream.until(settled(tags))
        stream.settle()
        before, trail = shown(stream), stream.state["trail/r1"]["points_m"]
    robot = before["robot/r1"]
    assert (robot["stamp_s"], robot["agent"], robot["stopped"]) == (
        drive.batches[HALF - 1][-1].stamp_s,
        "server",
        False,
    )
    assert (robot["x_m"], robot["y_m"]) == pytest.approx(
        _in_world(line.words["start_pose"], drive, drive.expected(HALF - 1)["pose"]), abs=0.3
    )
    victim_id = line.get("/victims")["victims"][0]["victim_id"]
    said = {"status": "confirmed", "note": "waves"}
    assert line.call("PATCH", f"/victims/{victim_id}", said).status_code == 200
    note = {"kind": "hazard", "text": "gas", "x_m": 1.0, "y_m": 2.0}
    line.call("PUT", "/annotations/6f9619ff-8b86-4d01-b42d-00cf4fc964ff", note)
    with line.stream() as stream:
        stream.settle()
        before = shown(stream)
    assert before[f"victim/{victim_id}"].items() >= said.items()
    written = [write for batch in drive.updates[:HALF] for update in batch for write in update.command.writes]
    memory = line.call("GET", f"/tags/{written[0].tag_id}/memory").content
    assert memory
    events = line.get("/events?limit=1000")["events"]
    free = np.asarray(Image.open(BytesIO(line.call("GET", "/map.png").content))) == 1

    control.stop()
    control.start()

    with line.stream() as stream:
        assert stream.kind("victim")
        assert len(stream.kind("tag")) == tags  # from the database, before any agent is back
        while "map" not in stream.state:  # nobody is forgotten while the agents are on their way back
            stream.next()
            assert stream.kind("victim")
        stream.settle()
        after = shown(stream)
        again = stream.state["trail/r1"]["points_m"]
    assert after == before
    assert _length(again) > 0.7 * _length(trail)
    assert line.get("/annotations")["annotations"][0]["text"] == "gas"
    assert line.call("GET", f"/tags/{written[0].tag_id}/memory").content == memory
    kept = line.get("/events?limit=1000")["events"]
    assert [event for event in kept if event["event_id"] <= events[-1]["event_id"]] == events
    assert not [
        event for event in kept if event["event_id"] > events[-1]["event_id"] and event["severity"] == "alarm"
    ]
    picture = np.asarray(Image.open(BytesIO(line.call("GET", "/map.png").content)))
    # the newest submap was shown up to a second late; now the agent has told all of it
    assert 0.98 * free.sum() < (picture == 1).sum() < 1.15 * free.sum()

    assert line.register(**line.words).json()["next_seq"] == 4 * HALF
    for number in (HALF - 2, HALF - 1):  # their replies may have been lost in the restart
        reply = line.send(drive.wires[number])
        assert (reply["accepted"], reply["duplicates"], reply["next_seq"]) == (0, 4, 4 * HALF)
        assert {name: reply[name] for name in ("pose", "command")} == drive.expected(number)
    for number in range(HALF, len(drive.wires)):
        reply = line.send(drive.wires[number])
        assert {name: reply[name] for name in ("pose", "command")} == drive.expected(number), number


def test_stream_and_rest_show_the_same(driven):
    with driven.stream() as stream:
        state = stream.state
    assert driven.get("/robots/r1")["state"] == state["robot/r1"]
    assert {tag["tag_id"]: tag for tag in driven.get("/tags")["tags"]} == {
        tag["tag_id"]: tag for tag in stream.kind("tag")
    }
    assert driven.get("/tags")["links"] == state["links"]["pairs"]
    assert driven.get("/victims")["victims"] == stream.kind("victim")
    assert driven.get("/map") == state["map"]
    assert driven.get()["mission_id"] == state["mission"]["mission_id"]
    assert driven.get("/events?limit=1000")["events"][-50:] == stream.kind("event")


def test_the_graph_is_the_agents(driven, drive):
    (graph,) = driven.get("/graph")["graphs"]
    truth = drive.agent.report().graph
    poses = [(v["x_m"], v["y_m"], v["yaw_rad"]) for v in graph["vertices"] if v["kind"] == "pose"]
    assert poses == [tuple(pose) for pose in truth.poses.tolist()]
    assert tuple(v["tag_id"] for v in graph["vertices"] if v["kind"] == "tag") == truth.tag_ids
    assert len(graph["edges"]) == len(truth.edge_pairs) + len(truth.sighting_pairs)


def test_the_missions_are_listed(driven):
    missions = driven.control.call("GET", "/missions").json()["missions"]
    (mine,) = [mission for mission in missions if mission["mission_id"] == "driven"]
    assert (mine["name"], mine["state"], mine["robots"]) == ("DRIVEN", "running", 1)
    assert datetime.fromtimestamp(mine["created_unix_s"]).year >= 2024
    health = driven.control.call("GET", "/health").json()
    assert health["status"] == "ok"
    assert health["missions"] == len(missions)


def _in_world(words, drive, pose):
    """Where a pose lies in the world when the start was surveyed: the map's x axis points north."""
    start = Pose2(0.0, 0.0, drive.batches[0][0].imu.yaw_rad)
    world = Pose2(words["x_m"], words["y_m"], words["yaw_rad"])
    here = world @ start.between(Pose2(pose["x_m"], pose["y_m"], pose["yaw_rad"]))
    return here.x, here.y


def _length(points):
    return float(np.linalg.norm(np.diff(np.array(points), axis=0), axis=1).sum())
