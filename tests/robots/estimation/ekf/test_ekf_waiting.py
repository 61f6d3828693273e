"""Tags that one sighting cannot place: they wait, and are then where they say they are."""

from dataclasses import replace
from math import pi, radians

import numpy as np
import pytest

from robots.config import AgentConfig, EkfConfig
from robots.estimation.ekf.filter import EkfFilter
from robots.estimation.ekf.waiting import WaitingRoom
from robots.estimation.tag_filter import RangeSighting
from robots.se2 import GaussianPose, Pose2

WHITE = replace(AgentConfig(), ekf=EkfConfig(error_lasts_s=0.0))
STEP = GaussianPose(Pose2(0.2, 0.0, 0.0), np.diag([1e-6, 1e-6, 1e-8]))


def _range(k, x, y, sd=0.05, **more):
    return RangeSighting("A", float(k), float(np.hypot(x - 0.2 * k, y)), sd, **more)


def test_on_a_straight_way_ranges_alone_never_tell_the_side():
    room = WaitingRoom(0.5)
    for k in range(30):
        assert room.add(_range(k, 3.0, 2.0)) is None
        room.move(STEP)


def test_after_a_bend_they_do():
    room, found, pose = WaitingRoom(0.3), None, Pose2()
    for k in range(60):
        range_m = float(np.hypot(3.0 - pose.x, 2.0 - pose.y))
        found = room.add(RangeSighting("A", float(k), range_m, 0.05))
        if found is not None:
            break
        turn = 0.1 if k > 10 else 0.0
        room.move(GaussianPose(Pose2(0.2, 0.0, turn), np.diag([1e-6, 1e-6, 1e-8])))
        pose = pose @ Pose2(0.2, 0.0, turn)
    assert found is not None
    np.testing.assert_allclose(pose.transform_point(*found[0]), (3.0, 2.0), atol=1e-3)


@pytest.mark.parametrize(("turned", "x"), [(0.0, 4.2), (pi, -0.9)])
def test_the_side_of_the_antenna_that_heard_it_is_enough(turned, x):
    """The ring is cut by the cone, ahead while it comes nearer, behind while it falls back."""
    room, found, k, y = WaitingRoom(0.5), None, 0, 0.3
    antenna = Pose2(0.2 if turned == 0.0 else -0.2, 0.0, turned)
    for k in range(15):
        range_m = float(np.hypot(x - 0.2 * k - antenna.x, y))
        found = room.add(
            RangeSighting("A", float(k), range_m, 0.4, 0.0, radians(17.3), base_from_antenna=antenna)
        )
        if found is not None:
            break
        room.move(STEP)
    assert found is not None
    place, spread = found
    off = np.array(place) - (x - 0.2 * k, y)
    assert off @ np.linalg.solve(spread, off) < 9.0
    assert np.linalg.eigvalsh(spread)[-1] <= 0.25


def test_ranges_that_fit_nowhere_place_nothing():
    room, rng, pose = WaitingRoom(0.5), np.random.default_rng(1), Pose2()
    for k in range(40):
        assert room.add(RangeSighting("A", float(k), float(rng.uniform(1.0, 30.0)), 0.05)) is None
        room.move(GaussianPose(Pose2(0.2, 0.0, 0.1), STEP.covariance))
        pose = pose @ Pose2(0.2, 0.0, 0.1)


def test_by_range_alone_a_filter_is_as_far_off_as_it_says(tag_walk):
    nees, placed = [], 0
    for seed in range(8):
        walk = tag_walk(seed, reach_m=9.0)
        tag_filter = walk.run(EkfFilter("r1", WHITE, walk.start), bearing=False)
        off = np.array([tag_filter.belief.mean.x - walk.pose.x, tag_filter.belief.mean.y - walk.pose.y])
        nees.append(off @ np.linalg.solve(tag_filter.belief.covariance[:2, :2], off))
        placed += len(tag_filter.tags())
    assert placed > 8 * 10
    assert np.mean(nees) < 6.0


@pytest.mark.parametrize("log_sd", [0.3, 0.7])
def test_signals_place_a_tag_without_a_bias(log_sd):
    """The logarithm of the range is normal: taken so, tags come out neither near nor far."""
    ratios, nees, (x, y) = [], [], (1.3, 2.0)
    for seed in range(12):
        rng, room, pose, found = np.random.default_rng(seed), WaitingRoom(0.5), Pose2(), None
        for k in range(200):
            true_m = float(np.hypot(x - pose.x, y - pose.y))
            median_m = true_m * float(np.exp(log_sd * rng.standard_normal()))
            found = room.add(
                RangeSighting("A", float(k), median_m, log_sd * median_m, median_m=median_m, log_sd=log_sd)
            )
            if found is not None:
                break
            step = Pose2(0.3, 0.0, 0.12)
            room.move(GaussianPose(step, STEP.covariance))
            pose = pose @ step
        assert found is not None
        off = np.array(found[0]) - pose.inverse().transform_point(x, y)
        nees.append(off @ np.linalg.solve(found[1], off))
        ratios.append(np.log(np.hypot(*found[0]) / np.hypot(x - pose.x, y - pose.y)))
    assert abs(np.mean(ratios)) < 0.15
    assert np.mean(nees) < 5.0
