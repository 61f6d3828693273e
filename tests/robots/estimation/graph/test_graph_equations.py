"""The normal equations of the tag graph against finite differences."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest

from robots.estimation.graph.factors import Kernel, linearise, link_error
from robots.estimation.graph.problem import assemble
from robots.estimation.graph.solve import solve
from robots.se2 import Pose2
from tests.robots.estimation.graph.dense_graphs import NO_KERNEL, dense, reference, room_for, whitened


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
