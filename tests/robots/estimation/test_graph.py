"""The tag graph against scipy's general least squares, dense algebra and graphs whose answer is known."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from scipy.optimize import least_squares

from robots.estimation.graph import GraphProblem, solve
from robots.estimation.graph_factors import Equations, Kernel, linearise, link_error
from robots.estimation.graph_order import Order, order
from robots.estimation.graph_problem import assemble
from robots.se2 import Pose2, wrap_array

NO_KERNEL = 1e9


def whitened(problem: GraphProblem, kernel_sd: float, values: np.ndarray) -> np.ndarray:
    """Residuals whose sum of squares is W of eq. (5), written anew with numpy alone."""
    n = len(problem.poses)
    poses, tags = values[: 3 * n].reshape(-1, 3), values[3 * n :].reshape(-1, 2)
    parts = []
    for (i, j), z, covariance in zip(
        problem.edge_pairs, problem.edge_poses, problem.edge_covariances, strict=True
    ):
        c, s = np.cos(poses[i, 2]), np.sin(poses[i, 2])
        at = np.array([[c, s], [-s, c]]) @ (poses[j, :2] - poses[i, :2]) - z[:2]
        turn = (poses[j, 2] - poses[i, 2] - z[2] + pi) % (2 * pi) - pi
        parts.append(np.linalg.solve(np.linalg.cholesky(covariance), np.array([*at, turn])))
    for (i, k), z, covariance in zip(
        problem.sighting_pairs, problem.sighting_offsets, problem.sighting_covariances, strict=True
    ):
        c, s = np.cos(poses[i, 2]), np.sin(poses[i, 2])
        error = np.array([[c, s], [-s, c]]) @ (tags[k] - poses[i, :2]) - z
        error = np.linalg.solve(np.linalg.cholesky(covariance), error)
        size = np.sqrt(error @ error)
        if size > kernel_sd:  # Huber: W grows linearly from there
            error = error / size * np.sqrt(2.0 * kernel_sd * size - kernel_sd**2)
        parts.append(error)
    off = poses[problem.prior_index] - problem.prior_poses
    off[:, 2] = (off[:, 2] + pi) % (2 * pi) - pi
    parts.append((off / problem.prior_sds).ravel())
    turned = (poses[problem.heading_index, 2] - problem.heading_rad + pi) % (2 * pi) - pi
    parts.append(turned / problem.heading_sd_rad)
    return np.concatenate(parts)


def reference(problem: GraphProblem, kernel_sd: float) -> tuple[np.ndarray, np.ndarray, float]:
    start = np.concatenate([problem.poses.ravel(), problem.tags.ravel()])
    found = least_squares(
        lambda x: whitened(problem, kernel_sd, x), start, xtol=1e-14, ftol=1e-14, gtol=1e-12
    )
    n = 3 * len(problem.poses)
    return found.x[:n].reshape(-1, 3), found.x[n:].reshape(-1, 2), 2.0 * float(found.cost)


def room_for(count: int, pairs: np.ndarray) -> tuple[Order, Equations]:
    frame, slot, turned = order(count, pairs)
    blocks = np.empty((len(frame.entries), 3, 3))
    return frame, Equations(slot, turned, np.empty((count, 3, 3)), blocks, np.empty((count, 3)))


def dense(equations: Equations, pairs: np.ndarray) -> np.ndarray:
    """The whole matrix of the normal equations."""
    n = len(equations.diagonal)
    matrix = np.zeros((n, 3, n, 3))
    for i in range(n):
        matrix[i, :, i] = equations.diagonal[i]
    for (a, b), slot, turned in zip(pairs, equations.slot, equations.turned, strict=True):
        if slot >= 0:
            block = equations.beside[slot] if turned else equations.beside[slot].T  # a by b
            matrix[a, :, b], matrix[b, :, a] = block, block.T
    return matrix.reshape(3 * n, 3 * n)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("kernel_sd", [NO_KERNEL, 1.0])
def test_the_normal_equations_are_those_of_finite_differences(graphs, seed, kernel_sd):
    """Blocks and gradient against J'J and J'r of the residuals written anew; with a kernel, the gradient."""
    rng = np.random.default_rng([40, seed])
    problem = graphs.measured(rng, *graphs.truth_of(rng, 6, 3), moved=0.1)
    state, factors = assemble(problem)
    _, equations = room_for(9, factors.pairs)
    chi2 = linearise(state, factors, equations, Kernel(kernel_sd, False), False)
    values, h = np.concatenate([problem.poses.ravel(), problem.tags.ravel()]), 1e-6
    J = np.column_stack([
        whitened(problem, kernel_sd, values + h * u) - whitened(problem, kernel_sd, values - h * u)
        for u in np.eye(len(values))
    ]) / (2 * h)  # fmt: skip
    residuals = whitened(problem, kernel_sd, values)
    assert chi2 == pytest.approx(residuals @ residuals, rel=1e-10)
    kept = [k for k in range(27) if k < 18 or k % 3 < 2]  # tags have no heading
    scale = np.sqrt(np.diag(J.T @ J))
    found = equations.gradient.ravel()[kept]
    np.testing.assert_allclose(found / scale, J.T @ residuals / scale, atol=1e-5 * np.linalg.norm(residuals))
    if kernel_sd == NO_KERNEL:
        H = dense(equations, factors.pairs)[np.ix_(kept, kept)]
        np.testing.assert_allclose(H / np.outer(scale, scale), J.T @ J / np.outer(scale, scale), atol=1e-7)


def test_two_edges_between_the_same_poses_add_up_whichever_way_they_point(graphs):
    rng = np.random.default_rng(41)
    problem = graphs.measured(rng, *graphs.truth_of(rng, 6, 0), moved=0.1)
    there = problem.edge_poses[2]
    back = Pose2.from_array(there).inverse().as_array() + 0.05 * rng.normal(size=3)
    twice = replace(
        problem,
        edge_pairs=np.vstack([problem.edge_pairs, [[3, 2], [2, 3]]]),
        edge_poses=np.vstack([problem.edge_poses, back, there + 0.05 * rng.normal(size=3)]),
        edge_covariances=np.concatenate([problem.edge_covariances, 0.01 * np.array([np.eye(3)] * 2)]),
    )
    solution = solve(twice, max_iterations=100)
    assert solution.chi2 == pytest.approx(reference(twice, NO_KERNEL)[2], rel=1e-6)


def test_errors_of_headings_take_the_short_way_round():
    looking_west = np.array([[1.0, 2.0, 3.1], [0.0, 0.0, -3.1]])
    measured = np.array([0.0, 0.0, 0.0])
    assert link_error(looking_west[0], looking_west[1], measured)[2] == pytest.approx(2 * pi - 6.2)
    assert link_error(looking_west[1], looking_west[0], measured)[2] == pytest.approx(6.2 - 2 * pi)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("kernel_sd", [NO_KERNEL, 1.0])
def test_gauss_newton_finds_the_minimum_that_scipy_finds(graphs, seed, kernel_sd):
    rng = np.random.default_rng([10, seed])
    problem = graphs.measured(rng, *graphs.truth_of(rng, 6, 3), headings=seed % 2 == 0)
    solution = solve(problem, kernel_sd=kernel_sd, max_iterations=100, kernel="huber")
    poses, tags, chi2 = reference(problem, kernel_sd)
    assert solution.chi2 == pytest.approx(chi2, rel=1e-6, abs=1e-9)
    assert solution.chi2 < solution.chi2_initial
    np.testing.assert_allclose(solution.poses[:, :2], poses[:, :2], atol=2e-4)
    np.testing.assert_allclose(wrap_array(solution.poses[:, 2] - poses[:, 2]), 0.0, atol=2e-4)
    np.testing.assert_allclose(solution.tags, tags, atol=2e-4)


def test_the_kernel_keeps_one_wrong_sighting_from_bending_the_graph(graphs):
    """A tag that was moved between two sightings."""
    rng = np.random.default_rng(3)
    true_poses, true_tags = graphs.truth_of(rng, 8, 3)
    problem = graphs.measured(rng, true_poses, true_tags, noise=0.0, moved=0.0)
    offsets = problem.sighting_offsets.copy()
    offsets[1] += (1.5, -1.0)
    stiff = problem.edge_covariances / 100.0  # else the edges give way and nothing contradicts the sighting
    problem = replace(problem, sighting_offsets=offsets, edge_covariances=stiff)
    bent = np.abs(solve(problem, kernel_sd=NO_KERNEL).poses[:, :2] - true_poses[:, :2]).max()
    robust = np.abs(solve(problem, kernel_sd=3.0, max_iterations=100).poses[:, :2] - true_poses[:, :2]).max()
    assert bent > 0.05
    assert robust < bent / 3.0


@pytest.mark.parametrize("seed", range(4))
def test_a_noiseless_graph_is_exact_from_a_perturbed_start(graphs, seed):
    rng = np.random.default_rng([20, seed])
    true_poses, true_tags = graphs.truth_of(rng, 12, 4)
    solution = solve(graphs.measured(rng, true_poses, true_tags, noise=0.0, moved=0.4), kernel_sd=NO_KERNEL)
    np.testing.assert_allclose(solution.poses[:, :2], true_poses[:, :2], atol=1e-7)
    np.testing.assert_allclose(wrap_array(solution.poses[:, 2] - true_poses[:, 2]), 0.0, atol=1e-7)
    np.testing.assert_allclose(solution.tags, true_tags, atol=1e-7)
    assert solution.chi2 < 1e-9


def test_headings_near_half_a_turn_do_not_tear_the_graph(graphs):
    """Everything looks west: neighbours differ by nearly a whole turn on paper."""
    rng = np.random.default_rng(4)
    true_poses, true_tags = graphs.truth_of(rng, 10, 3)
    true_poses[:, 2] = wrap_array(pi + 0.2 * rng.standard_normal(10))
    assert np.ptp(true_poses[:, 2]) > 6.0  # both sides of the seam are there
    solution = solve(graphs.measured(rng, true_poses, true_tags, noise=0.0, moved=0.3), kernel_sd=NO_KERNEL)
    np.testing.assert_allclose(wrap_array(solution.poses[:, 2] - true_poses[:, 2]), 0.0, atol=1e-7)
    assert np.abs(solution.poses[:, 2]).max() <= pi
    noisy = graphs.measured(rng, true_poses, true_tags, noise=1.0, moved=0.3)
    assert solve(noisy, kernel_sd=NO_KERNEL, max_iterations=100).chi2 == pytest.approx(
        reference(noisy, NO_KERNEL)[2], rel=1e-6
    )


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


def test_a_graph_along_the_axes_is_solved_like_any_other():
    """A square whose headings are 0, 90, 180 and 270 degrees, closed by a tag at its start."""
    legs = np.array([[1.0, 0.0, pi / 2]] * 4)
    truth = np.array([[0, 0, 0], [1, 0, pi / 2], [1, 1, pi], [0, 1, -pi / 2], [0, 0, 0]], float)
    problem = GraphProblem(
        poses=truth + np.arange(5)[:, None] * (0.05, -0.03, 0.02),
        tags=np.array([[0.1, 0.1]]),
        edge_pairs=np.array([[k, k + 1] for k in range(4)]),
        edge_poses=legs,
        edge_covariances=np.tile(np.diag([0.01, 0.01, 0.001]), (4, 1, 1)),
        sighting_pairs=np.array([[0, 0], [4, 0]]),
        sighting_offsets=np.zeros((2, 2)),
        sighting_covariances=np.tile(np.diag([1e-4, 1e-4]), (2, 1, 1)),
        prior_index=np.zeros(1, np.int64),
        prior_poses=truth[:1],
        prior_sds=np.full((1, 3), 1e-3),
    )
    solution = solve(problem, kernel_sd=NO_KERNEL)
    np.testing.assert_allclose(solution.poses[:, :2], truth[:, :2], atol=1e-8)
    np.testing.assert_allclose(wrap_array(solution.poses[:, 2] - truth[:, 2]), 0.0, atol=1e-8)
    np.testing.assert_allclose(solution.tags, [[0.0, 0.0]], atol=1e-8)


def test_solving_leaves_the_problem_as_it_was(graphs):
    rng = np.random.default_rng(11)
    problem = graphs.measured(rng, *graphs.truth_of(rng, 6, 2))
    before = {name: np.array(getattr(problem, name)) for name in problem.__slots__}
    first = solve(problem)
    second = solve(problem)
    for name, array in before.items():
        assert np.array_equal(getattr(problem, name), array), name
    assert np.array_equal(first.poses, second.poses)  # bit for bit
    assert np.array_equal(first.tags, second.tags)
