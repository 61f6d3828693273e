"""Processes are killed, databases fail for a moment, agents cannot start: answers stay those of the log."""

import os
import signal

import pytest

from db.errors import DatabaseError


def answers(reply):
    return {name: reply[name] for name in ("pose", "command")}


def test_a_killed_agent_comes_back_as_it_was(line, drive, wait_until):
    """Killed between batches, twice in a row, and while it is being brought back."""
    for number, wires in enumerate(drive.wires[:60]):
        if number in (20, 21, 40):
            os.kill(line.agent_pid(), signal.SIGKILL)
        assert answers(line.send(wires)) == drive.expected(number), number
    wait_until(lambda: line.events("agent_restarted"))
    assert "nothing is lost" in line.events("agent_restarted")[0]["text"]
    assert line.get("/robots/r1")["next_seq"] == 240


def test_a_killed_agent_comes_back_without_being_asked(line, drive, wait_until):
    for wires in drive.wires[:5]:
        line.send(wires)
    before = line.agent_pid()
    os.kill(before, signal.SIGKILL)
    wait_until(lambda: line.agent_pid() not in (None, before))
    wait_until(lambda: line.events("agent_restarted"))


def test_an_agent_comes_back_from_its_snapshot_or_the_log(line, drive, wait_until):
    """The same answers from a snapshot, and from the log alone where that is damaged."""
    chosen = f"mission_id = '{line.mission_id}'"
    for number, wires in enumerate(drive.wires[:50]):
        assert answers(line.send(wires)) == drive.expected(number), number
        if number == 20:
            wait_until(lambda: line.control.sql(f"SELECT seq FROM agent_snapshots WHERE {chosen}"))
            os.kill(line.agent_pid(), signal.SIGKILL)
        if number == 40:
            line.control.sql(f"UPDATE agent_snapshots SET body = X'00' WHERE {chosen}")
            os.kill(line.agent_pid(), signal.SIGKILL)


def test_a_killed_team_map_comes_back(line, drive, wait_until):
    with line.stream() as stream:
        for wires in drive.wires[:60]:
            line.send(wires)
        stream.until(lambda s: "map" in s.state and s.kind("tag"))
        stream.settle()
        version, trail = stream.state["map"]["version"], stream.state["trail/r1"]["points_m"]
        tags = stream.kind("tag")
        os.kill(line.team_pid(), signal.SIGKILL)
        wait_until(lambda: line.team_pid() is None)
        for wires in drive.wires[60:80]:
            line.send(wires)
        stream.until(lambda s: s.state["map"]["version"] > version)
        stream.settle()
    assert line.team_pid() is not None
    assert len(stream.kind("tag")) >= len(tags)
    assert len(stream.state["trail/r1"]["points_m"]) >= len(trail)  # all of it is told anew
    assert stream.state["trail/r1"]["points_m"][: len(trail) // 2] == trail[: len(trail) // 2]


def test_an_agent_that_cannot_start_holds_up_nobody_else(tmp_path, make_control, drive, wait_until):
    control = make_control(tmp_path)
    line = control.open("school")
    for robot_id in ("r1", "r2"):
        line.register(robot_id, **line.words)
        for wires in drive.wires[:10]:
            line.send(wires, robot_id)
    control.stop()
    control.sql("UPDATE robots SET config = X'7B7D' WHERE robot_id = 'r1'")
    control.settings = control.settings.model_copy(update={"reply_s": 5.0})
    control.start()
    wait_until(lambda: line.post(drive.wires[10], "r2").status_code == 200)  # who forks is loading
    for number in (10, 9):  # the first came while the agent was being brought back
        assert answers(line.send(drive.wires[number], "r2")) == drive.expected(number)
    assert line.refused_post(drive.wires[10]) == (503, "agent_busy", None)
    assert line.get("/robots/r1")["next_seq"] == 44  # accepted all the same
    line.call("POST", "/stop", {"robots": ["r1"]})
    assert line.send(drive.wires[11])["stop"]
    wait_until(lambda: line.events("agent_down"))
    assert line.events("agent_down")[0]["severity"] == "alarm"
    assert answers(line.send(drive.wires[11], "r2")) == drive.expected(11)


def test_a_failing_database_loses_nothing(line, drive):
    """Findings cannot be saved for a while; the order still comes, and nothing is missing later."""
    tables = ("graph_vertices", "tags", "victims", "events", "tag_memories", "agent_snapshots")
    with line.control.failing(*tables):
        for number, wires in enumerate(drive.wires[:50]):
            assert answers(line.send(wires)) == drive.expected(number), number
        assert line.register("r2").status_code == 201
        assert line.call("POST", "/stop", {"robots": ["r2"]}).status_code == 200
    for number, wires in enumerate(drive.wires[50:], 50):
        assert answers(line.send(wires)) == drive.expected(number), number
    tags = len(drive.agent.report().graph.tag_ids)
    with line.stream() as stream:
        stream.until(lambda s: len(s.kind("tag")) == tags and s.kind("victim"))


def test_a_thought_that_failed_is_thought_again(line, drive, monkeypatch):
    """The log cannot be read when the agent has to be brought back: 503, and the batch again is answered."""
    for wires in drive.wires[:10]:
        line.send(wires)
    host = line.control.missions.get(line.mission_id).roster.get("r1").host

    async def fails():
        raise DatabaseError("the file failed.")

    with monkeypatch.context() as patch:
        patch.setattr(host._log, "snapshot", fails)
        os.kill(line.agent_pid(), signal.SIGKILL)
        assert line.refused_post(drive.wires[10]) == (503, "database", None)
    reply = line.send(drive.wires[10])
    assert (reply["accepted"], reply["duplicates"]) == (0, 4)
    assert answers(reply) == drive.expected(10)
    assert answers(line.send(drive.wires[11])) == drive.expected(11)


@pytest.mark.parametrize("changed", [False, True])
def test_an_agent_on_board_is_compared_with_its_twin(line, drive, changed):
    line.register("r2", agent="onboard", **line.words)
    differences = []
    for number in (0, 1, 2):
        onboard = [_decision(update) for update in drive.updates[number]]
        if changed and number:
            onboard[2]["pose"]["x_m"] += 1e-6
        reply = line.send(drive.wires[number], "r2", onboard=onboard)
        differences += reply["differences"]
    expected = [(6, "pose.x_m"), (10, "pose.x_m")] if changed else []
    assert [(found["seq"], found["what"]) for found in differences] == expected
    assert all(found["onboard"] != found["server"] for found in differences)
    events = line.events("onboard_differs")
    assert len(events) == int(changed)  # of a row of them, the first
    assert not events or "observation 6" in events[0]["text"]


def _decision(update):
    command = update.command
    return {
        "seq": update.seq,
        "pose": {"x_m": update.pose.x, "y_m": update.pose.y, "yaw_rad": update.pose.theta},
        "command": {
            "linear_mps": command.linear_mps,
            "angular_radps": command.angular_radps,
            "drop_tag": command.drop_tag,
            "writes": [],
        },
    }
