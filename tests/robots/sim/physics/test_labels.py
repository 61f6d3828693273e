"""What counts as slippage, on motions made by hand, and the mission simulator's drives; no physics needed."""

import numpy as np
import pytest

from robots.config import BodyConfig
from robots.estimation.odometry import motion_mean
from robots.se2 import Pose2
from robots.sim.physics.drive import Drive, PhysicsError
from robots.sim.physics.fit import fit_trees, judge, lessons
from robots.sim.physics.kinematic import drive_kinematic
from robots.sim.physics.labels import true_motion
from robots.types import WheelEncoders


def steady(wheels_mps, base_mps, turn_radps=0.0, n=20, dt=0.05):
    """A drive at constant speeds of the four wheels and of the base."""
    pose, poses = Pose2(1.0, 2.0, 0.7), []
    for _ in range(n + 1):
        poses.append(pose.as_array())
        pose = pose @ Pose2.exp(np.array([base_mps, 0.0, turn_radps]) * dt)
    rolled = np.tile(np.array(wheels_mps) * dt, (n, 1))
    poses = np.array(poses)
    return Drive(dt * np.arange(1, n + 1), rolled, poses[1:, 2], np.zeros((n, 2)), poses, rolled)


@pytest.mark.parametrize(
    ("wheels", "base", "turn", "slips"),
    [
        ([0.3] * 4, 0.3, 0.0, False),
        ([0.3] * 4, 0.0, 0.0, True),  # pushing against a wall
        ([0.3] * 4, -0.1, 0.0, True),  # and sliding back down a slope
        ([-0.3] * 4, 0.0, 0.0, True),
        ([0.3] * 4, 0.21, 0.0, False),  # less than 0.1 m/s
        ([0.5] * 4, 0.385, 0.0, False),  # less than a quarter
        ([0.5] * 4, 0.37, 0.0, True),
        ([0.3, 0.3, 0.3, 0.9], 0.3, 0.0, True),  # one wheel spins freely
        ([-0.4, 0.4, -0.4, 0.4], 0.0, 0.6, False),  # scrubbing round on the spot is kinematics
        ([0.0] * 4, 0.3, 0.0, False),  # a sled: the wheels say too little already
        ([0.02] * 4, -0.3, 0.0, False),
    ],
)
def test_slippage_is_where_the_wheels_count_too_much(wheels, base, turn, slips):
    assert true_motion(steady(wheels, base, turn)).slips.tolist() == [slips] * 20


def test_verdicts_are_counted_by_class():
    verdict = judge(np.array([True, False, True, False]), np.array([True, True, False, False]))
    assert (verdict.miss_rate, verdict.false_alarm_rate, verdict.balanced_accuracy) == (0.5, 0.5, 0.5)
    assert np.isnan(judge(np.array([True]), np.array([False])).balanced_accuracy)


def test_a_kinematic_drive_on_firm_floor_without_noise_is_exact():
    drive = drive_kinematic(3, 20.0, level=0, slippery=False)
    pose = Pose2.from_array(drive.poses[0])
    for rolled in drive.rolled_m:
        pose = pose @ motion_mean(WheelEncoders(*map(float, rolled)), None, BodyConfig())
    assert pose.distance(Pose2.from_array(drive.poses[-1])) < 1e-9
    assert not true_motion(drive).slips.any()
    np.testing.assert_allclose(drive.rolled_m, drive.true_rolled_m, atol=1e-12)


def test_a_kinematic_drive_over_slippery_floor_slips_now_and_then():
    drives = [drive_kinematic(seed, 40.0, level=0, slippery=True) for seed in range(4)]
    share = np.mean([true_motion(drive).slips.mean() for drive in drives])
    assert 0.005 < share < 0.5
    learnt = lessons(drives)
    assert len(learnt.basic) == len(learnt.extended) == len(learnt.slips)
    assert np.isfinite(learnt.extended).all()


def test_the_same_lessons_give_the_same_trees_and_both_classes_are_needed():
    pytest.importorskip("sklearn", reason="scikit-learn is not installed; it comes with the extra `physics`")
    learnt = lessons([drive_kinematic(seed, 40.0, level=0, slippery=True) for seed in range(3)])
    trees = fit_trees(learnt)
    assert trees == fit_trees(learnt)
    said = np.array([trees.extended.share(row) > 0.5 for row in learnt.extended.tolist()])
    assert judge(said, learnt.slips).balanced_accuracy > 0.9
    with pytest.raises(PhysicsError, match="more worlds"):
        fit_trees(lessons([drive_kinematic(1, 5.0, level=0, slippery=False)]))
