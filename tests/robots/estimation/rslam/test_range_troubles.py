"""Nodes that misbehave: spikes, walls, silence, moves, doubles, and too little to go by."""

import numpy as np

from robots.estimation.tag_filter import RangeSighting
from tests.robots.estimation.rslam.range_world import FOUR, World, nees, range_slam


def test_spikes_and_a_dead_node_cost_little():
    world, slam = World(FOUR, seed=3), range_slam()

    def spiky(world: World, name: str, range_m: float) -> float | None:
        if name == "d" and world.seconds > 60.0:
            return None
        return world.random.uniform(0.0, 60.0) if world.random.random() < 0.1 else range_m

    for _ in range(150):
        world.step(slam, spiky)
    assert slam.belief.mean.distance(world.pose) < 1.0
    assert set(slam.tags()) == set(FOUR)
    assert slam.take_doubts() == ()


def test_ranges_through_a_wall_are_too_long_and_do_not_bend_the_map():
    world, slam = World(FOUR, seed=4), range_slam()
    for _ in range(80):
        world.step(slam)
    for _ in range(80):  # behind a wall from everywhere on one side
        world.step(slam, lambda w, name, r: r + 4.0 if name == "a" and w.pose.y < 2.0 else r)
    assert slam.belief.mean.distance(world.pose) < 1.0
    assert max(error for name, error in world.errors_m(slam).items() if name != "a") < 1.0


def test_a_node_that_was_moved_gets_its_new_place_and_says_so():
    world, slam = World(dict(FOUR), seed=5), range_slam()
    for _ in range(80):
        world.step(slam)
    world.nodes["b"] = (8.0, -8.0)
    for _ in range(80):
        world.step(slam)
    assert world.errors_m(slam)["b"] < 1.5
    assert slam.belief.mean.distance(world.pose) < 1.0
    assert slam.take_doubts() == ("node b is no longer where it was; it gets a new place",)
    assert slam.take_doubts() == ()


def test_two_nodes_of_one_name_are_told_of_and_do_no_harm():
    world, slam = World(dict(FOUR), seed=6), range_slam()
    both = {"here": FOUR["b"], "there": (9.0, -9.0)}
    for step in range(260):
        world.nodes["b"] = both["here" if step % 40 < 20 else "there"]
        world.step(slam)
    assert slam.belief.mean.distance(world.pose) < 1.0
    doubts = slam.take_doubts()
    assert any("two had the same id" in doubt for doubt in doubts), doubts


def test_with_no_node_in_reach_it_goes_by_odometry_and_knows_less_and_less():
    world, slam = World({}, seed=7), range_slam()
    for _ in range(60):
        world.step(slam)
    early = slam.belief.covariance[0, 0]
    for _ in range(60):
        world.step(slam)
    assert slam.tags() == {}
    assert slam.belief.covariance[0, 0] > early
    assert nees(slam.belief, world.pose) < 16.0
    world.nodes = {name: (x + world.pose.x, y + world.pose.y) for name, (x, y) in FOUR.items()}
    for _ in range(100):
        world.step(slam)
    assert len(slam.tags()) >= 3


def test_one_node_leaves_open_what_it_cannot_tell():
    found = []
    for seed in range(12):
        world, slam = World({"a": (3.0, 5.0)}, seed=seed, motion_sd=(0.05, 0.02, 0.02)), range_slam(seed)
        alone = range_slam(seed)
        for _ in range(100):
            world.step(slam)
            alone.predict(slam_step(world))
        found.append(nees(slam.belief, world.pose))
    assert np.mean(found) < 8.0
    # the heading about the node is as unknown as by odometry alone
    assert slam.belief.covariance[2, 2] > 0.25 * 100 * 0.02**2


def slam_step(world: World):
    from robots.se2 import GaussianPose, Pose2

    return GaussianPose(Pose2(world.step_m, 0.0, 0.0), np.diag(np.array(world.motion_sd) ** 2))


def test_endless_new_names_are_bounded():
    slam = range_slam(particles=10)
    for number in range(1100):
        slam.see(RangeSighting(f"x{number}", float(number), 5.0, 0.2))
    assert slam.take_doubts() == ("more than 1000 nodes were heard; the others are left out",)
