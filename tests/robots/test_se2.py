"""Planar poses against an independent implementation, finite differences and Monte Carlo."""

from math import pi

import numpy as np
import pytest
import viser.transforms as oracle

from robots.se2 import GaussianPose, Pose2, compose_jacobians, wrap, wrap_array

HEADINGS = [0.0, 1e-9, -1e-6, 9e-6, 1.1e-5, 0.3, -1.2, 2.5, pi - 1e-3, pi - 1e-6, 1e-3 - pi]
POSES = [Pose2(1.5 - k, 0.4 * k - 2.0, heading) for k, heading in enumerate(HEADINGS)]
PAIRS = [(a, b) for a in POSES for b in POSES[::3]]


def theirs(pose: Pose2) -> oracle.SE2:
    return oracle.SE2.from_xy_theta(pose.x, pose.y, pose.theta)


def assert_agrees(ours: Pose2, other: oracle.SE2) -> None:
    np.testing.assert_allclose([ours.x, ours.y], other.translation(), atol=1e-9)
    assert abs(wrap(ours.theta - float(other.rotation().as_radians()))) < 1e-9


@pytest.mark.parametrize(("a", "b"), PAIRS)
def test_composition_inverse_and_between_agree_with_viser(a, b):
    assert_agrees(a @ b, theirs(a) @ theirs(b))
    assert_agrees(a.inverse(), theirs(a).inverse())
    assert_agrees(a.between(b), theirs(a).inverse() @ theirs(b))


@pytest.mark.parametrize("pose", POSES)
def test_points_agree_with_viser(pose):
    points = np.array([[0.0, 0.0], [1.0, -2.0], [-30.0, 4.0]])
    np.testing.assert_allclose(pose.transform(points), [theirs(pose) @ p for p in points], atol=1e-9)


@pytest.mark.parametrize("pose", POSES)
def test_exp_and_log_agree_with_viser(pose):
    np.testing.assert_allclose(pose.log(), theirs(pose).log(), atol=1e-6)
    assert_agrees(Pose2.exp(pose.as_array()), oracle.SE2.exp(pose.as_array()))


def test_exp_is_smooth_where_the_series_takes_over():
    below, above = (Pose2.exp(np.array([3.0, -2.0, t])).as_array() for t in (0.9999999e-5, 1.0000001e-5))
    np.testing.assert_allclose(below, above, atol=1e-11)


def test_log_of_half_a_turn_is_the_half_circle():
    # half a circle of radius 1 to the left ends 2 m to the left, facing back
    np.testing.assert_allclose(Pose2.exp(np.array([pi, 0.0, pi])).as_array(), [0.0, 2.0, pi], atol=1e-12)
    np.testing.assert_allclose(Pose2(0.0, 2.0, pi).log(), [pi, 0.0, pi], atol=1e-12)


@pytest.mark.parametrize(
    ("angle", "wrapped"), [(pi, pi), (-pi, pi), (3.0 * pi, pi), (-3.5 * pi, pi / 2.0), (0.0, 0.0)]
)
def test_wrap_of_known_angles(angle, wrapped):
    assert wrap(angle) == pytest.approx(wrapped, abs=1e-12)
    assert wrap_array(np.array([angle, angle])) == pytest.approx([wrapped, wrapped], abs=1e-12)


def test_array_form_wraps_the_heading():
    assert Pose2.from_array(np.array([1.0, 2.0, 3.0 * pi])).theta == pytest.approx(pi)
    np.testing.assert_array_equal(Pose2(1.0, 2.0, 0.5).as_array(), [1.0, 2.0, 0.5])


def test_distance_is_between_positions_only():
    assert Pose2(1.0, 1.0, 0.3).distance(Pose2(4.0, 5.0, -2.0)) == pytest.approx(5.0)


@pytest.mark.parametrize(("a", "b"), [(a, b) for a, b in PAIRS if abs(wrap(a.theta + b.theta)) < 3.1])
def test_jacobians_of_composition_against_finite_differences(numerical_jacobian, a, b):
    by_first, by_second = compose_jacobians(a, b)
    first = numerical_jacobian(lambda v: (Pose2(*v) @ b).as_array(), a.as_array())
    second = numerical_jacobian(lambda v: (a @ Pose2(*v)).as_array(), b.as_array())
    np.testing.assert_allclose(by_first, first, atol=1e-8)
    np.testing.assert_allclose(by_second, second, atol=1e-8)


def test_composed_covariance_against_monte_carlo():
    rng = np.random.default_rng(5)
    wide = np.array([[4.0, 1.0, 0.2], [1.0, 9.0, 0.0], [0.2, 0.0, 1.0]]) * 1e-4
    turning = np.array([[1.0, 0.0, -0.1], [0.0, 2.0, 0.3], [-0.1, 0.3, 4.0]]) * 1e-4
    first = GaussianPose(Pose2(2.0, -1.0, 0.7), wide)
    second = GaussianPose(Pose2(5.0, 1.0, -0.4), turning)
    a = rng.multivariate_normal(first.mean.as_array(), first.covariance, 200_000)
    b = rng.multivariate_normal(second.mean.as_array(), second.covariance, 200_000)
    c, s = np.cos(a[:, 2]), np.sin(a[:, 2])
    ends = np.column_stack(
        [a[:, 0] + c * b[:, 0] - s * b[:, 1], a[:, 1] + s * b[:, 0] + c * b[:, 1], a[:, 2] + b[:, 2]]
    )
    composed = first @ second
    sampled = np.cov(ends.T)
    scale = np.sqrt(np.outer(np.diag(sampled), np.diag(sampled)))
    np.testing.assert_allclose(composed.covariance / scale, sampled / scale, atol=0.015)
    np.testing.assert_allclose(composed.mean.as_array(), ends.mean(axis=0), atol=2e-3)
