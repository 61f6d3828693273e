"""Graphs that start badly reach the optimum all the same; the public ones where they are at hand."""

from dataclasses import replace
from math import pi
from pathlib import Path

import numpy as np
import pytest

from robots.datasets import g2o
from robots.estimation.graph.problem import assemble
from robots.estimation.graph.solve import GraphError, GraphProblem, solve
from robots.estimation.graph.tree import along_tree
from robots.se2 import Pose2, wrap_array

REAL = Path(__file__).parents[5] / "shared" / "data" / "posegraph"


def bad_starts(rng: np.random.Generator, problem: GraphProblem) -> dict[str, np.ndarray]:
    n = len(problem.poses)
    state, factors = assemble(problem)
    odometry = factors._replace(
        pairs=factors.pairs[: n - 1], measured=factors.measured[: n - 1], tags_from=n - 1
    )
    scrambled = np.column_stack([rng.uniform(-50, 50, (n, 2)), rng.uniform(-pi, pi, n)])
    return {
        "scrambled": scrambled,
        "odometry": along_tree(state, odometry),
        "nothing": np.zeros((n, 3)),
        "mixed up": problem.poses[rng.permutation(n)],
    }


@pytest.mark.parametrize("seed", range(8))
def test_every_bad_start_ends_where_the_truth_would(graphs, seed):
    rng = np.random.default_rng([50, seed])
    problem, truth = graphs.city(rng, 400)
    best = solve(problem, max_iterations=100)
    assert best.chi2 < 3.0 * (3 * len(problem.edge_pairs))  # what it should be, about one a number measured
    for name, start in bad_starts(rng, problem).items():
        found = solve(replace(problem, poses=start), max_iterations=100)
        assert found.chi2 == pytest.approx(best.chi2, rel=1e-5), name
        np.testing.assert_allclose(found.poses[:, :2], best.poses[:, :2], atol=0.01, err_msg=name)
        assert np.abs(wrap_array(found.poses[:, 2] - truth[:, 2])).max() < 0.6, name


def test_a_long_chain_with_one_loop_at_its_end_closes():
    """Odometry is 60 degrees and tens of metres off when the loop is found."""
    rng = np.random.default_rng(51)
    n, step = 1500, Pose2(0.5, 0.0, 2.0 * pi / 500)
    truth = [Pose2()]
    for _ in range(n):
        truth.append(truth[-1] @ step)
    measured = np.tile(step.as_array(), (n, 1)) + rng.normal(0.0, [0.01, 0.01, 0.01], (n, 3))
    measured[:, 2] += 1.0 / n  # a wheel of which nobody knew that it was small
    chain = np.column_stack([np.arange(n), np.arange(n) + 1])
    none = np.zeros(0)
    problem = GraphProblem(
        poses=np.zeros((n + 1, 3)),
        tags=none,
        edge_pairs=np.vstack([chain, [[0, n]]]),
        edge_poses=np.vstack([measured, truth[0].between(truth[-1]).as_array()[None]]),
        edge_covariances=np.concatenate([
            np.tile(np.eye(3) * 1e-4, (n, 1, 1)), np.eye(3)[None] * 1e-8
        ]),
        sighting_pairs=none,
        sighting_offsets=none,
        sighting_covariances=none,
        prior_index=np.zeros(1, np.int64),
        prior_poses=np.zeros((1, 3)),
        prior_sds=np.full((1, 3), 0.01),
    )  # fmt: skip
    state, factors = assemble(problem)
    odometry = factors._replace(pairs=chain, measured=measured, tags_from=n)
    drifted = along_tree(state, odometry)
    assert abs(wrap_array(drifted[-1:, 2] - truth[-1].theta)[0]) > 0.5
    for start in (drifted, problem.poses):
        solution = solve(replace(problem, poses=start), max_iterations=100)
        assert solution.chi2 < 2.0 * n
        np.testing.assert_allclose(solution.poses[-1], truth[-1].as_array(), atol=2e-3)


