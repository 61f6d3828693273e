"""The tag graph against scipy's general least squares, and graphs whose answer is known."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest

from robots.estimation.graph.solve import GraphProblem, solve
from robots.se2 import wrap_array
from tests.robots.estimation.graph.dense_graphs import NO_KERNEL, reference


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
