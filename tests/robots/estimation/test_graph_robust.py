"""Wrong sightings and wrong edges are let go, and named by their residuals."""

from dataclasses import replace

import numpy as np
import pytest

from robots.estimation.graph import GraphError, solve


def test_residuals_are_mahalanobis_distances_and_single_out_what_is_wrong(graphs):
    rng = np.random.default_rng(60)
    true_poses, true_tags = graphs.truth_of(rng, 20, 5)
    problem = graphs.measured(rng, true_poses, true_tags, noise=0.0, moved=0.0)
    offsets, between = problem.sighting_offsets.copy(), problem.edge_poses.copy()
    offsets[3] += (0.7, -0.4)
    between[20] += (0.5, 0.6, -0.3)  # a loop
    robust = np.arange(len(between)) >= 19
    wrong = replace(
        problem,
        sighting_offsets=offsets,
        edge_poses=between,
        edge_covariances=problem.edge_covariances / 100.0,
        edge_robust=robust,
    )
    solution = solve(wrong, max_iterations=100)
    expected = np.sqrt([0.7, -0.4] @ np.linalg.inv(problem.sighting_covariances[3]) @ [0.7, -0.4])
    assert solution.sighting_residuals[3] == pytest.approx(expected, rel=0.2)
    assert np.argmax(solution.sighting_residuals) == 3
    assert np.argmax(solution.edge_residuals) == 20
    assert np.abs(solution.poses[:, :2] - true_poses[:, :2]).max() < 0.03


@pytest.mark.parametrize("flags", [np.ones(3, np.bool_), np.ones(22), np.ones((22, 1), np.bool_)])
def test_flags_that_do_not_fit_the_edges_are_refused(graphs, flags):
    rng = np.random.default_rng(61)
    problem = graphs.measured(rng, *graphs.truth_of(rng, 20, 2))
    with pytest.raises(GraphError, match="edge_robust has to say true or false"):
        solve(replace(problem, edge_robust=flags))
