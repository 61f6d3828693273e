"""Two robots that send under one name are told apart by what they send, and named."""

import httpx


def plain(seq, turn, **more):
    stamp = 0.05 * seq
    return {
        "seq": seq,
        "stamp_s": stamp,
        "odometry": {"kind": "distance_turn", "distance_m": 0.0, "turn_rad": turn},
        **more,
    }


def shared(line):
    return line.events("name_shared")


def test_sending_again_is_no_offence(line, drive):
    for wires in drive.wires[:6]:
        line.send(wires)
    line.send(drive.wires[2])
    line.send([*drive.wires[5], *drive.wires[6]])
    line.send(drive.wires[6])
    assert shared(line) == []


def test_two_robots_under_one_name_are_named_once(line):
    """Both begin at seq 0 and send in turn: each is ahead of the other by turns."""
    for k in range(6):
        line.send([plain(k, 0.01)])
        reply = line.send([plain(k, -0.02)])
        assert (reply["accepted"], reply["duplicates"]) == (0, 1)  # the first word holds
    (event,) = shared(line)
    assert (event["robot_id"], event["severity"]) == ("r1", "alarm")
    assert "Two robots send as r1: observation 0 came twice" in event["text"]
    assert "they differ in odometry" in event["text"]
    assert "another name" in event["text"]


def test_a_robot_that_comes_late_with_the_name_of_another_is_told_by_its_clock(line):
    line.send([plain(k, 0.0) for k in range(40)])
    line.send([plain(k, 0.0, stamp_s=100.0 + 0.05 * k) for k in range(4)])
    (event,) = shared(line)
    assert "its clock says 0.15 s in one and 100.15 s in the other" in event["text"]


def test_where_the_two_send_from_is_told(line):
    line.send([plain(0, 0.0)])
    there = httpx.HTTPTransport(local_address="127.0.0.2")
    with httpx.Client(transport=there) as other:
        at = f"http://127.0.0.1:{line.control.port}/api/v1{line.at}/robots/r1/observations"
        assert other.post(at, json={"observations": [plain(0, 0.3), plain(1, 0.3)]}).status_code == 200
    (event,) = shared(line)
    assert "One sends from 127.0.0.1, the other from 127.0.0.2." in event["text"]
