"""The final trajectory: through every solved anchor, exact where nothing was corrected."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.se2 import Pose2
from robots.trajectory import Trajectory, TrajectoryStep, final_trajectory, in_order

coordinates = st.floats(-3.0, 3.0)
poses = st.builds(Pose2, coordinates, coordinates, coordinates)


def drive(motions: list[Pose2], per_segment: int) -> tuple[list[TrajectoryStep], np.ndarray, dict]:
    """Dead reckoning with a new anchor every so many motions; steps, anchors and edges agree."""
    world, anchor, local = Pose2(), 0, Pose2()
    anchors, edges, steps = [Pose2()], {}, [TrajectoryStep(0.0, 0, Pose2())]
    for number, motion in enumerate(motions, start=1):
        world, local = world @ motion, local @ motion
        if number % per_segment == 0:
            edges[anchor, anchor + 1] = local
            anchors.append(world)
            anchor, local = anchor + 1, Pose2()
        steps.append(TrajectoryStep(float(number), anchor, local))
    return steps, np.array([pose.as_array() for pose in anchors]), edges


def circle(motions: int = 40, turn: float = 0.1) -> list[Pose2]:
    return [Pose2(0.2, 0.0, turn)] * motions


@given(motions=st.lists(poses, min_size=1, max_size=12), per_segment=st.integers(1, 5))
def test_nothing_corrected_is_the_measured_trajectory_exactly(motions, per_segment):
    steps, anchors, edges = drive(motions, per_segment)
    final = final_trajectory(steps, anchors, edges)
    world = Pose2()
    expected = [world]
    for motion in motions:
        world = world @ motion
        expected.append(world)
    for row, pose in zip(final.poses, expected, strict=True):
        assert pose.between(Pose2.from_array(row)).as_array() == pytest.approx(np.zeros(3), abs=1e-9)


@given(correction=st.builds(Pose2, st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.floats(-0.5, 0.5)))
def test_there_is_no_jump_at_a_corrected_anchor(correction):
    steps, anchors, edges = drive(circle(), 10)
    anchors[2:] = [(Pose2.from_array(row) @ correction).as_array() for row in anchors[2:]]
    final = final_trajectory(steps, anchors, edges)
    for at, step in enumerate(steps):
        if step.anchor_from_base == Pose2():
            assert final.poses[at] == pytest.approx(anchors[step.anchor], abs=1e-9)
    per_step = np.linalg.norm([correction.x, correction.y]) / 10 + 0.5 * abs(correction.theta) + 0.21
    moved = [np.hypot(*(after - before)[:2]) for before, after in pairwise(final.poses)]
    assert max(moved) < per_step


def test_a_constant_bias_of_the_turn_is_undone_by_the_correction_of_the_end():
    """Wheels that turn too little all the way: knowing where the segment ends gives back the way between."""
    true_steps, true_anchors, _ = drive(circle(turn=0.10), 20)
    measured_steps, _, measured_edges = drive(circle(turn=0.09), 20)
    final = final_trajectory(measured_steps, true_anchors, measured_edges)
    truth = final_trajectory(true_steps, true_anchors, {})
    assert np.abs(final.poses - truth.poses)[:40].max() < 0.005
    raw = final_trajectory(measured_steps, true_anchors, {})
    assert np.abs(raw.poses - truth.poses)[:40].max() > 0.2


def test_an_edge_counts_in_either_direction():
    steps, anchors, edges = drive(circle(), 10)
    anchors[1:, 0] += 0.3
    backward = {(b, a): pose.inverse() for (a, b), pose in edges.items()}
    expected = final_trajectory(steps, anchors, edges).poses
    assert final_trajectory(steps, anchors, backward).poses == pytest.approx(expected, abs=1e-9)


def test_a_robot_that_stood_still_is_carried_to_the_next_anchor():
    steps = [TrajectoryStep(float(i), 0, Pose2()) for i in range(3)] + [TrajectoryStep(3.0, 1, Pose2())]
    final = final_trajectory(steps, np.array([[0.0, 0.0, 0.0], [0.4, 0.0, 0.0]]), {(0, 1): Pose2()})
    assert final.poses[:, 0] == pytest.approx([0.1, 0.2, 0.3, 0.4])


def test_a_step_at_an_unsolved_anchor_is_refused():
    with pytest.raises(ValueError, match="step 0 hangs at anchor 3"):
        final_trajectory([TrajectoryStep(0.0, 3, Pose2())], np.zeros((1, 3)), {})


def test_no_steps_make_an_empty_trajectory():
    assert len(final_trajectory([], np.zeros((0, 3)), {})) == 0


def test_in_order_keeps_rising_stamps_only():
    stamps = np.array([np.nan, 1.0, 3.0, 2.0, 3.0, 4.0])
    poses = np.arange(18.0).reshape(6, 3)
    kept = in_order(Trajectory(stamps, poses))
    assert kept.stamps_s.tolist() == [1.0, 3.0, 4.0]
    assert kept.poses[:, 0].tolist() == [3.0, 6.0, 15.0]
    assert len(in_order(Trajectory(np.array([np.nan]), np.zeros((1, 3))))) == 0


def test_stamps_and_poses_have_to_go_together():
    with pytest.raises(ValueError, match="do not go with poses"):
        Trajectory(np.zeros(2), np.zeros((3, 3)))
