"""What a robot may send: again, with gaps, backwards, malformed, too much. Nothing accepted is lost by it."""

import json
import socket

import pytest

NAN = float("nan")


def plain(seq, **more):
    return {"seq": seq, "stamp_s": 0.05 * seq, **more}


def scan(ranges, **more):
    return {"ranges_m": ranges, "angle_min_rad": -1.0, "angle_increment_rad": 0.1, "range_max_m": 4.0, **more}


def wheels(value):
    names = ("front_left_m", "front_right_m", "rear_left_m", "rear_right_m")
    return {"kind": "wheels", **dict.fromkeys(names, 0.0), "front_right_m": value}


def test_a_batch_sent_again_gets_the_same_order(line, drive):
    replies = [line.send(wires) for wires in drive.wires[:6]]
    again = line.send(drive.wires[4])
    assert (again["accepted"], again["duplicates"], again["next_seq"]) == (0, 4, 24)
    assert (again["pose"], again["command"]) == (replies[4]["pose"], replies[4]["command"])
    assert again["pose"] != replies[5]["pose"]
    both = line.send([*drive.wires[5], *drive.wires[6]])
    assert (both["accepted"], both["duplicates"], both["next_seq"]) == (4, 4, 28)
    assert both["pose"] == drive.expected(6)["pose"]
    other = line.send([{**wire, "stamp_s": 0.0} for wire in drive.wires[6]])  # the first word holds
    assert other["pose"] == both["pose"]
    assert line.send(drive.wires[7])["pose"] == drive.expected(7)["pose"]


def test_a_gap_is_refused_and_names_what_is_expected(line, drive):
    line.send(drive.wires[0])
    assert line.refused_post(drive.wires[2]) == (409, "gap", "observations.0.seq")
    error = line.post(drive.wires[2]).json()["error"]
    assert "next_seq 4" in error["message"]
    first, second, third, fourth = drive.wires[1]
    assert line.refused_post([first, third, second, fourth]) == (409, "gap", "observations.1.seq")
    assert line.get("/robots/r1")["next_seq"] == 4
    assert line.send(drive.wires[1])["pose"] == drive.expected(1)["pose"]


