"""Real logs and updates through the codec, and what it refuses."""

from dataclasses import fields, replace

import numpy as np
import pytest

from robots.agent import RobotAgent
from robots.codec import _CLASSES, CodecError, decode, encode
from robots.config import AgentConfig, AntennaConfig
from robots.graph_report import GraphReport
from robots.se2 import GaussianPose, Pose2
from robots.team import TeamMap
from robots.team.types import TeamUpdate
from robots.types import AgentUpdate, Displacement, Observation, WheelEncoders


@pytest.fixture(scope="module")
def updates(robot_log) -> list[AgentUpdate]:
    agent = RobotAgent("r1", robot_log.config)
    return [*(agent.step(observation) for observation in robot_log.observations), agent.report()]


def test_a_log_is_the_same_log_after_storing(robot_log):
    agent = RobotAgent("r1", robot_log.config)
    from_store = RobotAgent("r1", decode(encode(robot_log.config), AgentConfig))
    for observation in robot_log.observations[:400]:
        stored = decode(encode(observation), Observation)
        assert encode(stored) == encode(observation)
        assert encode(from_store.step(stored)) == encode(agent.step(observation))


def test_updates_come_back_whole(updates):
    for update in updates:
        back = decode(encode(update), AgentUpdate)
        assert encode(back) == encode(update)
    assert back.pose == update.pose
    assert back.command == update.command
    assert back.goal_m == update.goal_m
    np.testing.assert_array_equal(back.path_m, update.path_m)
    assert back.path_m.dtype == np.float32
    assert isinstance(back.graph, GraphReport)
    assert back.graph.tag_ids == update.graph.tag_ids
    np.testing.assert_array_equal(back.graph.edge_covariances, update.graph.edge_covariances)
    assert [s.cells for s in back.submaps] == [s.cells for s in update.submaps]
    assert back.victims[0].victim_id == update.victims[0].victim_id


def test_a_team_map_comes_back_whole(updates):
    team = TeamMap()
    team.add_robot("r1", None)
    team.put("r1", updates[-1])
    solved = team.solve()
    back = decode(encode(solved), TeamUpdate)
    assert encode(back) == encode(solved)
    assert back.tags[0].robots == ("r1",)
    np.testing.assert_array_equal(back.grid.cells, solved.grid.cells)


def test_a_missing_value_stays_missing_and_a_union_keeps_its_kind():
    for odometry in (None, Displacement(0.1, 0.0, -0.2), WheelEncoders(0.1, 0.2, 0.3, 0.4)):
        back = decode(encode(Observation(3, 0.5, odometry=odometry)), Observation)
        assert back.odometry == odometry
        assert back.scan is None
        assert back.tags_left is None


def test_arrays_are_stored_little_endian_and_contiguous():
    wide = np.arange(12, dtype=np.float64).reshape(3, 4)
    big_endian = wide.astype(">f8")
    assert encode(GaussianPose(Pose2(), wide.T)) == encode(GaussianPose(Pose2(), wide.T.copy()))
    assert encode(GaussianPose(Pose2(), big_endian)) == encode(GaussianPose(Pose2(), wide))


@pytest.mark.parametrize("value", [np.float32(1.5), np.int64(3), object(), {"x": 1.0}, 1 + 2j])
def test_what_cannot_be_stored_exactly_is_refused(value):
    with pytest.raises(TypeError, match=f"cannot store a {type(value).__name__}"):
        encode(Pose2(value, 0.0, 0.0))


@pytest.mark.parametrize("dtype", [bool, np.uint16, np.complex128, object])
def test_arrays_of_other_types_are_refused(dtype):
    with pytest.raises(TypeError, match="cannot store an array of"):
        encode(np.zeros(2, dtype))


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"null",
        b"\xff\xfe\x00",
        b"[" * 100_000,
        b'{"_":"Pose2","x":1.0} and more',
        b'{"_":"Pose2","sideways":1.0}',
        b'{"_":"Pose2","x":{}}',
        b'{"_":"Pose2","x":{"b":"no base64!"}}',
        b'{"_":"Pose2","x":{"a":"f8","s":[2],"b":"AAAAAAAAAAA="}}',
        b'{"_":"Pose2","x":{"a":"O8","s":[1],"b":"AAAAAAAAAAA="}}',
        b'{"_":"VictimEstimate"}',
        b'{"_":"Popen","args":"true"}',
        b'{"_":"CodecError"}',
        b'{"_":["Pose2"]}',
    ],
)
def test_damaged_bytes_are_refused(data):
    with pytest.raises(CodecError):
        decode(data, Pose2)


def test_another_class_than_expected_is_refused():
    with pytest.raises(CodecError, match="expected a stored Observation, found a Pose2"):
        decode(encode(Pose2()), Observation)


def test_a_config_survives_with_its_nested_changes():
    config = replace(AgentConfig(seed=7), antenna=AntennaConfig(radius_m=0.1))
    assert decode(encode(config), AgentConfig) == config


def test_no_field_has_a_name_the_codec_uses_itself():
    assert "AgentUpdate" in _CLASSES
    assert "TeamGrid" in _CLASSES
    for cls in _CLASSES.values():
        assert not {item.name for item in fields(cls)} & {"_", "a", "b", "s"}
