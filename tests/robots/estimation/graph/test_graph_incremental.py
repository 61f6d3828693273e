"""The graph solved as it grows: what a batch solution says, whichever way it grew."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robots.estimation.graph.incremental import IncrementalGraph
from robots.estimation.graph.problem import LOOSE
from robots.estimation.graph.solve import GraphError, GraphProblem, solve
from robots.se2 import Pose2, wrap_array
from robots.snapshot import freeze, thaw


def grown(problem: GraphProblem, groups: list[int], **options: float) -> IncrementalGraph:
    """The problem, pose after pose; an update wherever ``groups`` end, and at the end."""
    graph = IncrementalGraph(**options)
    tags: dict[int, int] = {}
    added: list[int] = []
    for n, pose in enumerate(problem.poses):
        graph.add_pose(pose)
        for index, value, sds in zip(
            problem.prior_index, problem.prior_poses, problem.prior_sds, strict=True
        ):
            if index == n:
                graph.add_prior(n, value, sds)
        for index, rad, sd in zip(
            problem.heading_index, problem.heading_rad, problem.heading_sd_rad, strict=True
        ):
            if index == n:
                graph.add_heading(n, rad, sd)
        for k, ((i, j), z, covariance) in enumerate(
            zip(problem.edge_pairs, problem.edge_poses, problem.edge_covariances, strict=True)
        ):
            robust = problem.edge_robust is not None and bool(problem.edge_robust[k])
            if max(i, j) == n:
                added.append(k)
                graph.add_edge(int(i), int(j), z, covariance, robust=robust)
        for (i, k), z, covariance in zip(
            problem.sighting_pairs, problem.sighting_offsets, problem.sighting_covariances, strict=True
        ):
            if i == n:
                if k not in tags:
                    tags[k] = graph.add_tag(problem.tags[k])
                graph.add_sighting(n, tags[k], z, covariance)
        if n in groups:
            graph.update()
    graph.update()
    # edges and tags as the problem numbers them
    graph.edge_order = np.argsort(added)
    graph.order = [tags[k] for k in range(len(problem.tags))]
    return graph


def assert_same(graph: IncrementalGraph, problem: GraphProblem, atol: float) -> None:
    best = solve(problem, max_iterations=100)
    np.testing.assert_allclose(graph.poses[:, :2], best.poses[:, :2], atol=atol)
    np.testing.assert_allclose(wrap_array(graph.poses[:, 2] - best.poses[:, 2]), 0.0, atol=atol)
    np.testing.assert_allclose(graph.tags[graph.order], best.tags, atol=atol)


def walk(rng: np.random.Generator, count: int, noise: float = 1.0) -> tuple[GraphProblem, np.ndarray]:
    """Through the streets of a grid past tags on its corners, and laser loops; starts are odometry's."""
    here, truth = Pose2(), [Pose2()]
    for _ in range(count - 1):
        here = here @ Pose2(1.0, 0.0, float(rng.choice([0.0, 0.0, pi / 2, -pi / 2])))
        if max(abs(here.x), abs(here.y)) > 4.0:
            here = truth[-1] @ Pose2(0.0, 0.0, pi / 2)
        truth.append(here)
    pairs = [(k, k + 1) for k in range(count - 1)]
    seen: list[tuple[int, int]] = []
    corner: dict[tuple[int, int], int] = {}
    last: dict[tuple[int, int], int] = {}
    for k, pose in enumerate(truth):
        at = (round(pose.x), round(pose.y))
        if (at[0] + at[1]) % 3 == 0:
            seen.append((k, corner.setdefault(at, len(corner))))
        elif at in last and k - last[at] > 5:
            pairs.append((last[at], k))
        last[at] = k
    sd = np.array([0.03, 0.03, 0.02])
    measured = np.array([truth[i].between(truth[j]).as_array() for i, j in pairs])
    measured += noise * sd * rng.standard_normal(measured.shape)
    poses = [truth[0]]
    for k in range(count - 1):
        poses.append(poses[-1] @ Pose2.from_array(measured[k]))
    places = np.array([(x, y) for x, y in corner], float).reshape(-1, 2)
    offsets = np.array([
        truth[i].inverse().transform(places[k][None])[0] for i, k in seen
    ]).reshape(-1, 2)  # fmt: skip
    first = {}
    for i, k in reversed(seen):
        first[k] = poses[i].transform_point(*offsets[seen.index((i, k))])
    return GraphProblem(
        poses=np.array([pose.as_array() for pose in poses]),
        tags=np.array([first[k] for k in range(len(places))]).reshape(-1, 2),
        edge_pairs=np.array(pairs),
        edge_poses=measured,
        edge_covariances=np.tile(np.diag(sd**2), (len(pairs), 1, 1)),
        sighting_pairs=np.array(seen, np.int64).reshape(-1, 2),
        sighting_offsets=offsets + noise * 0.03 * rng.standard_normal(offsets.shape),
        sighting_covariances=np.tile(np.eye(2) * 0.03**2, (len(seen), 1, 1)),
        prior_index=np.zeros(1, np.int64),
        prior_poses=np.zeros((1, 3)),
        prior_sds=np.full((1, 3), 0.01),
        edge_robust=np.abs(np.array(pairs) @ [1, -1]) > 1,
    ), np.array([pose.as_array() for pose in truth])


