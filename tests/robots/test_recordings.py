"""A real robot's day in a real building, where its recording is at hand."""

from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest

from robots.datasets.intel import load
from robots.datasets.replay import ReplayResult, replay
from robots.evaluation import absolute_error, read_relations, relations_error
from robots.se2 import Pose2
from robots.trajectory import Trajectory

DATA = Path(__file__).parents[3] / "shared" / "data"
INTEL, RELATIONS = DATA / "intel_raw_2726.npz", DATA / "intel.relations"

pytestmark = [
    pytest.mark.data,
    pytest.mark.skipif(
        not (INTEL.exists() and RELATIONS.exists()), reason="the Intel recording is not part of the project"
    ),
]


@lru_cache(maxsize=1)
def intel() -> ReplayResult:
    recording = load(INTEL, 2.0)
    # the robot drove itself: planning where it should have gone is left out
    return replay(replace(recording, settings={**recording.settings, "planning": {"replan_every_s": 1e9}}))


def test_intel_with_a_tag_every_two_metres_is_true_to_the_relations():
    (robot,) = intel().robots
    relations = read_relations(RELATIONS)
    final, online = relations_error(robot.final, relations), relations_error(robot.online, relations)
    assert final.relations > 0.9 * len(relations)
    assert final.mean_m <= 0.15
    assert final.mean_m < online.mean_m  # what the last solve is for


def test_the_recordings_own_odometry_is_far_worse():
    """So that the test above is known to measure something."""
    recording = load(INTEL, 2.0)
    pose, poses = Pose2(), []
    for observation in recording.observations("r1"):
        motion = observation.odometry
        pose = pose @ Pose2(motion.dx_m, motion.dy_m, motion.dtheta_rad)
        poses.append(pose.as_array())
    raw = Trajectory(recording.stamps_s("r1"), np.array(poses))
    assert relations_error(raw, read_relations(RELATIONS)).mean_m > 5.0


def test_intel_lies_on_the_reference_path():
    (robot,) = intel().robots
    truth = load(INTEL, 2.0).truth("r1")
    assert truth is not None
    assert absolute_error(robot.final, truth, max_gap_s=5.0).rmse_m < 0.5
    assert robot.sightings > 100
    assert robot.distance_m == pytest.approx(506.0, rel=0.1)


def test_intels_tags_are_known_to_a_hand():
    tags = intel().team.tags
    assert len(tags) > 50
    assert max(float(np.trace(tag.covariance)) for tag in tags) < 1.0
    assert sum(tag.sightings for tag in tags) > 1.5 * len(tags)
