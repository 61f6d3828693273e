"""SE(2) is a group, exp and log are each other's inverse, and covariances compose as the poses do."""

from math import isfinite, pi

import numpy as np
from hypothesis import example, given
from hypothesis import strategies as st

from robots.se2 import GaussianPose, Pose2, wrap, wrap_array

metres = st.floats(-100.0, 100.0)
near_pi = st.floats(-1e-3, 1e-3).map(lambda off: pi + off)
near_zero = st.floats(-1e-3, 1e-3)
headings = st.one_of(st.floats(-pi, pi), near_pi, near_zero, near_pi.map(lambda a: -a)).map(wrap)
poses = st.builds(Pose2, metres, metres, headings)
sides = st.floats(0.01, 0.5)


@st.composite
def covariances(draw):
    root = np.array(draw(st.lists(st.floats(-0.3, 0.3), min_size=9, max_size=9))).reshape(3, 3)
    return root @ root.T + np.eye(3) * 1e-4


gaussians = st.builds(GaussianPose, poses, covariances())


def assert_same(a: Pose2, b: Pose2, within: float = 1e-9) -> None:
    assert abs(a.x - b.x) < within
    assert abs(a.y - b.y) < within
    assert abs(wrap(a.theta - b.theta)) < within


@given(st.floats(-1e6, 1e6))
@example(-pi)
@example(pi)
@example(np.nextafter(-pi, -4.0))
@example(np.nextafter(pi, 4.0))
@example(-3.0 * pi)
def test_wrap_keeps_the_direction_and_lands_in_the_half_open_range(angle):
    wrapped = wrap(angle)
    assert -pi < wrapped <= pi
    tolerance = 1e-9 + 1e-15 * abs(angle)
    assert abs(np.exp(1j * wrapped) - np.exp(1j * angle)) < tolerance
    assert wrap_array(np.array([angle]))[0] == wrapped


@given(poses, poses)
def test_closure(a, b):
    for pose in (a @ b, a.inverse(), a.between(b)):
        assert isfinite(pose.x)
        assert isfinite(pose.y)
        assert -pi < pose.theta <= pi


@given(poses)
def test_identity(a):
    assert_same(Pose2() @ a, a)
    assert_same(a @ Pose2(), a)


@given(poses)
def test_inverse(a):
    assert_same(a @ a.inverse(), Pose2())
    assert_same(a.inverse() @ a, Pose2())


@given(poses, poses, poses)
def test_associativity(a, b, c):
    assert_same((a @ b) @ c, a @ (b @ c))


@given(poses, poses)
def test_between_is_what_is_missing(a, b):
    assert_same(a @ a.between(b), b)
    assert_same(a.between(b), a.inverse() @ b)


@given(poses, poses, metres, metres)
def test_composition_transforms_points_one_after_the_other(a, b, x, y):
    point = np.array([[x, y]])
    through = a.transform(b.transform(point))
    np.testing.assert_allclose((a @ b).transform(point), through, atol=1e-9)
    np.testing.assert_allclose(a.transform_point(*b.transform_point(x, y)), through[0], atol=1e-9)


@given(poses)
def test_exp_undoes_log(a):
    assert_same(Pose2.exp(a.log()), a, within=1e-8)


# at exactly half a turn back the heading comes out as half a turn forth, so the twists stop short of it
@given(metres, metres, st.one_of(st.floats(-3.14159, 3.14159), near_zero, st.floats(-1e-7, 1e-7)))
def test_log_undoes_exp(vx, vy, omega):
    np.testing.assert_allclose(Pose2.exp(np.array([vx, vy, omega])).log(), [vx, vy, omega], atol=1e-7)


@given(metres, metres, st.floats(-1.5, 1.5))
def test_half_a_twist_twice_is_the_whole_twist(vx, vy, omega):
    half = Pose2.exp(np.array([vx, vy, omega]) / 2.0)
    assert_same(half @ half, Pose2.exp(np.array([vx, vy, omega])))


@given(gaussians, gaussians, gaussians)
def test_uncertain_composition_is_associative(a, b, c):
    left, right = (a @ b) @ c, a @ (b @ c)
    assert_same(left.mean, right.mean)
    scale = np.abs(left.covariance).max()
    np.testing.assert_allclose(left.covariance, right.covariance, atol=1e-10 * scale)


@given(gaussians)
def test_an_exact_pose_adds_no_uncertainty(a):
    after = a @ GaussianPose.exact()
    np.testing.assert_allclose(after.covariance, a.covariance, atol=1e-12)
    before = GaussianPose.exact() @ a
    np.testing.assert_allclose(before.covariance, a.covariance, atol=1e-12)


@given(gaussians, gaussians)
def test_composed_covariance_is_symmetric_and_positive(a, b):
    covariance = (a @ b).covariance
    assert (covariance == covariance.T).all()
    assert np.linalg.eigvalsh(covariance)[0] > 0.0
    assert covariance[2, 2] >= max(a.covariance[2, 2], b.covariance[2, 2])