@pytest.mark.parametrize("seed", range(4))
def test_growing_ends_near_the_batch_solution_and_settles_on_it(seed):
    problem, _ = walk(np.random.default_rng([70, seed]), 150)
    graph = grown(problem, list(range(150)))
    best = solve(problem, max_iterations=100)
    assert graph.chi2 < 1.02 * (np.sum(best.edge_residuals**2) + np.sum(best.sighting_residuals**2))
    assert_same(graph, problem, 0.03)
    graph.settle()
    assert_same(graph, problem, 1e-4)


@settings(max_examples=10, deadline=None)
@given(seed=st.integers(0, 10**6), groups=st.sets(st.integers(0, 59)))
def test_how_measurements_are_grouped_into_updates_does_not_matter(seed, groups):
    problem, _ = walk(np.random.default_rng([71, seed]), 60)
    graph = grown(problem, sorted(groups))
    graph.settle()
    assert_same(graph, problem, 1e-4)


@pytest.mark.parametrize("seed", range(3))
def test_a_noiseless_walk_is_exact(seed):
    problem, truth = walk(np.random.default_rng([72, seed]), 80, noise=0.0)
    graph = grown(problem, list(range(0, 80, 3)))
    np.testing.assert_allclose(graph.poses[:, :2], truth[:, :2], atol=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_random_graphs_with_headings_come_out_as_in_a_batch(graphs, seed):
    rng = np.random.default_rng([73, seed])
    problem = graphs.measured(rng, *graphs.truth_of(rng, 25, 6), moved=0.1)
    graph = grown(problem, list(range(25)), kernel_sd=1e9)
    graph.settle()
    best = solve(problem, kernel_sd=1e9, max_iterations=100)
    np.testing.assert_allclose(graph.poses[:, :2], best.poses[:, :2], atol=1e-4)
    for k in (0, 11, 24):
        np.testing.assert_allclose(graph.pose_covariance(k), best.pose_covariance(k), rtol=1e-3, atol=1e-9)
    for k in range(6):
        found = graph.tag_covariance(graph.order[k])
        np.testing.assert_allclose(found, best.tag_covariance(k), rtol=1e-3, atol=1e-9)
    relative = graph.relative_covariance(3, 20)
    np.testing.assert_allclose(relative, best.marginals.relative(3, 20), rtol=1e-3, atol=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_wrong_loops_and_a_moved_tag_are_let_go_on_the_way(seed):
    rng = np.random.default_rng([74, seed])
    problem, _ = walk(rng, 150)
    ends = rng.integers(0, 150, (20, 2))
    ends = ends[np.abs(ends[:, 0] - ends[:, 1]) > 5]
    wrong = np.column_stack([rng.uniform(-3, 3, (len(ends), 2)), rng.uniform(-pi, pi, len(ends))])
    offsets = problem.sighting_offsets.copy()
    offsets[40] += (1.0, 1.5)
    spoiled = replace(
        problem,
        edge_pairs=np.vstack([problem.edge_pairs, ends]),
        edge_poses=np.vstack([problem.edge_poses, wrong]),
        edge_covariances=np.concatenate([problem.edge_covariances, problem.edge_covariances[: len(ends)]]),
        edge_robust=np.concatenate([problem.edge_robust, np.ones(len(ends), np.bool_)]),
        sighting_offsets=offsets,
    )
    right = np.arange(len(offsets)) != 40
    best = solve(
        replace(
            problem,
            sighting_pairs=problem.sighting_pairs[right],
            sighting_offsets=offsets[right],
            sighting_covariances=problem.sighting_covariances[right],
        ),
        max_iterations=100,
    )
    graph = grown(spoiled, list(range(150)))
    rounds = 0
    while graph.doubt():
        rounds += 1
        assert rounds < 10
    graph.settle()
    residuals = graph.edge_residuals[graph.edge_order]
    assert np.abs(graph.poses[:, :2] - best.poses[:, :2]).max() < 0.1  # a third of a deviation
    assert residuals[len(problem.edge_pairs) :].min() > 5.0
    assert np.argmax(graph.sighting_residuals) == 40


def test_a_snapshot_goes_on_as_the_graph_would():
    problem, _ = walk(np.random.default_rng(75), 60)
    graph = grown(problem, list(range(60)))
    twin = thaw(freeze(graph), IncrementalGraph)
    for each in (graph, twin):
        each.add_edge(59, 3, (0.5, 0.2, 0.1), np.eye(3) * 0.1)
        each.update()
    assert np.array_equal(graph.poses, twin.poses)
    assert np.array_equal(graph.tags, twin.tags)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda g: g.add_pose((0.0, np.nan, 0.0)), "the pose has to be 3 finite numbers"),
        (lambda g: g.add_tag((1.0,)), "the tag has to be 2 finite numbers"),
        (lambda g: g.add_edge(0, 99, (0, 0, 0), np.eye(3)), "there is no pose 99"),
        (lambda g: g.add_edge(-1, 0, (0, 0, 0), np.eye(3)), "there is no pose -1"),
        (lambda g: g.add_edge(0, 1, (0, np.inf, 0), np.eye(3)), "the edge has to be 3 finite numbers"),
        (lambda g: g.add_edge(0, 1, (0, 0, 0), -np.eye(3)), "the covariance is not positive definite"),
        (lambda g: g.add_edge(0, 1, (0, 0, 0), np.eye(2)), "the covariance has to be 3 x 3"),
        (lambda g: g.add_edge(0, 1, (0, 0, 0)), "either a covariance or an information"),
        (
            lambda g: g.add_edge(0, 1, (0, 0, 0), information=np.diag([1.0, -1.0, 1.0])),
            "the information is not positive semidefinite",
        ),
        (lambda g: g.add_sighting(0, 77, (0, 0), np.eye(2)), "there is no tag 77"),
        (lambda g: g.add_sighting(0, 0, (0, 0), np.eye(3)), "has to be 2 x 2"),
        (lambda g: g.add_prior(0, (0, 0, 0), (1, 0, 1)), "has to be greater than 0"),
        (lambda g: g.add_heading(0, np.nan, 1.0), "the heading has to be 1 finite numbers"),
    ],
)
def test_what_is_wrong_is_refused_and_changes_nothing(call, message):
    problem, _ = walk(np.random.default_rng(76), 30)
    graph, untouched = grown(problem, [29]), grown(problem, [29])
    with pytest.raises(GraphError, match=message):
        call(graph)
    for each in (graph, untouched):
        each.add_pose((9.0, 9.0, 0.0))
        each.add_edge(29, 30, (1.0, 0.0, 0.0), np.eye(3) * 0.01)
        each.update()
    assert np.array_equal(graph.poses, untouched.poses)
    assert np.array_equal(graph.tags, untouched.tags)
    assert np.array_equal(graph.edge_residuals, untouched.edge_residuals)
    assert np.array_equal(graph.pose_covariance(30), untouched.pose_covariance(30))


