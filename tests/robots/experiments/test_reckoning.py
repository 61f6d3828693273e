"""The fast replay of a course against the agent itself, and what it must keep."""

from dataclasses import replace

import numpy as np
import pytest

from robots.agent import RobotAgent
from robots.config import AgentConfig
from robots.experiments.reckoning import firm_floor, read_sensors, reckon
from robots.se2 import Pose2, wrap_array
from robots.types import ImuReading, Observation, TagSighting, WheelEncoders

LEVEL = 2


@pytest.fixture(scope="module")
def config() -> AgentConfig:
    return replace(AgentConfig(), odometry=firm_floor(LEVEL, AgentConfig().body))


def readings_of(course, config, imu, level=LEVEL, run=0):
    wheels, unit = (np.random.default_rng([5, run, stream]) for stream in (1, 2))
    return read_sensors(course, level, config, wheels, unit if imu else None)


@pytest.mark.parametrize("imu", [True, False])
def test_it_is_what_the_agent_without_laser_makes_of_the_same_observations(course, config, imu):
    readings = readings_of(course, config, imu)
    reckoned = reckon(course, readings, config)
    tags = {}
    for tick, tag in zip(course.sighting_ticks.tolist(), course.sighting_tags.tolist(), strict=True):
        tags.setdefault(tick, []).append(TagSighting(str(tag)))
    agent, poses = RobotAgent("r1", config), []
    for tick, wheels in enumerate(readings.wheels):
        update = agent.step(
            Observation(
                seq=tick,
                stamp_s=course.dt_s * (tick + 1),
                odometry=WheelEncoders(*wheels.tolist()),
                imu=ImuReading(float(readings.yaws_rad[tick])) if imu else None,
                tag_sightings=tuple(tags.get(tick, ())),
                bumper=bool(course.pressed[tick]),
            )
        )
        poses.append((Pose2() if update.anchor < 0 else update.anchor_from_base).as_array())
    theirs, ours = agent.report().graph, reckoned.graph(online=True).report()
    assert theirs.tag_ids == ours.tag_ids
    np.testing.assert_array_equal(ours.sighting_pairs, theirs.sighting_pairs)
    np.testing.assert_allclose(ours.edge_poses, theirs.edge_poses, atol=1e-9)
    np.testing.assert_allclose(ours.edge_covariances, theirs.edge_covariances, rtol=1e-6, atol=1e-12)
    np.testing.assert_allclose(ours.sighting_covariances, theirs.sighting_covariances)
    np.testing.assert_allclose(ours.poses, theirs.poses, atol=1e-6)
    np.testing.assert_allclose(ours.tags, theirs.tags, atol=1e-6)
    np.testing.assert_allclose(ours.stamps_s, theirs.stamps_s)
    for tick, step in zip(reckoned.ticks, reckoned.steps, strict=True):
        np.testing.assert_allclose(step.anchor_from_base.as_array(), poses[tick], atol=1e-9)


def test_perfect_wheels_give_the_true_way(course):
    """But for the ticks in which the robot is pressed against something: then the distance is unknown."""
    config = AgentConfig()
    free = replace(course, pressed=np.zeros_like(course.pressed))
    reckoned = reckon(free, readings_of(free, config, False, level=0), config)
    placed = np.array([(reckoned.world_from_map @ Pose2.from_array(p)).as_array() for p in reckoned.poses])
    assert not course.pressed.any()
    np.testing.assert_allclose(placed[:, :2], course.poses[reckoned.ticks, :2], atol=1e-6)
    np.testing.assert_allclose(wrap_array(placed[:, 2] - course.poses[reckoned.ticks, 2]), 0.0, atol=1e-9)


def test_noise_is_of_the_seed_and_the_run(course, config):
    first, same, other = (readings_of(course, config, True, run=run) for run in (0, 0, 1))
    np.testing.assert_array_equal(first.wheels, same.wheels)
    np.testing.assert_array_equal(first.yaws_rad, same.yaws_rad)
    assert np.abs(first.wheels - other.wheels).max() > 1e-4


def test_a_course_has_what_the_experiments_need(course):
    assert course.explored
    assert 57.0 < course.area_m2 < 63.0
    assert len(course.tags_m) > 3
    assert course.repeats > 0
    assert course.sighting_tags.max() < len(course.tags_m)
    read = course.poses[course.sighting_ticks, :2] - course.tags_m[course.sighting_tags]
    assert np.hypot(*read.T).max() < 0.15  # under the antenna, or where it was within the tick
    assert np.isfinite(course.frame_points).any()
    assert course.distance_m > 20.0
