"""Mission logs: what is written comes back as it was; files from elsewhere are refused, no more."""

import gzip
import json
from dataclasses import asdict, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots import codec
from robots.config import AgentConfig, AntennaConfig
from robots.datasets import log_lines
from robots.datasets.log_lines import LineWriter
from robots.datasets.mission_log import load
from robots.datasets.recording import RecordingError
from robots.datasets.replay import replay
from robots.se2 import Pose2
from robots.types import (
    Displacement,
    LaserScan,
    Observation,
    RobotSighting,
    TagSighting,
    WheelEncoders,
)

CONFIG = AgentConfig(seed=5, antenna=AntennaConfig(radius_m=0.1))
SCAN = LaserScan(np.array([1.0, np.inf, 2.0], np.float32), -1.0, 1.0, 4.0)
DRIVE = [
    Observation(
        seq,
        0.1 * seq,
        Displacement(0.1, 0.0, 0.05),
        scan=SCAN if seq == 2 else None,
        tag_sightings=(TagSighting("A", b"x", 1.0, 0.2),) if seq in (1, 4) else (),
        robot_sightings=(RobotSighting("r2", 2.0, 0.1),) if seq == 3 else (),
    )
    for seq in range(6)
]
MISSION = {"waymark_log": 1, "mission_id": "m", "name": "M", "created_unix_s": 1.0, "robots": 1}
ROBOT = {
    "robot_id": "r1",
    "agent": "server",
    "start_pose": {"x_m": 1.0, "y_m": 2.0, "yaw_rad": 0.5, "sd_m": 0.1, "sd_rad": 0.01},
    "config": json.loads(codec.encode(CONFIG)),
    "observations": len(DRIVE),
    "updates_until": None,
    "updates_sha256": None,
    "graph_sha256": None,
}


def write(path, mission=MISSION, robot=ROBOT, observations=DRIVE, end=True):
    writer = LineWriter()
    pieces = [writer.value(mission), writer.value(robot)]
    pieces += [writer.line(o if isinstance(o, bytes) else codec.encode(o)) for o in observations]
    path.write_bytes(b"".join(pieces) + (writer.end() if end else writer._gzip.flush()))
    return path


def test_what_is_written_comes_back_as_it_was(tmp_path):
    log = load(write(tmp_path / "m.log"))
    assert [codec.encode(o) for o in log.observations("r1")] == [codec.encode(o) for o in DRIVE]
    assert log.robots == ("r1",)
    assert log.settings_of("r1") == asdict(CONFIG)
    assert log.start_pose("r1").pose == Pose2(1.0, 2.0, 0.5)
    assert log.stamps_s("r1").tolist() == [o.stamp_s for o in DRIVE]
    assert (log.length("r1"), log.mission_id, log.truth("r1")) == (6, "m", None)
    assert gzip.decompress((tmp_path / "m.log").read_bytes()).endswith(b'\n{"end":8}\n')  # zcat shows it


@pytest.mark.parametrize("seed", range(3))
def test_a_log_is_replayed_as_it_is_even_where_stamps_run_back(tmp_path, seed):
    """Mission control refuses such observations; what is in a log all the same is refused by the agent."""
    observations = [*DRIVE[:5], replace(DRIVE[5], stamp_s=0.0), replace(DRIVE[5], stamp_s=900.0)]
    robot = {**ROBOT, "observations": 7}
    result = replay(load(write(tmp_path / "m.log", robot=robot, observations=observations)))
    assert (result.robots[0].observations, result.robots[0].refused) == (7, 1)
    assert result.robots[0].final.stamps_s.tolist()[-1] == 900.0


def test_an_observation_that_no_agent_survived_is_an_empty_one(tmp_path):
    observations = [*DRIVE[:2], b'{"fault":"it died"}', *DRIVE[2:]]
    found = list(load(write(tmp_path / "m.log", observations=observations)).observations("r1"))
    assert [o.seq for o in found] == list(range(6))
    assert found[2].scan is None
    assert found[2].odometry is None


def robots_named_alike() -> bytes:
    writer = LineWriter()
    pieces = [writer.value({**MISSION, "robots": 2})]
    for _ in range(2):
        pieces += [writer.value({**ROBOT, "observations": 1}), writer.line(codec.encode(DRIVE[0]))]
    return b"".join([*pieces, writer.end()])


def test_a_file_that_is_none_is_named(tmp_path):
    path = tmp_path / "m.log"
    whole = write(path).read_bytes()
    for data, words in {
        b"": "cut short or damaged",
        b"hello": "no mission log that waymark export wrote",
        gzip.compress(b"hello"): "no mission log that waymark export wrote",
        gzip.compress(b"[" * 100_000): "no mission log that waymark export wrote",
        gzip.compress(b'{"waymark_log": 1' + b"0" * 5000 + b"}\n"): "no mission log",
        gzip.compress(b'{"waymark_log": 2}\n'): "mission log of version 2; this program reads version 1",
        whole[:-4]: "cut short or damaged",
        whole + b"more": "cut short or damaged",
        whole[:-5] + bytes([whole[-5] ^ 8]) + whole[-4:]: "cut short or damaged",
        robots_named_alike(): "two robots with the name r1",
    }.items():
        path.write_bytes(data)
        with pytest.raises(RecordingError, match=words):
            load(path)
    with pytest.raises(RecordingError, match="there is no mission log"):
        load(tmp_path / "absent")
    with pytest.raises(RecordingError, match="cannot read the mission log"):
        load(tmp_path)
    with pytest.raises(RecordingError, match="a mission log has real tags"):
        load(write(path), 2.0)


