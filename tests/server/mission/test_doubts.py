"""A tag that was carried off: shown as moved, told once, and the map of the two robots stays straight."""

import pytest

from robots.se2 import Pose2
from robots.sim.wire import observation_to_wire
from robots.types import Displacement, ImuReading, Observation, TagSighting

PRECISE = {
    "odometry": {
        "distance_sd_per_sqrt_m": 0.02,
        "turn_sd_per_sqrt_m": 0.01,
        "turn_sd_per_sqrt_rad": 0.01,
        "lateral_sd_per_sqrt_m": 0.01,
    }
}
TAGS = {2: "A", 4: "B", 6: "C", 8: "D", 10: "E"}
MOVED = (6.0, 1.5)


def there_and_back(c_lies_at: tuple[float, float], begin_s: float) -> list[dict]:
    """Along the x axis over all tags, a metre at a time, and back over them."""
    out = [Pose2(float(x), 0.0, 0.0) for x in range(12)]
    out[6] = Pose2(*c_lies_at, 0.0)
    way = [*out, *(Pose2(pose.x, pose.y, 3.1) for pose in reversed(out))]
    wires, before = [], way[0]
    for seq, pose in enumerate(way):
        moved, before = before.between(pose), pose
        index = seq if seq < 12 else 23 - seq
        read = (TagSighting(TAGS[index]),) if index in TAGS else ()
        observation = Observation(
            seq=seq,
            stamp_s=begin_s + 2.0 * seq,
            odometry=Displacement(moved.x, moved.y, moved.theta),
            imu=ImuReading(pose.theta),
            tag_sightings=read,
        )
        wires.append(observation_to_wire(observation))
    return wires


@pytest.fixture
def line(control):
    line = control.open()
    start = {"x_m": 0.0, "y_m": 0.0, "yaw_rad": 0.0, "sd_m": 0.05, "sd_rad": 0.01}
    for robot_id in ("r1", "r2"):
        line.register(robot_id, config=PRECISE, start_pose=start)
    return line


def test_a_moved_tag_is_shown_told_once_and_bends_nothing(line):
    with line.stream() as stream:
        line.send(there_and_back((6.0, 0.0), 0.0))
        stream.until(lambda s: len(s.kind("tag")) == 5)
        assert {tag["state"] for tag in stream.kind("tag")} == {"sound"}
        line.send(there_and_back(MOVED, 100.0), "r2")
        stream.until(lambda s: s.state["tag/C"]["state"] == "moved")
        stream.settle()
        robots = stream.kind("robot")
    tags = {tag["tag_id"]: tag for tag in line.get("/tags")["tags"]}
    assert set(tags) == {"A", "B", "C", "D", "E"}
    for number, name in TAGS.items():
        place = MOVED if name == "C" else (float(number), 0.0)
        assert (tags[name]["x_m"], tags[name]["y_m"]) == pytest.approx(place, abs=0.1)
        assert tags[name]["state"] == ("moved" if name == "C" else "sound")
    assert "1.5 m" in tags["C"]["notice"]
    assert tags["A"]["notice"] == ""
    (event,) = line.events("tag_moved")
    assert (event["text"], event["severity"]) == (tags["C"]["notice"], "warning")
    assert len(robots) == 2
    for robot in robots:
        assert (robot["x_m"], robot["y_m"]) == pytest.approx((0.0, 0.0), abs=0.15)
        assert robot["covariance"][0] < 0.1**2


def test_a_restart_does_not_tell_it_again(make_control, tmp_path, wait_until):
    control = make_control(tmp_path)
    line = control.open("m")
    start = {"x_m": 0.0, "y_m": 0.0, "yaw_rad": 0.0, "sd_m": 0.05, "sd_rad": 0.01}
    for robot_id, place, begin_s in (("r1", (6.0, 0.0), 0.0), ("r2", MOVED, 100.0)):
        line.register(robot_id, config=PRECISE, start_pose=start)
        line.send(there_and_back(place, begin_s), robot_id)
    wait_until(lambda: line.events("tag_moved"))
    control.stop()
    again = make_control(tmp_path)
    line.control = again
    tags = {tag["tag_id"]: tag["state"] for tag in line.get("/tags")["tags"]}
    assert tags["C"] == "moved"
    with line.stream() as stream:
        stream.until(lambda s: "map" in s.state or all(r["located"] for r in s.kind("robot")))
        stream.settle()
    assert len(line.events("tag_moved")) == 1
    assert line.events("tag_sound") == []
