"""The invariant error: Jacobians against finite differences, and what must not depend on the map's frame."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.estimation.ekf import kernels
from robots.se2 import wrap

H = 1e-6


def _state(seed):
    rng = np.random.default_rng(seed)
    mean = rng.uniform(-5.0, 5.0, kernels.HEAD + 6)
    mean[0], mean[3] = wrap(mean[0]), 0.0
    return mean


def _shifted(mean, error):
    moved = mean.copy()
    kernels.retract(moved, len(moved), error)
    return moved


@given(st.integers(0, 10_000))
def test_the_jacobians_of_a_sighting_are_its_derivatives(seed):
    mean, tag, antenna = _state(seed), kernels.HEAD + 2, np.array([0.2, -0.1, 0.4])
    r, _, ex, ey = kernels.expected(mean, tag, antenna)
    if r < 0.5:
        return
    told = np.zeros((2, len(mean)))
    told[:, 1:3] = [[-ex, -ey], [ey / r, -ex / r]]
    told[:, tag : tag + 2] = -told[:, 1:3]
    for k in range(len(mean)):
        error = np.zeros(len(mean))
        error[k] = H
        plus, minus = (kernels.expected(_shifted(mean, e), tag, antenna) for e in (error, -error))
        found = [(plus[0] - minus[0]) / (2 * H), wrap(plus[1] - minus[1]) / (2 * H)]
        np.testing.assert_allclose(found, told[:, k], atol=1e-7)


@given(st.integers(0, 10_000), st.floats(-0.5, 0.5))
def test_errors_stay_what_they_are_when_the_robot_moves(seed, size):
    """The transition is the identity at any size of error: what no additive error has."""
    mean, step = _state(seed), np.array([0.4, 0.1, 0.3])
    error = size * np.random.default_rng(seed + 1).standard_normal(len(mean))
    error[3] = 0.0
    nothing, unused = np.zeros((3, 3)), np.zeros((len(mean), len(mean)))
    first = _shifted(mean, error)
    kernels.move(first, unused, len(mean), step, nothing, False)
    second = mean.copy()
    kernels.move(second, unused, len(mean), step, nothing, False)
    second = _shifted(second, error)
    first[0], second[0] = 0.0, wrap(second[0] - first[0])
    np.testing.assert_allclose(first, second, atol=1e-9)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_noise_of_the_motion_becomes_the_error_it_makes(axis):
    mean, step = _state(3), np.array([0.4, 0.1, 0.3])
    n = len(mean)
    noise, cov = np.zeros((3, 3)), np.zeros((n, n))
    noise[axis, axis] = H**2
    after = mean.copy()
    kernels.move(after, cov, n, step, noise, True)
    off = step.copy()
    off[axis] += H
    really = mean.copy()
    kernels.move(really, np.zeros((n, n)), n, off, np.zeros((3, 3)), True)
    values, vectors = np.linalg.eigh(cov)
    error = vectors[:, -1] * np.sqrt(values[-1])
    error *= np.sign(error[axis - 2 if axis else 1]) or 1.0
    candidates = [_shifted(after, sign * error) for sign in (1.0, -1.0)]
    best = min(candidates, key=lambda c: np.abs(c[:3] - really[:3]).sum())
    np.testing.assert_allclose(best[:3], really[:3], atol=1e-9)
    np.testing.assert_allclose(best[4:], really[4:], atol=1e-9)


def test_a_turn_that_the_noise_made_leaves_the_tags_where_they_are():
    mean = _state(5)
    n = len(mean)
    turned = np.zeros(n)
    turned[0], turned[1], turned[2] = 1.0, mean[2], -mean[1]
    turned[4::2], turned[5::2] = mean[5::2], -mean[4::2]
    after = _shifted(mean, 0.7 * turned)
    np.testing.assert_allclose(after[1:3], mean[1:3], atol=1e-12)
    np.testing.assert_allclose(after[4:], mean[4:], atol=1e-12)
    assert wrap(after[0] - mean[0]) == pytest.approx(0.7)


def test_a_tag_as_near_as_it_is_uncertain_tells_little():
    """A first-order filter that drives over a tag known to half a metre would be sure to centimetres."""
    shares = []
    for away_m in (10.0, 0.3):
        mean, cov = np.zeros(kernels.HEAD + 2), np.zeros((6, 6))
        mean[kernels.HEAD] = away_m
        cov[1, 1] = cov[2, 2] = 0.25
        before = cov[1, 1] + cov[2, 2]
        seen, nothing = np.array([away_m, 1e-4, 0.0, 1e-4, 0.0]), np.zeros((6, 0))
        kernels.see(mean, cov, 6, 4, np.zeros(3), seen, 1.0, 9.0, nothing, np.zeros((0, 0)), np.zeros(0))
        shares.append((cov[1, 1] + cov[2, 2]) / before)
    assert shares[0] < 0.1
    assert shares[1] > 0.4


@given(st.integers(0, 10_000))
def test_variances_of_what_is_expected_are_those_of_the_jacobians(seed):
    mean, tag, antenna = _state(seed), kernels.HEAD + 2, np.array([0.2, -0.1, 0.4])
    root = 0.1 * np.random.default_rng(seed).standard_normal((len(mean), len(mean)))
    cov = root @ root.T
    r, bearing, ex, ey = kernels.expected(mean, tag, antenna)
    told = np.zeros((2, len(mean)))
    told[:, 1:3] = [[-ex, -ey], [ey / r, -ex / r]]
    told[:, tag : tag + 2] = -told[:, 1:3]
    found = kernels.expected_spread(mean, cov, tag, antenna)
    np.testing.assert_allclose(found, [r, bearing, *np.diag(told @ cov @ told.T)], rtol=1e-9)
