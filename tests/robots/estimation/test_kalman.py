"""Fusion of two estimates of one pose: eq. (3) and (4) of Kleiner 2006 and what must follow from them."""

from math import pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.estimation.kalman import at_least, fuse
from robots.se2 import GaussianPose, Pose2, wrap


def belief(seed: int, theta: float | None = None, spread: float = 0.3) -> GaussianPose:
    rng = np.random.default_rng(seed)
    root = spread * (np.eye(3) + 0.5 * rng.standard_normal((3, 3)))
    heading = float(rng.uniform(-pi, pi)) if theta is None else theta
    x, y = (float(value) for value in rng.uniform(-5, 5, 2))
    return GaussianPose(Pose2(x, y, wrap(heading)), root @ root.T + 1e-4 * np.eye(3))


seeds = st.integers(0, 2**32 - 1)
angles = st.floats(-pi, pi)


@given(seeds, seeds, angles, st.floats(-1.0, 1.0))
def test_it_is_the_information_form(one, two, theta, apart):
    a, b = belief(one, theta), belief(two, theta + apart)
    fused = fuse(a, b)
    La, Lb = np.linalg.inv(a.covariance), np.linalg.inv(b.covariance)
    unwrapped = b.mean.as_array()
    unwrapped[2] = a.mean.theta + wrap(b.mean.theta - a.mean.theta)
    mean = np.linalg.solve(La + Lb, La @ a.mean.as_array() + Lb @ unwrapped)
    np.testing.assert_allclose(fused.covariance @ (La + Lb), np.eye(3), atol=1e-6)
    np.testing.assert_allclose(fused.mean.as_array()[:2], mean[:2], atol=1e-7)
    assert wrap(fused.mean.theta - mean[2]) == pytest.approx(0.0, abs=1e-7)


@given(seeds, seeds, angles, st.floats(-1.5, 1.5))
def test_which_comes_first_does_not_matter(one, two, theta, apart):
    a, b = belief(one, theta), belief(two, theta + apart)
    there, back = fuse(a, b), fuse(b, a)
    np.testing.assert_allclose(there.covariance, back.covariance, atol=1e-9)
    np.testing.assert_allclose(there.mean.as_array()[:2], back.mean.as_array()[:2], atol=1e-7)
    assert wrap(there.mean.theta - back.mean.theta) == pytest.approx(0.0, abs=1e-8)


@given(seeds, seeds)
def test_the_covariance_is_symmetric_and_never_larger_than_either(one, two):
    a, b = belief(one), belief(two)
    fused = fuse(a, b).covariance
    assert np.array_equal(fused, fused.T)
    assert np.linalg.eigvalsh(fused)[0] > 0.0
    for given_ in (a.covariance, b.covariance):
        assert np.linalg.eigvalsh(given_ - fused)[0] > -1e-9


@pytest.mark.parametrize(("l", "k"), [(3.1, -3.1), (-3.1, 3.1), (pi, -pi + 0.2), (-3.0, 3.1)])
def test_headings_either_side_of_west_meet_in_the_west(l, k):  # noqa: E741 - the paper's name
    even = np.diag([0.1, 0.1, 0.1])
    fused = fuse(GaussianPose(Pose2(0, 0, l), even), GaussianPose(Pose2(0, 0, k), even))
    assert -pi < fused.mean.theta <= pi
    assert wrap(fused.mean.theta - (l + wrap(k - l) / 2.0)) == pytest.approx(0.0, abs=1e-12)
    assert abs(fused.mean.theta) > 3.0  # not east, where the plain mean lies


def test_correlation_carries_a_measured_heading_into_the_place():
    """After 10 m straight ahead with an uncertain heading, learning the heading tells where the robot is."""
    sd = 0.1
    predicted = GaussianPose(
        Pose2(10.0, 0.0, 0.0), np.array([[0.01, 0, 0], [0, 1.0001, 0.1], [0, 0.1, sd**2]]) + 1e-9 * np.eye(3)
    )
    heading_only = GaussianPose(Pose2(10.0, 0.0, 0.05), np.diag([1e6, 1e6, 1e-8]))
    assert fuse(predicted, heading_only).mean.y == pytest.approx(0.5, abs=0.01)


def test_a_singular_covariance_is_refused():
    with pytest.raises(np.linalg.LinAlgError):
        fuse(GaussianPose.exact(), belief(1))


@given(seeds, seeds)
def test_the_larger_of_two_covariances_claims_less_than_either(one, two):
    a, b = belief(one).covariance, belief(two).covariance
    larger = at_least(a, b)
    for smaller in (a, b):
        assert np.linalg.eigvalsh(larger - smaller)[0] > -1e-9
    np.testing.assert_allclose(larger, at_least(b, a), atol=1e-8)
    np.testing.assert_allclose(at_least(larger, a), larger, atol=1e-9)
    assert np.linalg.matrix_rank(larger - a, tol=1e-7) + np.linalg.matrix_rank(larger - b, tol=1e-7) <= 3


def test_along_the_axes_the_larger_covariance_counts():
    found = at_least(np.diag([1.0, 4.0, 0.0]), np.diag([2.0, 3.0, 0.0]))
    np.testing.assert_allclose(found, np.diag([2.0, 4.0, 0.0]), atol=1e-9)