@given(st.integers(0, 10_000))
def test_every_truncation_is_refused(tmp_path_factory, at):
    path = tmp_path_factory.mktemp("log") / "m.log"
    whole = write(path).read_bytes()
    path.write_bytes(whole[: at % len(whole)])
    with pytest.raises(RecordingError, match=r"cut short|no mission log"):
        load(path)


@given(st.integers(0, 10_000), st.integers(0, 255))
def test_a_changed_byte_is_refused(tmp_path_factory, at, byte):
    path = tmp_path_factory.mktemp("log") / "m.log"
    data = bytearray(write(path).read_bytes())
    place = 10 + at % (len(data) - 10)  # after the header, which holds nothing but how it was made
    if data[place] != byte:
        data[place] = byte
        path.write_bytes(bytes(data))
        with pytest.raises(RecordingError):
            load(path)


def test_a_line_without_end_is_given_up(tmp_path, monkeypatch):
    monkeypatch.setattr(log_lines, "_LONGEST_LINE", 10_000)
    path = write(tmp_path / "m.log", observations=[*DRIVE[:5], b"[" * 20_000])
    with pytest.raises(RecordingError, match="line 8: longer than any that Waymark writes"):
        load(path)


WRONG = {
    "robots": ({"robots": 10**12}, {}, "holds less than it announces"),
    "no number": ({"robots": "many"}, {}, "the number of robots is many"),
    "minus": ({"robots": -1}, {}, "the number of robots is -1"),
    "truth": ({"robots": True}, {}, "the number of robots is True"),
    "nobody": ({"robots": 0}, {}, "holds more than it announces"),
    "more": ({}, {"observations": 7}, "holds less than it announces"),
    "less": ({}, {"observations": 5}, "holds more than it announces"),
    "endless": ({}, {"observations": 10**15}, "announces more than 20000000 observations"),
    "a path": ({}, {"robot_id": "../../x"}, "'../../x' is no name of a robot"),
    "a number": ({}, {"robot_id": 1}, "'1' is no name of a robot"),
    "no config": ({}, {"config": None}, "the configuration of r1 is none"),
    "another": ({}, {"config": json.loads(codec.encode(Pose2()))}, "the configuration of r1 is none"),
    "radius": (
        {},
        {"config": json.loads(codec.encode(replace(CONFIG, seed=-1)))},
        "the configuration of r1 is none: config.seed has to be 0 or more",
    ),
    "start": ({}, {"start_pose": {"x_m": 1.0}}, "the start pose of r1 is none"),
    "infinite start": (
        {},
        {"start_pose": {**ROBOT["start_pose"], "sd_m": float("nan")}},
        "the start pose of r1 is none",
    ),
}


@pytest.mark.parametrize(("mission", "robot", "message"), WRONG.values(), ids=WRONG)
def test_what_is_wrong_in_a_head_is_named(tmp_path, mission, robot, message):
    path = write(tmp_path / "m.log", {**MISSION, **mission}, {**ROBOT, **robot})
    with pytest.raises(RecordingError, match=message):
        load(path)


ODD = {
    "other class": codec.encode(Pose2()),
    "no class": b"{}",
    "list": b"[]",
    "deep": b"[" * 100_000,
    "stamp": codec.encode(replace(DRIVE[0], stamp_s="soon")),
    "truth": codec.encode(replace(DRIVE[0], stamp_s=True)),
    "not a number": codec.encode(replace(DRIVE[0], stamp_s=float("nan"))),
    "wheels": codec.encode(replace(DRIVE[0], odometry=WheelEncoders(0.0, 0.0, None, 0.0))),
    "odometry": codec.encode(replace(DRIVE[0], odometry=Pose2())),
    "huge": codec.encode(replace(DRIVE[0], odometry=Displacement(1e300, 0.0, 0.0))),
    "scan": codec.encode(replace(DRIVE[0], scan=replace(SCAN, ranges_m=np.zeros((2, 2), np.float32)))),
    "doubles": codec.encode(replace(DRIVE[0], scan=replace(SCAN, ranges_m=np.zeros(3)))),
    "tags": codec.encode(replace(DRIVE[0], tag_sightings=(Pose2(),))),
    "memory": codec.encode(replace(DRIVE[0], tag_sightings=(TagSighting("A", "text"),))),
    "tuple": codec.encode(replace(DRIVE[0], tag_sightings="A")),
    "shape": b'{"_":"Observation","seq":0,"stamp_s":{"a":"f8","s":[1%s],"b":""}}' % (b"0" * 30),
}


@pytest.mark.parametrize("line", ODD.values(), ids=ODD)
def test_a_line_that_is_no_observation_is_refused(tmp_path, line):
    path = write(tmp_path / "m.log", observations=[line, *DRIVE[1:]])
    with pytest.raises(RecordingError, match=r"is damaged: a line is no observation|in an observation"):
        load(path)


def test_a_mission_in_which_nobody_observed_anything_is_named(tmp_path):
    with pytest.raises(RecordingError, match="holds no observation"):
        load(write(tmp_path / "m.log", robot={**ROBOT, "observations": 0}, observations=[]))