def test_tags_find_their_places_from_a_scrambled_start(graphs):
    rng = np.random.default_rng(52)
    true_poses, true_tags = graphs.truth_of(rng, 30, 10)
    problem = graphs.measured(rng, true_poses, true_tags, noise=0.2)
    best = solve(problem, kernel_sd=1e9, max_iterations=100)
    for _ in range(5):
        scrambled = np.column_stack([rng.uniform(-30, 30, (30, 2)), rng.uniform(-pi, pi, 30)])
        start = replace(problem, poses=scrambled, tags=rng.uniform(-30, 30, (10, 2)))
        assert solve(start, kernel_sd=1e9, max_iterations=100).chi2 == pytest.approx(best.chi2, rel=1e-6)


@pytest.mark.parametrize("seed", range(3))
def test_edges_that_measure_only_some_directions_leave_an_optimum(graphs, seed):
    """No heading, or only one axis, where other edges make up for it: from the truth and from a bad start."""
    rng = np.random.default_rng([53, seed])
    problem, _ = graphs.city(rng, 120)
    information = np.linalg.inv(problem.edge_covariances)
    information[119::3, 2, :] = information[119::3, :, 2] = 0.0
    information[120::3] = np.diag([400.0, 0.0, 1000.0])
    singular = replace(problem, edge_information=information)
    best = solve(singular, max_iterations=100)
    assert not best.notes
    for name, start in bad_starts(rng, problem).items():
        found = solve(replace(singular, poses=start), max_iterations=100)
        assert found.chi2 == pytest.approx(best.chi2, rel=1e-5), name


def test_a_direction_that_nothing_measures_is_noted_and_survived():
    """Two poses of which only the distance ahead was measured: the second's heading stays what it was."""
    none = np.zeros(0)
    problem = GraphProblem(
        poses=np.array([[0.0, 0.0, 0.0], [0.5, 0.2, 0.7]]),
        tags=none,
        edge_pairs=np.array([[0, 1], [0, 1]]),
        edge_poses=np.array([[1.0, 0.0, 0.0], [2.0, 1.0, 0.0]]),
        edge_covariances=none,
        edge_information=np.array([np.diag([100.0, 0.0, 0.0]), [[50.0, 50, 0], [50, 50, 0], [0, 0, 0]]]),
        sighting_pairs=none,
        sighting_offsets=none,
        sighting_covariances=none,
        prior_index=np.zeros(1, np.int64),
        prior_poses=np.zeros((1, 3)),
        prior_sds=np.full((1, 3), 0.01),
    )
    solution = solve(problem)
    np.testing.assert_allclose(solution.poses[1], [1.0, 2.0, 0.7], atol=1e-6)
    ahead = replace(problem, edge_information=problem.edge_information * [[[1.0]], [[0.0]]])
    survived = solve(ahead)
    assert survived.poses[1, 0] == pytest.approx(1.0, abs=1e-6)
    assert survived.poses[1, 1] == pytest.approx(0.2, abs=1e-3)
    indefinite = replace(problem, edge_information=-problem.edge_information)
    with pytest.raises(GraphError, match=r"edge_information\[0\] is not positive semidefinite"):
        solve(indefinite)


@pytest.mark.data
@pytest.mark.parametrize(
    ("name", "optimum"), [("intel", 44.4178), ("M3500", 146.0767), ("city10000", 511.9852)]
)
@pytest.mark.parametrize("start", ["given", "none", "scrambled"])
def test_public_graphs_reach_their_optimum_from_any_start(tmp_path, name, optimum, start):
    path = REAL / f"{name}.g2o"
    if not path.exists():
        pytest.skip(f"the public pose graph {path.name} is not at hand")
    if start == "none":
        edges = tmp_path / "edges.g2o"
        lines = path.read_text().splitlines(keepends=True)
        edges.write_text("".join(line for line in lines if line.startswith("EDGE")))
        path = edges
    graph = g2o.read(path)
    problem, notes = graph.problem()
    assert not notes
    if start == "scrambled":
        rng = np.random.default_rng(54)
        n = len(graph.poses)
        problem = replace(
            problem, poses=np.column_stack([rng.uniform(-99, 99, (n, 2)), rng.uniform(-pi, pi, n)])
        )
    solution = solve(problem, max_iterations=100)
    assert graph.chi2(solution.poses) == pytest.approx(optimum, rel=1e-4)
