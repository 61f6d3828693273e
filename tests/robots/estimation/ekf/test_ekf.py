"""EKF-SLAM over tags: exact without noise, honest with it, the same in any frame, never locked out."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robots.config import AgentConfig, EkfConfig
from robots.estimation.ekf.filter import EkfFilter
from robots.estimation.ekf.kernels import HEAD
from robots.estimation.ekf.state import TagState
from robots.estimation.tag_filter import RangeSighting
from robots.se2 import GaussianPose, Pose2, wrap

WHITE = replace(AgentConfig(), ekf=EkfConfig(error_lasts_s=0.0))
RUNS = 12


def _off(tag_filter, pose):
    found = tag_filter.belief.mean
    return np.array([found.x - pose.x, found.y - pose.y, wrap(found.theta - pose.theta)])


def _nees(tag_filter, pose):
    off = _off(tag_filter, pose)
    return off @ np.linalg.solve(tag_filter.belief.covariance, off)


def test_without_noise_all_is_exact(tag_walk):
    walk = tag_walk(1, noise=0.0)
    tag_filter = walk.run(EkfFilter("r1", WHITE, walk.start))
    np.testing.assert_allclose(_off(tag_filter, walk.pose), 0.0, atol=1e-9)
    for tag_id, belief in tag_filter.tags().items():
        np.testing.assert_allclose((belief.x_m, belief.y_m), walk.tags[tag_id], atol=1e-9)


def test_the_pose_is_as_far_off_as_it_says(tag_walk):
    """Mean NEES of 3 over 12 runs and 6 times each; loops are closed in between."""
    nees = []
    for seed in range(RUNS):
        walk = tag_walk(seed)
        tag_filter = EkfFilter("r1", WHITE, walk.start)
        walk.run(tag_filter, on_step=lambda k, f=tag_filter, w=walk: nees.append((k, _nees(f, w.pose))))
    late = [value for k, value in nees if k % 50 == 49]
    assert 2.2 < np.mean(late) < 4.0


def test_errors_that_last_do_not_make_it_sure(tag_walk):
    """Told that errors are white, the same filter claims far more than it knows."""
    means = {}
    for lasts_s in (0.0, 10.0):
        nees = []
        for seed in range(RUNS):
            walk = tag_walk(seed, lasting_s=10.0)
            config = replace(AgentConfig(), ekf=EkfConfig(error_lasts_s=lasts_s))
            tag_filter = EkfFilter("r1", config, walk.start)
            walk.run(
                tag_filter,
                on_step=lambda k, f=tag_filter, w=walk, n=nees: k % 50 == 49 and n.append(_nees(f, w.pose)),
            )
        means[lasts_s] = np.mean(nees)
    assert means[10.0] < 4.5
    assert means[0.0] > 2.0 * means[10.0]


@settings(max_examples=5, deadline=None)
@given(st.floats(-50.0, 50.0), st.floats(-3.0, 3.0))
def test_it_is_the_same_in_any_frame(x, turn):
    """Uncertainty of the pose as the robot sees it does not depend on where the map begins."""
    spreads, places = [], []
    for start in (Pose2(), Pose2(x, -x / 2, turn)):
        tag_filter = EkfFilter("r1", WHITE, start)
        rng = np.random.default_rng(3)
        for k in range(40):
            tag_filter.predict(GaussianPose(Pose2(0.2, 0.0, 0.1), np.diag([1e-3, 1e-3, 1e-3])))
            off = rng.standard_normal(2) * 0.05
            tag_filter.see(RangeSighting(f"T{k % 3}", float(k), 3.0 + off[0], 0.1, off[1] + k % 3, 0.05))
        spreads.append([np.linalg.det(tag_filter.belief.covariance), np.trace(tag_filter.belief.covariance)])
        places.append(start.between(tag_filter.belief.mean).as_array())
    np.testing.assert_allclose(places[1], places[0], atol=1e-6)
    np.testing.assert_allclose(spreads[1], spreads[0], rtol=1e-5)


@pytest.mark.parametrize("most_near", [8, 12])
def test_far_tags_put_aside_come_out_as_in_the_full_filter(tag_walk, most_near):
    whole = []
    for most in (64, most_near):
        walk = tag_walk(4, steps=200, side_m=20.0)
        tag_filter = EkfFilter("r1", WHITE, walk.start)
        tag_filter._own = TagState(walk.start, most)
        walk.run(tag_filter)
        state = tag_filter._own
        order = np.argsort(state.tag_ids)
        mean, cov = state.whole()
        rows = np.concatenate([[0, 1, 2], *(HEAD + 2 * order[:, None] + (0, 1))])
        whole.append((mean[rows], cov[np.ix_(rows, rows)]))
        assert len(order) > 20
    (mean, cov), (near_mean, near_cov) = whole
    np.testing.assert_allclose(near_mean, mean, atol=2e-2)
    sds = np.sqrt(np.diag(cov))
    np.testing.assert_allclose(near_cov / np.outer(sds, sds), cov / np.outer(sds, sds), atol=0.05)


def test_a_wild_sighting_pulls_little_and_locks_nothing_out(tag_walk):
    walk = tag_walk(6, noise=0.0)
    tag_filter = walk.run(EkfFilter("r1", WHITE, walk.start))
    sighting = next(s for t in walk.tags if (s := walk.sighting(t, 1e3)) is not None)
    tag_filter.see(replace(sighting, range_m=sighting.range_m + 30.0))
    assert np.abs(_off(tag_filter, walk.pose)).max() < 0.1
    tag_filter.see(replace(sighting, stamp_s=1e3 + 1.0))
    walk.steps = 40
    walk.run(tag_filter)
    assert np.abs(_off(tag_filter, walk.pose)).max() < 0.05
    assert tag_filter.take_doubts() == ()


def test_a_compass_turns_the_robot_and_nothing_else():
    tag_filter = EkfFilter("r1", WHITE, Pose2())
    tag_filter.predict(GaussianPose(Pose2(1.0, 0.0, 0.0), np.diag([1e-6, 1e-6, 0.1])))
    tag_filter.see_heading(0.5, 0.01)
    found = tag_filter.belief
    assert found.mean.theta == pytest.approx(0.5, abs=0.01)
    assert (found.mean.x, found.mean.y) == pytest.approx((1.0, 0.0), abs=1e-9)
    assert found.covariance[2, 2] == pytest.approx(1e-4, rel=0.02)


def test_poses_left_behind_follow_the_tags_seen_from_them(tag_walk):
    walk = tag_walk(8)
    tag_filter = EkfFilter("r1", WHITE, walk.start)
    truths = [walk.start]

    def on_step(k):
        if k % 10 == 0:
            tag_filter.anchor()
            truths.append(walk.pose)

    walk.run(tag_filter, on_step=on_step)
    anchors = tag_filter.anchors()
    assert len(anchors) == len(truths)
    off = [a.distance(t) for a, t in zip(anchors, truths, strict=True)]
    assert off[0] == 0.0
    assert np.mean(off) < 0.4


DATA = Path(__file__).parents[5] / "shared" / "data" / "mrclam6.npz"


@pytest.mark.skipif(not DATA.exists(), reason="the MRCLAM recording is not in ../shared/data")
def test_a_real_robot_alone_stays_within_a_quarter_metre():
    from robots.datasets.mrclam import load
    from robots.datasets.replay import replay
    from robots.evaluation import absolute_error

    recording = load(DATA)
    (robot,) = replay(recording, robots=["r3"], changes={"slam": "ekf"}).robots
    error = absolute_error(robot.online, recording.truth("r3"), max_gap_s=recording.truth_gap_s)
    assert error.rmse_m < 0.25
