"""The map left in memories: a batch solve from the known start; its covariance in two parts."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.config import AgentConfig
from robots.estimation.anchor_log import AnchorLog
from robots.estimation.ranges.mean import RangeMean
from robots.estimation.rslam.left_map import LeftMap, parted
from robots.estimation.tag_filter import RangeSighting
from robots.se2 import GaussianPose, Pose2
from robots.tags.map_memory import WriterMap
from tests.robots.estimation.rslam.range_world import FOUR, World, nees, range_slam

MORE = FOUR | {"e": (-4.0, -8.0), "f": (-9.0, -3.0)}
LOG_SD, TURN_SD = 0.15, 0.03


def left_by(world: World, steps: int) -> LeftMap:
    """What a robot leaves that drives so far and hears signals."""
    log, left = AnchorLog(0.0, None), LeftMap(AgentConfig(), world.pose)
    for step in range(steps):
        turn = world._steer()
        world.pose = world.pose @ Pose2(world.step_m, 0.0, turn)
        told = Pose2(world.step_m, 0.0, turn + TURN_SD * world.random.normal())
        log.add_anchor(GaussianPose(told, np.diag([1e-4, 1e-4, TURN_SD**2])), float(step), None)
        for name, (x, y) in world.nodes.items():
            true_m = np.hypot(x - world.pose.x, y - world.pose.y)
            median_m = float(true_m * np.exp(LOG_SD * world.random.normal()))
            signal = RangeSighting(
                name, float(step), median_m, LOG_SD * median_m, median_m=median_m, log_sd=LOG_SD,
                independent=True,
            )  # fmt: skip
            log.add_range(signal, GaussianPose.exact())
        if left.is_due(log):
            left.solve(log)
    left.solve(log)
    return left


def spread_of(told: WriterMap) -> np.ndarray:
    spread = np.zeros((3, 3))
    spread[np.triu_indices(3)] = told.frame
    return spread + np.triu(spread, 1).T


@given(st.integers(0, 2**32 - 1))
def test_a_motion_of_all_places_is_the_frames_and_nothing_is_left(seed):
    random = np.random.default_rng(seed)
    places = random.uniform(-20.0, 20.0, (5, 2))
    root = random.normal(size=(3, 3)) * [1.0, 1.0, 0.1]
    frame = root.T @ root
    rigid = np.zeros((5, 2, 3))
    rigid[:, 0, 0] = rigid[:, 1, 1] = 1.0
    rigid[:, 0, 2], rigid[:, 1, 2] = -places[:, 1], places[:, 0]
    rigid = rigid.reshape(-1, 3)
    found = parted(places, rigid @ frame @ rigid.T)
    assert found.frame == pytest.approx(frame, abs=1e-6 * np.trace(frame) + 1e-6)
    assert np.trace(found.places, axis1=1, axis2=2).max() < 1e-3


def test_what_is_left_lies_where_the_robot_started_and_says_how_well():
    misfits, errors = [], []
    for seed in range(4):
        told = left_by(World(dict(MORE), seed=seed), 150).map("r2", 1)
        assert {each.tag_id for each in told.beliefs} == set(MORE)
        errors += [np.hypot(b.x_m - MORE[b.tag_id][0], b.y_m - MORE[b.tag_id][1]) for b in told.beliefs]
        rows = [
            row
            for b in told.beliefs
            for row in ([1.0, 0.0, -MORE[b.tag_id][1]], [0.0, 1.0, MORE[b.tag_id][0]])
        ]
        off = [d for b in told.beliefs for d in (b.x_m - MORE[b.tag_id][0], b.y_m - MORE[b.tag_id][1])]
        frame = np.linalg.lstsq(np.array(rows), np.array(off), rcond=None)[0]
        misfits.append(frame @ np.linalg.solve(spread_of(told), frame) / 3.0)
    assert np.mean(errors) < 1.0
    assert 0.2 < np.mean(misfits) < 3.0


def test_where_starts_are_known_a_map_counts_from_the_first_step():
    told = left_by(World(dict(MORE), seed=3), 150).map("r2", 1)
    here, elsewhere = range_slam(1, starts_known=True), range_slam(1)
    here.read_map(told)
    elsewhere.read_map(told)
    assert set(here.tags()) == set(MORE)
    assert elsewhere.tags() == {}
    for name, tag in here.tags().items():
        place = next(b for b in told.beliefs if b.tag_id == name)
        x, y = place.x_m, place.y_m
        by_frame = np.array([[1.0, 0.0, -y], [0.0, 1.0, x]])
        whole = by_frame @ spread_of(told) @ by_frame.T
        expected = np.trace(whole) + place.variance_x + place.variance_y
        assert tag.variance_x + tag.variance_y == pytest.approx(expected, rel=0.2)


def test_a_robot_with_the_map_is_better_off_than_alone_and_honest():
    alone, with_map, honest = [], [], []
    for seed in range(6):
        told = left_by(World(dict(MORE), seed=seed), 150).map("r2", 1)
        for found, maps in ((alone, ()), (with_map, (told,))):
            world = World(
                dict(MORE), seed=100 + seed, motion_sd=(0.05, 0.02, 0.05), range_sd_m=1.0, scale=1.0
            )
            slam = range_slam(seed, starts_known=True, scale_sd=0.03)
            for each in maps:
                slam.read_map(each)
            for _ in range(100):
                world.step(slam)
                found.append(np.hypot(slam.belief.mean.x - world.pose.x, slam.belief.mean.y - world.pose.y))
            if maps:
                honest.append(nees(slam.belief, world.pose))
    assert np.mean(with_map) < 0.85 * np.mean(alone)
    assert np.mean(honest) < 9.0


@pytest.mark.parametrize("frame", [(float("nan"),) * 6, (-1.0, 0.0, 0.0, 1.0, 0.0, 1.0), (1.0,)])
def test_a_frame_that_cannot_be_is_as_good_as_none(frame):
    told = left_by(World(dict(MORE), seed=3), 40).map("r2", 1)
    slam = range_slam(1, starts_known=True)
    slam.read_map(replace(told, frame=frame))
    assert slam.tags() == {}


def test_signals_of_different_places_average_and_ranges_of_one_do_not():
    signal = RangeSighting("a", 0.0, 11.0, 4.0, median_m=10.0, log_sd=0.3, independent=True)
    measured = RangeSighting("a", 0.0, 10.0, 3.0)
    signals, ranges = RangeMean(), RangeMean()
    for _ in range(4):
        signals.add(signal, GaussianPose.exact())
        ranges.add(measured, GaussianPose.exact())
    assert signals.row[3:5] == pytest.approx((10.0, 1.5))
    assert ranges.row[3:5] == pytest.approx((10.0, 3.0))
