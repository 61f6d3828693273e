"""Wrong sightings and wrong edges are let go, and named by their residuals."""

from dataclasses import replace
from math import pi
from pathlib import Path

import numpy as np
import pytest

from robots.datasets import g2o
from robots.estimation.graph.solve import GraphError, GraphProblem, solve

REAL = Path(__file__).parents[5] / "shared" / "data" / "posegraph"


def spoiled(
    rng: np.random.Generator, problem: GraphProblem, share: float, reach_m: float
) -> tuple[GraphProblem, int]:
    """The graph with so many wrong loops more, as a share of its loops, and how many edges are right."""
    loops = np.abs(problem.edge_pairs @ [1, -1]) != 1
    ends = rng.integers(0, len(problem.poses), (round(share * loops.sum()), 2))
    ends = ends[np.abs(ends @ [1, -1]) > 1]
    wrong = np.column_stack([
        rng.uniform(-reach_m, reach_m, (len(ends), 2)), rng.uniform(-pi, pi, len(ends))
    ])  # fmt: skip
    information = problem.edge_information
    if information is None:
        information = np.linalg.inv(problem.edge_covariances)
    like = rng.choice(np.flatnonzero(loops), len(ends))
    return replace(
        problem,
        edge_pairs=np.vstack([problem.edge_pairs, ends]),
        edge_poses=np.vstack([problem.edge_poses, wrong]),
        edge_information=np.concatenate([information, information[like]]),
        edge_robust=np.concatenate([loops, np.ones(len(ends), np.bool_)]),
    ), len(loops)


@pytest.mark.parametrize("share", [0.1, 0.2, 0.3])
@pytest.mark.parametrize("reach_m", [1.0, 5.0])
def test_wrong_loops_leave_the_solution_where_it_would_be_without_them(graphs, share, reach_m):
    rng = np.random.default_rng([62, round(10 * share), round(reach_m)])
    problem, _ = graphs.city(rng, 200)
    clean = solve(problem, max_iterations=100)
    bad, right = spoiled(rng, problem, share, reach_m)
    solution = solve(bad, max_iterations=100)
    np.testing.assert_allclose(solution.poses[:, :2], clean.poses[:, :2], atol=0.05)
    assert solution.edge_residuals[:right].max() < 5.0
    assert solution.edge_residuals[right:].min() > 3.0


@pytest.mark.data
@pytest.mark.parametrize("share", [0.1, 0.3])
def test_wrong_loops_in_a_public_graph_are_named(share):
    path = REAL / "intel.g2o"
    if not path.exists():
        pytest.skip(f"the public pose graph {path.name} is not at hand")
    graph = g2o.read(path)
    problem, _ = graph.problem()
    bad, right = spoiled(np.random.default_rng(63), problem, share, 5.0)
    solution = solve(bad, max_iterations=100, tolerance=1e-6)
    best = solve(problem, max_iterations=100)
    named = solution.edge_residuals[right:] > 6.0
    assert np.sum(~named) <= 1  # of hundreds one may fit by chance, and is believed
    assert (solution.edge_residuals[:right] < 3.0).all()
    assert np.abs(solution.poses[:, :2] - best.poses[:, :2]).max() < 1.0


@pytest.mark.parametrize("seed", range(3))
def test_a_position_seen_without_a_heading_is_robust_like_any_edge(graphs, seed):
    """Robots that see each other know where, not which way: singular information, and one of them wrong."""
    rng = np.random.default_rng([64, seed])
    problem, truth = graphs.city(rng, 120)
    seen = rng.integers(0, 120, (12, 2))
    seen = seen[np.abs(seen @ [1, -1]) > 1]
    c, s = np.cos(truth[seen[:, 0], 2]), np.sin(truth[seen[:, 0], 2])
    dx, dy = (truth[seen[:, 1], :2] - truth[seen[:, 0], :2]).T
    offsets = np.column_stack([c * dx + s * dy, -s * dx + c * dy, np.zeros(len(seen))])
    offsets[0, :2] += (8.0, 6.0)
    information = np.linalg.inv(problem.edge_covariances)
    places = np.tile(np.diag([400.0, 400.0, 0.0]), (len(seen), 1, 1))
    both = replace(
        problem,
        edge_pairs=np.vstack([problem.edge_pairs, seen]),
        edge_poses=np.vstack([problem.edge_poses, offsets]),
        edge_information=np.concatenate([information, places]),
        edge_robust=np.arange(len(information) + len(seen)) >= len(information),
    )
    solution = solve(both, max_iterations=100)
    residuals = solution.edge_residuals[len(information) :]
    assert np.argmax(residuals) == 0
    assert residuals[0] > 20.0
    assert residuals[1:].max() < 5.0


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
