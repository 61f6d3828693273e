"""Covariances of all vertices at once, against the inverse of the dense normal matrix."""

import numpy as np
import pytest

from robots.estimation.graph.solve import Marginals, solve
from tests.robots.estimation.graph.dense_graphs import NO_KERNEL, whitened


def dense_inverse(problem, solution):
    """The inverse of J'J by finite differences of residuals written anew."""
    values = np.concatenate([solution.poses.ravel(), solution.tags.ravel()])
    h = 1e-6
    J = np.column_stack([
        whitened(problem, NO_KERNEL, values + h * u) - whitened(problem, NO_KERNEL, values - h * u)
        for u in np.eye(len(values))
    ]) / (2 * h)  # fmt: skip
    return np.linalg.inv(J.T @ J)


@pytest.mark.parametrize(("poses", "tags"), [(1, 0), (2, 1), (6, 3), (25, 10)])
def test_all_covariances_are_blocks_of_the_dense_inverse(graphs, poses, tags):
    rng = np.random.default_rng([44, poses])
    problem = graphs.measured(rng, *graphs.truth_of(rng, poses, tags), moved=0.05)
    solution = solve(problem, kernel_sd=NO_KERNEL, max_iterations=100)
    inverse, found = dense_inverse(problem, solution), solution.marginals.all()
    assert found.shape == (poses + tags, 3, 3)
    for k in range(poses):
        block = inverse[3 * k : 3 * k + 3, 3 * k : 3 * k + 3]
        np.testing.assert_allclose(found[k], block, rtol=2e-4, atol=1e-9)
    for k in range(tags):
        at = 3 * poses + 2 * k
        place = inverse[at : at + 2, at : at + 2]
        np.testing.assert_allclose(found[poses + k, :2, :2], place, rtol=2e-4, atol=1e-9)


@pytest.mark.parametrize("seed", range(20))
def test_at_once_is_the_same_as_one_by_one(graphs, seed):
    """In graphs of one piece and of several, whose eliminations are forests."""
    rng = np.random.default_rng([45, seed])
    poses, tags = int(rng.integers(1, 120)), int(rng.integers(0, 60))
    problem = graphs.measured(rng, *graphs.truth_of(rng, poses, tags), moved=0.05)
    marginals: Marginals = solve(problem).marginals
    found = marginals.all()
    single = np.array([marginals.of(k) for k in range(poses + tags)])
    np.testing.assert_allclose(found, single, rtol=1e-7, atol=1e-12 * np.abs(single).max())
    assert np.array_equal(found, found.transpose(0, 2, 1))
    assert np.array_equal(found, marginals.all())  # bit for bit
