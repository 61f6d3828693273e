"""Victims that a tag tells of: shown where they lie and as told, and one with what a robot finds there."""

import base64
from dataclasses import replace
from math import atan2, hypot

import pytest

from robots.tags.marks import victim_mark
from robots.tags.memory import TagMemory
from robots.tags.sealed import close_memory
from tests.server.control import START

FROM_TAG = (3.0, -1.5)  # metres north and west of the tag


def telling(name: str = "r9-V1") -> str:
    """A memory that a robot wrote which is not here: it saw a victim near the tag."""
    memory = replace(TagMemory.empty(), victims=(victim_mark(name, 0.8, 125.0, *FROM_TAG),))
    return base64.b64encode(close_memory(memory, 3, "A4", b"", 200)).decode()


def read(seq: int, memory: str = "", **more):
    sighting = {"tag_id": "A4", "memory": memory}
    return {"seq": seq, "stamp_s": 0.5 * seq, "tag_sightings": [sighting] if memory else [], **more}


def test_what_a_tag_tells_of_a_victim_is_shown_as_told_until_a_robot_finds_it(line):
    with line.stream() as stream:
        for seq in range(3):
            line.send([read(seq, telling())])
        stream.until(lambda s: s.kind("tag") and s.kind("victim"))
        (told,) = stream.kind("victim")
        tag = stream.state["tag/A4"]
        place = told["x_m"] - tag["x_m"], told["y_m"] - tag["y_m"]
        assert place == pytest.approx(FROM_TAG, abs=0.06)
        assert (told["by"], told["status"], told["robots"]) == ("tag A4", "suspected", [])
        assert "Told by tag A4" in told["note"]
        assert "80% sure" in told["note"]
        assert told["confidence"] == pytest.approx(0.8, abs=0.01)
        assert told["covariance"][0] > tag["covariance"][0]  # doubted more than the tag
        assert line.get(f"/victims/{told['victim_id']}") == told
        stream.until(lambda s: "victim_seen" in {event["kind"] for event in s.kind("event")})
        assert "A4" in line.events("victim_seen")[0]["text"]
        bearing_range = _seen_from(START, told)  # it has not moved
        for seq in range(3, 12):
            line.send([read(seq, heat=[bearing_range])])
        found = stream.until(lambda s: any(v["robots"] for v in s.kind("victim")))
        (own,) = [v for key, v in found.items() if key.startswith("victim/") and v["robots"]]
        key = f"victim/{told['victim_id']}"
        stream.until(lambda s: s.state[key]["merged_into"] == own["victim_id"])
    line.send([read(12, telling())])  # told again, nobody is found anew
    standing = [v for v in line.get("/victims")["victims"] if v["merged_into"] is None]
    assert [v["victim_id"] for v in standing] == [own["victim_id"]]


def test_a_stranger_tells_of_nobody_and_a_tag_without_a_place_waits(line):
    memory = replace(TagMemory.empty(), victims=(victim_mark("x", 0.9, 1.0, 1.0, 1.0),))
    forged = base64.b64encode(close_memory(memory, 3, "A4", b"stranger", 200)).decode()
    line.send([read(0, forged)])
    told = close_memory(memory, 1, "B7", b"", 200)
    line.call("POST", "/tags/B7/memory", content=told, headers={"Content-Type": "application/octet-stream"})
    assert line.get("/victims")["victims"] == []
    line.send([{"seq": 1, "stamp_s": 1.0, "tag_sightings": [{"tag_id": "B7"}]}])  # now it has a place
    with line.stream() as stream:
        stream.until(lambda s: s.kind("victim"))
        assert stream.kind("victim")[0]["by"] == "tag B7"


def _seen_from(robot, victim):
    """The heat reading of a victim by a robot."""
    dx, dy = victim["x_m"] - robot["x_m"], victim["y_m"] - robot["y_m"]
    return {"bearing_rad": atan2(dy, dx) - robot["yaw_rad"], "range_m": hypot(dx, dy), "confidence": 0.9}
