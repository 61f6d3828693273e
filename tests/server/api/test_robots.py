"""Joining a mission."""

import pytest


def test_the_same_words_join_again_and_others_are_refused(line, drive):
    line.send(drive.wires[0])
    again = line.register(**line.words)
    assert (again.status_code, again.json()["next_seq"]) == (200, 4)
    words = {"robot_id": "r1", **line.words}
    for other in ({"agent": "onboard"}, {"config": {}}, {"start_pose": None}, {"silence": {"after_s": 9.0}}):
        assert line.refused("POST", "/robots", {**words, **other}) == (409, "robot_differs", "robot_id")
    assert line.get("/robots/r1")["agent"] == "server"
    assert len(line.events("robot_joined")) == 1


@pytest.mark.parametrize(
    ("words", "field"),
    [
        ({"config": {"deployment": {"spacing_m": -1.0}}}, "config.deployment.spacing_m"),
        ({"config": {"deployment": {"spacing": 1.0}}}, "config.deployment.spacing"),
        ({"config": {"body": 3}}, "config.body"),
        ({"config": {"poses": "dance"}}, "config.poses"),
        ({"agent": "cloud"}, "agent"),
        ({"robot_id": ""}, "robot_id"),
        ({"robot_id": "../x"}, "robot_id"),
        ({"start_pose": {"x_m": 0.0}}, "start_pose.y_m"),
        ({"silence": {"policy": "panic"}}, "silence.policy"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_a_wrong_word_is_named(line, words, field):
    status, _, found = line.refused("POST", "/robots", {"robot_id": "r2", **words})
    assert (status, found) == (422, field)
    assert [robot["robot_id"] for robot in line.get("/robots")["robots"]] == ["r1"]


def test_missions_are_named_once(control):
    line = control.open()
    body = {"name": "Again", "mission_id": line.mission_id}
    refused = control.call("POST", "/missions", body)
    assert (refused.status_code, refused.json()["error"]["field"]) == (409, "mission_id")
    made = [control.call("POST", "/missions", {"name": "Old Mine!"}).json()["mission_id"] for _ in range(2)]
    assert made == ["old-mine", "old-mine-2"]
