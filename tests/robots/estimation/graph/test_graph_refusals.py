"""Graphs that cannot be solved: which part is at fault is said, and no wrong answer given."""

from dataclasses import replace

import numpy as np
import pytest

from robots.estimation.graph.solve import GraphError, GraphProblem, solve


def changed(problem: GraphProblem, name: str, at: tuple[int, ...], value: float) -> GraphProblem:
    array = np.array(getattr(problem, name))
    array[at] = value
    return replace(problem, **{name: array})


@pytest.mark.parametrize(
    ("name", "at", "value", "message"),
    [
        ("poses", (1, 0), np.nan, "poses holds a value that is not finite"),
        ("tags", (0, 1), np.inf, "tags holds a value that is not finite"),
        ("edge_poses", (2, 2), np.nan, "edge_poses holds a value that is not finite"),
        ("edge_covariances", (0, 1, 1), np.nan, "edge_covariances holds a value that is not finite"),
        ("sighting_offsets", (0, 0), -np.inf, "sighting_offsets holds a value that is not finite"),
        ("sighting_covariances", (1, 0, 0), np.nan, "sighting_covariances holds a value that is not finite"),
        ("edge_covariances", (2, 0, 0), -1.0, r"edge_covariances\[2\] is not positive definite"),
        ("sighting_covariances", (1, 1, 1), 0.0, r"sighting_covariances\[1\] is not positive definite"),
        ("edge_pairs", (1, 1), 99, "edge_pairs names a vertex that does not exist"),
        ("edge_pairs", (0, 0), -1, "edge_pairs names a vertex that does not exist"),
        ("sighting_pairs", (0, 0), 6, "sighting_pairs names a vertex that does not exist"),
        ("sighting_pairs", (0, 1), 2, "sighting_pairs names a vertex that does not exist"),
        ("prior_index", (0,), 6, "prior_index names a vertex that does not exist"),
        ("heading_index", (0,), 6, "heading_index names a vertex that does not exist"),
        ("prior_poses", (0, 2), np.nan, "prior_poses holds a value that is not finite"),
        ("prior_sds", (0, 2), np.nan, "prior_sds"),
        ("prior_sds", (0, 0), 0.0, "prior_sds"),
        ("heading_rad", (1,), np.nan, "heading_rad holds a value that is not finite"),
        ("heading_sd_rad", (1,), 0.0, "heading_sd_rad"),
    ],
)  # fmt: skip
def test_what_cannot_be_solved_is_named(graphs, name, at, value, message):
    rng = np.random.default_rng(8)
    problem = graphs.measured(rng, *graphs.truth_of(rng, 6, 2))
    solve(problem)
    with pytest.raises(GraphError, match=message):
        solve(changed(problem, name, at, value))


def test_a_graph_that_nothing_holds_is_named(graphs):
    rng = np.random.default_rng(9)
    problem = graphs.measured(rng, *graphs.truth_of(rng, 6, 2))
    free = replace(
        problem,
        prior_index=np.zeros(0, np.int64),
        prior_poses=np.zeros((0, 3)),
        prior_sds=np.zeros((0, 3)),
    )
    with pytest.raises(GraphError, match="at least one prior"):
        solve(free)


@pytest.mark.parametrize("method", ["gauss-newton", "linear"])
def test_a_pose_and_a_tag_that_nothing_is_joined_to_are_named(graphs, method):
    rng = np.random.default_rng(9)
    problem = graphs.measured(rng, *graphs.truth_of(rng, 6, 2))
    lonely_pose = replace(problem, poses=np.vstack([problem.poses, [9.0, 9.0, 0.0]]))
    lonely_tag = replace(problem, tags=np.vstack([problem.tags, [9.0, 9.0]]))
    for alone in (lonely_pose, lonely_tag):
        with pytest.raises(GraphError, match="no measurement or prior holds in place"):
            solve(alone, method)


def test_two_halves_of_which_only_one_is_held_are_named(graphs):
    rng = np.random.default_rng(9)
    problem = graphs.measured(rng, *graphs.truth_of(rng, 6, 2), headings=False)
    pair = np.array([[6, 7]])
    halves = replace(
        problem,
        poses=np.vstack([problem.poses, [[9.0, 9.0, 0.0], [10.0, 9.0, 0.0]]]),
        edge_pairs=np.vstack([problem.edge_pairs, pair]),
        edge_poses=np.vstack([problem.edge_poses, [[1.0, 0.0, 0.0]]]),
        edge_covariances=np.concatenate([problem.edge_covariances, np.eye(3)[None] * 0.01]),
    )
    with pytest.raises(GraphError, match="no measurement or prior holds in place"):
        solve(halves)
