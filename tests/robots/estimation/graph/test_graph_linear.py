"""The linear form against Lu and Milios, and marginal covariances against the dense inverse."""

import numpy as np
import pytest

from robots.estimation.graph.solve import GraphProblem, solve
from robots.se2 import wrap_array
from tests.robots.estimation.graph.dense_graphs import NO_KERNEL, whitened


def lu_milios(problem: GraphProblem) -> np.ndarray:
    """The closed form of Lu and Milios 1997 for given headings: G X = B over positions of poses and tags."""
    n, m = len(problem.poses), len(problem.tags)
    G, B = np.zeros((2 * (n + m), 2 * (n + m))), np.zeros(2 * (n + m))
    links = [
        (i, j, z[:2], c[:2, :2])
        for (i, j), z, c in zip(problem.edge_pairs, problem.edge_poses, problem.edge_covariances, strict=True)
    ]
    links += [
        (i, n + k, z, c)
        for (i, k), z, c in zip(
            problem.sighting_pairs, problem.sighting_offsets, problem.sighting_covariances, strict=True
        )
    ]
    for i, j, z, covariance in links:
        c, s = np.cos(problem.poses[i, 2]), np.sin(problem.poses[i, 2])
        R = np.array([[c, -s], [s, c]])
        information, difference = np.linalg.inv(R @ covariance @ R.T), R @ z
        a, b = slice(2 * i, 2 * i + 2), slice(2 * j, 2 * j + 2)
        G[a, a] += information
        G[b, b] += information
        G[a, b] -= information
        G[b, a] -= information
        B[b] += information @ difference
        B[a] -= information @ difference
    for i, pose, sds in zip(problem.prior_index, problem.prior_poses, problem.prior_sds, strict=True):
        a = slice(2 * i, 2 * i + 2)
        G[a, a] += np.diag(sds[:2] ** -2.0)
        B[a] += sds[:2] ** -2.0 * pose[:2]
    return np.linalg.solve(G, B).reshape(-1, 2)


@pytest.mark.parametrize("seed", range(4))
def test_the_linear_form_is_the_closed_form_of_lu_and_milios(graphs, seed):
    rng = np.random.default_rng([30, seed])
    true_poses, true_tags = graphs.truth_of(rng, 9, 4)
    problem = graphs.measured(rng, true_poses, true_tags, moved=0.5)
    problem.poses[:, 2] = true_poses[:, 2]
    solution = solve(problem, method="linear", kernel_sd=NO_KERNEL)
    expected = lu_milios(problem)
    np.testing.assert_allclose(solution.poses[:, :2], expected[:9], atol=1e-8)
    np.testing.assert_allclose(solution.tags, expected[9:], atol=1e-8)
    assert np.array_equal(solution.poses[:, 2], wrap_array(problem.poses[:, 2]))


def test_the_linear_form_is_exact_where_headings_are(graphs):
    rng = np.random.default_rng(5)
    true_poses, true_tags = graphs.truth_of(rng, 15, 5)
    problem = graphs.measured(rng, true_poses, true_tags, noise=0.0, moved=2.0)
    problem.poses[:, 2] = true_poses[:, 2]
    solution = solve(problem, method="linear", kernel_sd=NO_KERNEL)
    np.testing.assert_allclose(solution.poses, true_poses, atol=1e-8)
    np.testing.assert_allclose(solution.tags, true_tags, atol=1e-8)
    assert solution.iterations == 1


@pytest.mark.parametrize("method", ["gauss-newton", "linear"])
def test_marginal_covariances_are_blocks_of_the_dense_inverse(graphs, method):
    rng = np.random.default_rng(6)
    problem = graphs.measured(rng, *graphs.truth_of(rng, 7, 3), moved=0.05)
    solution = solve(problem, method, max_iterations=100, kernel_sd=NO_KERNEL)
    values = np.concatenate([solution.poses.ravel(), solution.tags.ravel()])
    h, count = 1e-6, len(values)
    J = np.column_stack([
        whitened(problem, NO_KERNEL, values + h * u) - whitened(problem, NO_KERNEL, values - h * u)
        for u in np.eye(count)
    ]) / (2 * h)  # fmt: skip
    if method == "gauss-newton":
        dense = np.linalg.inv(J.T @ J)
        for k in range(7):
            at = slice(3 * k, 3 * k + 3)
            np.testing.assert_allclose(solution.pose_covariance(k), dense[at, at], rtol=2e-4, atol=1e-9)
        places = [dense[at : at + 2, at : at + 2] for at in range(21, count, 2)]
    else:
        positions = [k for k in range(count) if k >= 21 or k % 3 < 2]
        dense = np.linalg.inv(_linear_normal(problem))
        places = [dense[at : at + 2, at : at + 2] for at in range(14, len(positions), 2)]
        np.testing.assert_allclose(
            solution.pose_covariance(3)[:2, :2], dense[6:8, 6:8], rtol=1e-6, atol=1e-12
        )
    for k, place in enumerate(places):
        np.testing.assert_allclose(solution.tag_covariance(k), place, rtol=2e-4, atol=1e-9)
        assert np.array_equal(solution.tag_covariance(k), solution.tag_covariance(k).T)


def _linear_normal(problem: GraphProblem) -> np.ndarray:
    """G of the closed form, column by column: G x - B is affine in x."""
    n, m = len(problem.poses), len(problem.tags)
    rows = []
    for i, j, covariance in [
        *((i, j, c[:2, :2]) for (i, j), c in zip(problem.edge_pairs, problem.edge_covariances, strict=True)),
        *(
            (i, n + k, c)
            for (i, k), c in zip(problem.sighting_pairs, problem.sighting_covariances, strict=True)
        ),
    ]:
        row = np.zeros((2, 2 * (n + m)))
        c, s = np.cos(problem.poses[i, 2]), np.sin(problem.poses[i, 2])
        turned = np.array([[c, s], [-s, c]])
        row[:, 2 * j : 2 * j + 2], row[:, 2 * i : 2 * i + 2] = turned, -turned
        rows.append(np.linalg.solve(np.linalg.cholesky(covariance), row))
    hold = np.zeros((2, 2 * (n + m)))
    hold[:, :2] = np.diag(1.0 / problem.prior_sds[0, :2])
    J = np.vstack([*rows, hold])
    return np.asarray(J.T @ J)
