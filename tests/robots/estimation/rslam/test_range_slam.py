"""RSLAM among nodes whose places, offsets and scale are known to the test alone."""

import numpy as np
import pytest

from robots.estimation.rslam.range_slam import RangeSlam
from robots.estimation.tag_filter import RangeSighting
from robots.se2 import Pose2
from robots.snapshot import freeze, thaw
from tests.robots.estimation.rslam.range_world import FOUR, World, nees, range_slam


def driven(world: World, steps: int = 150, seed: int = 0, **changes: float) -> RangeSlam:
    slam = range_slam(seed, **changes)
    for _ in range(steps):
        world.step(slam)
    return slam


def test_without_noise_nodes_offsets_and_scale_come_out():
    offsets = {"a": 0.3, "b": -0.2, "c": 0.0, "d": 0.1}
    world = World(FOUR, range_sd_m=0.01, motion_sd=(1e-4, 1e-4, 1e-4), scale=1.07, offsets=offsets)
    slam = driven(world, 250)
    assert slam.belief.mean.distance(world.pose) < 0.05
    assert slam.range_scale == pytest.approx(1.07, abs=0.01)
    assert max(world.errors_m(slam).values()) < 0.05
    for name, offset in offsets.items():
        assert slam.range_offset(name) == pytest.approx(offset, abs=0.1)


def test_it_beats_dead_reckoning_by_far():
    errors, reckoned = [], []
    for seed in range(3):
        world = World(FOUR, seed=seed)
        slam, alone = range_slam(seed), range_slam(seed)
        for _ in range(200):
            world.step(slam)
        again = World(FOUR, seed=seed)
        for _ in range(200):
            again.step(alone, lambda *_: None)
        errors.append(slam.belief.mean.distance(world.pose))
        reckoned.append(alone.belief.mean.distance(again.pose))
    assert np.mean(errors) < 0.4 * np.mean(reckoned)


def test_its_covariance_is_honest():
    found = []
    for seed in range(16):
        world = World(FOUR, seed=seed)
        slam = range_slam(seed)
        for step in range(120):
            world.step(slam)
            if step % 20 == 19:
                found.append(nees(slam.belief, world.pose))
    assert 1.5 < np.mean(found) < 6.0  # 3 for the exact posterior; particles lose some of their spread


def test_on_a_straight_way_a_node_stays_in_doubt_until_a_turn():
    world, slam = (
        World({"a": (6.0, 5.0)}, scale=1.0, range_sd_m=0.05, motion_sd=(1e-3, 1e-3, 1e-3)),
        range_slam(),
    )
    for _ in range(20):
        world.step(slam, turn_rad=0.0)
    assert slam.tags() == {}
    for _ in range(25):
        world.step(slam, turn_rad=0.15)
    assert world.errors_m(slam)["a"] < 0.5


def test_the_same_seed_gives_the_same_bits_and_a_snapshot_goes_on_alike():
    first, second = (driven(World(FOUR), 40, seed=5) for _ in range(2))
    assert freeze(first) == freeze(second)
    other = thaw(freeze(first), RangeSlam)
    for slam in (first, other):
        world = World(FOUR, seed=9, pose=Pose2(1.0, 1.0, 0.0))
        for _ in range(20):
            world.step(slam)
    assert first.belief.mean == other.belief.mean
    assert driven(World(FOUR), 40, seed=6).belief.mean != second.belief.mean


def test_anchors_are_poses_of_one_particle_from_the_start_on():
    world, slam, true = World(FOUR), range_slam(), [Pose2()]
    for _ in range(120):
        world.step(slam)
        slam.anchor()
        true.append(world.pose)
    anchors = slam.anchors()
    assert len(anchors) == 121
    assert anchors[0] == Pose2()
    assert max(ours.distance(theirs) for ours, theirs in zip(anchors, true, strict=True)) < 1.5


@pytest.mark.parametrize("range_m", [np.nan, np.inf, -1.0])
def test_a_range_that_is_none_is_left_out(range_m):
    slam = driven(World(FOUR), 60)
    before = slam.belief
    assert not slam.see(RangeSighting("a", 100.0, range_m, 0.2))
    assert not slam.see(RangeSighting("a", 100.0, 3.0, 0.0))
    assert slam.belief is before


def test_a_compass_keeps_the_heading():
    world, slam = World({}, motion_sd=(0.01, 0.01, 0.05)), range_slam()
    for _ in range(100):
        world.step(slam)
        slam.see_heading(world.pose.theta, 0.02)
    off = slam.belief.mean.theta - world.pose.theta
    assert abs((off + np.pi) % (2 * np.pi) - np.pi) < 0.06