def test_a_pose_that_hangs_on_nothing_is_refused_until_it_hangs():
    graph = IncrementalGraph()
    graph.add_pose((0.0, 0.0, 0.0))
    with pytest.raises(GraphError, match=LOOSE):
        graph.update()
    graph.add_prior(0, (0.0, 0.0, 0.0), (0.1, 0.1, 0.1))
    graph.update()
    graph.add_pose((1.0, 0.0, 0.0))
    graph.add_edge(1, 1, (0.0, 0.0, 0.0), np.eye(3))
    with pytest.raises(GraphError, match=LOOSE):
        graph.update()
    with pytest.raises(GraphError, match="no covariance yet"):
        graph.pose_covariance(1)
    graph.add_edge(0, 1, (1.5, 0.0, 0.0), np.eye(3) * 0.01)
    graph.update()
    np.testing.assert_allclose(graph.poses[1], (1.5, 0.0, 0.0), atol=1e-9)


def test_a_direction_that_nothing_measures_is_survived():
    graph = IncrementalGraph()
    for x in range(3):
        graph.add_pose((x, 0.2, 0.5))
    graph.add_prior(0, (0.0, 0.0, 0.0), (0.1, 0.1, 0.1))
    graph.add_edge(0, 1, (2.0, 0.0, 0.0), information=np.diag([1.0, 0.0, 0.0]))
    graph.add_edge(0, 2, (2.0, 1.0, 0.0), information=np.diag([1.0, 1.0, 0.0]))
    graph.settle()
    assert np.isfinite(graph.poses).all()
    assert graph.poses[1, 0] == pytest.approx(2.0, abs=1e-6)
    np.testing.assert_allclose(graph.poses[2], (2.0, 1.0, 0.5), atol=1e-6)