def test_a_clock_that_runs_backwards_is_refused(line, drive):
    line.send(drive.wires[0])
    wires = [*drive.wires[1][:3], {**drive.wires[1][3], "stamp_s": 0.3}]
    assert line.refused_post(wires) == (422, "stamp_backwards", "observations.3.stamp_s")
    assert line.refused_post([plain(4, stamp_s=0.1)])[1] == "stamp_backwards"
    assert line.get("/robots/r1")["next_seq"] == 4
    assert line.send(drive.wires[1])["pose"] == drive.expected(1)["pose"]


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"imu": {"yaw_rad": NAN}}, "imu.yaw_rad"),
        ({"odometry": wheels(float("inf"))}, "odometry.front_right_m"),
        ({"odometry": wheels(1e6)}, "odometry.front_right_m"),
        ({"odometry": {"kind": "wheels"}}, "odometry.front_left_m"),
        ({"odometry": {"kind": "legs"}}, "odometry"),
        ({"scan": scan([1.0, NAN])}, "scan.ranges_m.1"),
        ({"scan": scan([1.0, -0.1])}, "scan.ranges_m.1"),
        ({"scan": scan([1.0] * 4097)}, "scan.ranges_m"),
        ({"scan": scan([1.0], range_max_m=0.0)}, "scan.range_max_m"),
        ({"stamp_s": "1.0"}, "stamp_s"),
        ({"stamp_s": NAN}, "stamp_s"),
        ({"seq": -1}, "seq"),
        ({"seq": 1.5}, "seq"),
        ({"seq": True}, "seq"),
        ({"seq": 2**53}, "seq"),
        ({"battery": 1.1}, "battery"),
        ({"colour": "red"}, "colour"),
        ({"heat": [{"bearing_rad": 0.0, "range_m": 1.0, "confidence": 2.0}]}, "heat.0.confidence"),
        ({"tag_sightings": [{"tag_id": "a b"}]}, "tag_sightings.0.tag_id"),
        ({"tag_sightings": [{"tag_id": "A", "memory": "%"}]}, "tag_sightings.0.memory"),
        ({"tag_sightings": [{"tag_id": "A"}] * 257}, "tag_sightings"),
        ({"tag_sightings": [{"tag_id": "A", "bearing_rad": 1.0}]}, "tag_sightings.0"),
        (
            {"tag_sightings": [{"tag_id": "A", "range_m": 1001.0, "bearing_rad": 0.0}]},
            "tag_sightings.0.range_m",
        ),
        (
            {"tag_sightings": [{"tag_id": "A", "range_m": 1.0, "bearing_rad": NAN}]},
            "tag_sightings.0.bearing_rad",
        ),
        (
            {"robot_sightings": [{"robot_id": "r2", "range_m": -1.0, "bearing_rad": 0}]},
            "robot_sightings.0.range_m",
        ),
        ({"robot_sightings": [{"robot_id": "r2"}]}, "robot_sightings.0.range_m"),
        ({"robot_sightings": [{"robot_id": "r2", "range_m": 1, "bearing_rad": 0}] * 257}, "robot_sightings"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_what_is_wrong_is_named(line, change, field):
    body = json.dumps({"observations": [plain(0), {**plain(1), **change}]})
    response = line.call("POST", "/robots/r1/observations", content=body, headers=JSON)
    error = response.json()["error"]
    assert (response.status_code, error["field"]) == (422, f"observations.1.{field}")
    assert error["field"] in error["message"]
    assert line.get("/robots/r1")["next_seq"] == 0


JSON = {"Content-Type": "application/json"}


@pytest.mark.parametrize(
    "body",
    [
        "",
        "{",
        "[]",
        "null",
        '{"observations": []}',
        '{"observations": 1}',
        '{"observations": [{"seq": 1' + "0" * 5000 + "}]}",
        '{"observations": ' + "[" * 100_000,
        '{"observations": [{"seq": 0, "stamp_s": 1e400}]}',
        b"\xff\xfe",
    ],
    ids=range(10),
)
def test_what_is_no_batch_is_refused(line, body):
    response = line.call("POST", "/robots/r1/observations", content=body, headers=JSON)
    assert response.status_code == 422
    assert response.json()["error"]["message"].endswith(".")
    assert "Traceback" not in response.text


def test_a_batch_of_more_than_two_thousand_is_refused(line):
    assert line.refused_post([plain(seq) for seq in range(2001)]) == (422, "invalid", "observations")


def test_a_body_over_the_limit_is_refused_announced_or_not(line):
    body = b" " * (4 * 2**20 + 1)
    path = "/robots/r1/observations"
    assert line.refused("POST", path, content=body, headers=JSON) == (413, "too_large", None)
    assert line.refused("POST", path, content=iter([body]), headers=JSON) == (413, "too_large", None)
    assert line.refused("POST", "/tags/A/memory", content=iter([body]))[:2] == (413, "too_large")
    assert line.send([plain(0)])["accepted"] == 1


def test_a_length_that_is_no_number_is_refused(line):
    with socket.create_connection(("127.0.0.1", line.control.port), timeout=5) as raw:
        raw.sendall(b"POST /api/v1/missions HTTP/1.1\r\nHost: x\r\nContent-Length: many\r\n\r\n")
        assert b" 400 " in raw.recv(1000)


def test_unknown_robots_and_missions_are_named(line):
    assert line.refused("POST", "/robots/r9/observations", {"observations": [plain(0)]}) == (
        404,
        "unknown_robot",
        None,
    )
    assert line.refused("GET", "/robots/r9") == (404, "unknown_robot", None)
    assert line.refused("GET", "x") == (404, "unknown_mission", None)
    nobody = line.control.call("POST", "/missions/nobody/robots", {"robot_id": "r1"})
    assert nobody.json()["error"]["code"] == "unknown_mission"
    assert "nobody" in nobody.json()["error"]["message"]


@pytest.mark.parametrize(
    "odd",
    [
        {"scan": scan([])},
        {"scan": scan([None] * 240)},
        {"scan": scan([0.0] * 240)},
        {"scan": scan([1.0] * 240, angle_increment_rad=0.0)},
        {"scan": scan([1.0] * 4096, range_max_m=1e4)},
        {"scan": scan([9999.0] * 240, range_max_m=1e4)},
        {"odometry": {"kind": "displacement", "dx_m": 1000.0, "dy_m": -1000.0, "dtheta_rad": 1000.0}},
        {"odometry": wheels(1000.0)},
        {"imu": {"yaw_rad": 1e4, "roll_rad": -1e4, "pitch_rad": 1e4}},
        {"stamp_s": 1e12},
        {"tag_sightings": [{"tag_id": f"T{k}", "memory": "AAAA"} for k in range(256)]},
        {"heat": [{"bearing_rad": 1e4, "range_m": 1e4, "confidence": 0.0}] * 256},
        {"beams": [{"kind": "sonar", "bearing_rad": 0, "range_m": 0, "range_max_m": 1, "cone_rad": 0}] * 256},
        {"tags_left": 0, "battery": 0.0, "bumper": True, "held": True},
        {"tag_sightings": [{"tag_id": f"T{k}", "range_m": 1e3, "bearing_rad": -1e4} for k in range(256)]},
        {"robot_sightings": [{"robot_id": "r1", "range_m": 0.0, "bearing_rad": 1e4}] * 256},
    ],
    ids=range(16),
)
def test_what_is_odd_but_allowed_does_not_stop_the_robot(line, drive, odd):
    """Whatever the agent makes of it, the next observations are answered."""
    line.send(drive.wires[0])
    reply = line.send([{**plain(4), **odd}])
    assert reply["accepted"] == 1
    later = max(1.0, odd.get("stamp_s", 0.0))
    reply = line.send([{**wire, "stamp_s": later} for wire in drive.wires[1][1:]])
    assert reply["accepted"] == 3
    assert reply["pose"] is not None
