"""A mission from draft to archive and back, through the API and over restarts of the server."""

import pytest

STEPS = ("start", "pause", "close", "archive", "reopen")
FOLLOWS = {
    "draft": {"start": "running", "close": "closed"},
    "running": {"pause": "paused", "close": "closed", "start": "running"},
    "paused": {"start": "running", "close": "closed", "pause": "paused"},
    "closed": {"archive": "archived", "reopen": "paused", "close": "closed"},
    "archived": {"reopen": "paused", "archive": "archived"},
}
WAY = {
    "draft": (),
    "running": ("start",),
    "paused": ("start", "pause"),
    "closed": ("close",),
    "archived": ("close", "archive"),
}


def step(line, name):
    response = line.call("POST", f"/{name}")
    assert response.status_code == 200, response.text
    return response.json()


def draft(control, name):
    response = control.call("POST", "/missions", {"name": name, "state": "draft"})
    assert response.status_code == 201, response.text
    return control.line(response.json()["mission_id"])


@pytest.mark.parametrize("state", FOLLOWS)
def test_only_what_follows_is_done(control, state):
    for name in STEPS:
        line = draft(control, f"{state} {name}")
        for before in WAY[state]:
            step(line, before)
        if name in FOLLOWS[state]:
            assert step(line, name)["state"] == FOLLOWS[state][name]
        else:
            assert line.refused("POST", f"/{name}")[:2] == (409, "wrong_state")
            assert line.get()["state"] == state


def test_a_draft_takes_robots_but_no_observations(control, drive):
    line = draft(control, "Not yet")
    line.register(**line.words)
    assert line.refused_post(drive.wires[0])[:2] == (409, "mission_draft")
    assert line.get()["started_unix_s"] is None
    started = step(line, "start")
    assert (started["state"], started["state_by"]) == ("running", "operator")
    assert line.send(drive.wires[0])["accepted"] == len(drive.wires[0])


def test_the_robots_of_a_paused_mission_stand_still_and_are_logged(line, drive):
    line.send(drive.wires[0])
    step(line, "pause")
    line.register("r2")
    reply = line.send(drive.wires[1])
    assert reply["stop"]
    assert (reply["command"]["linear_mps"], reply["accepted"]) == (0.0, len(drive.wires[1]))
    assert line.send(drive.wires[0], "r2")["stop"]
    assert not line.get("/robots/r1")["stopped"]  # nobody has said STOP
    step(line, "start")
    assert not line.send(drive.wires[2])["stop"]
    line.call("POST", "/stop", {"robots": ["r1"]})
    step(line, "pause")
    step(line, "start")
    assert line.send(drive.wires[3])["stop"]  # STOP is no matter of pausing


def test_a_mission_does_not_end_while_robots_drive(line, drive):
    line.send(drive.wires[0])
    assert line.refused("POST", "/close")[:2] == (409, "robots_drive")
    step(line, "pause")
    assert step(line, "close")["state"] == "closed"


def what_is_there(line):
    found = {
        name: line.get(f"/{name}") for name in ("tags", "victims", "map", "robots", "annotations", "graph")
    }
    found["map"].pop("version")
    found["map"].pop("png")
    for robot in found["robots"]["robots"]:
        robot.pop("link")
        robot["state"].pop("link")
    return found, line.call("GET", "/map.png").content


def test_a_closed_mission_is_read_only_and_goes_on_when_it_is_reopened(
    make_control, tmp_path, drive, wait_until
):
    control = make_control(tmp_path)
    line = control.open("school")
    line.register(**line.words)
    for wires in drive.wires[:30]:
        line.send(wires)
    at = "/annotations/00000000-0000-4000-8000-000000000001"
    note = {"kind": "note", "text": "x", "x_m": 1.0, "y_m": 2.0}
    assert line.call("PUT", at, note).status_code == 200
    with line.stream() as stream:
        step(line, "pause")
        ran_s = step(line, "close")["duration_s"]
        stream.until(lambda s: s.state["mission"]["state"] == "closed")
    before = what_is_there(line)
    assert before[0]["tags"]["tags"]
    assert line.agent_pid() is None
    assert line.team_pid() is None
    for refused in (
        line.refused_post(drive.wires[30]),
        line.refused("PUT", at, note | {"text": "y"}),
        line.refused("DELETE", at),
        line.refused("POST", "/robots", {"robot_id": "r9"}),
        line.refused("POST", "/robots/r1/orders", {"kind": "return"}),
    ):
        assert refused[:2] == (409, "mission_closed")
    assert line.call("POST", "/stop", {"robots": None}).status_code == 200  # safety first, always
    assert line.call("POST", "/resume", {"robots": None}).status_code == 200

    control.stop()
    control.start()
    line = control.line("school")
    assert what_is_there(line) == before
    assert line.agent_pid() is None
    assert line.get()["duration_s"] == ran_s
    assert step(line, "archive")["state"] == "archived"
    assert line.refused_post(drive.wires[30])[:2] == (409, "mission_archived")

    with line.stream() as stream:
        assert step(line, "reopen")["state"] == "paused"
        stream.until(lambda s: s.state["mission"]["state"] == "paused")
        reply = line.send(drive.wires[30])
        assert reply["stop"]
        step(line, "start")
        reply = line.send(drive.wires[31])
        assert {name: reply[name] for name in ("pose", "command")} == drive.expected(31)
        stream.until(lambda s: s.state["robot/r1"]["stamp_s"] == drive.wires[31][-1]["stamp_s"])
    assert [entry["action"] for entry in line.get("/audit?limit=5")["entries"]][:3] == [
        "start_mission", "reopen_mission", "archive_mission",
    ]  # fmt: skip


def test_an_ending_that_was_not_kept_is_made_at_the_next_start(make_control, tmp_path, drive, wait_until):
    control = make_control(tmp_path)
    line = control.open("school")
    line.register(**line.words)
    for wires in drive.wires[:20]:
        line.send(wires)
    step(line, "pause")
    step(line, "close")
    tags = line.get("/tags")["tags"]
    control.stop()
    control.sql("DELETE FROM endings")
    control.start()
    wait_until(lambda: control.sql("SELECT 1 FROM endings"), 30.0)
    line = control.line("school")
    assert [tag["tag_id"] for tag in line.get("/tags")["tags"]] == [tag["tag_id"] for tag in tags]
    wait_until(lambda: line.agent_pid() is None)


def test_missions_tell_in_figures_what_they_came_to(driven, wait_until):
    wait_until(lambda: driven.get()["explored_m2"] == driven.get("/map")["explored_m2"])
    mission = driven.get()
    assert mission["tags"] == len(driven.get("/tags")["tags"])
    assert mission["victims"] >= 1
    summary = driven.get("/summary")
    assert [robot["robot_id"] for robot in summary["robots"]] == ["r1"]
    assert sum(summary["victims"].values()) - summary["victims"].get("dismissed", 0) == mission["victims"]
    assert summary["alerts"]["victim_seen"] >= 1
    wait_until(
        lambda: (
            [s["explored_m2"] for s in driven.get("/summary")["progress"][-1:]]
            == [driven.get()["explored_m2"]]
        )
    )  # looked at every five seconds
    samples = driven.get("/summary")["progress"]
    assert [sample["unix_s"] for sample in samples] == sorted(sample["unix_s"] for sample in samples)
