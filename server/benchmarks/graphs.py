"""Pose graphs solved at once and as they grow, beside GTSAM in alternating runs where it is installed.

All covariances are timed beside single ones, and beside GTSAM's.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec
from statistics import median
from time import perf_counter
from typing import Any

import numpy as np

from robots.datasets import g2o
from robots.estimation.graph.incremental import IncrementalGraph
from robots.estimation.graph.problem import GraphProblem
from robots.estimation.graph.solve import solve as solve_graph
from robots.se2 import Array, Pose2

gtsam: Any = import_module("gtsam") if find_spec("gtsam") else None  # the rival is no dependency

_RUNS = 5
_SMALL_S = 0.5  # graphs that take less are solved many times for a median
_TOLERANCE = 1e-6  # of chi2
_ABSENT = "not installed"


def solve(graph: g2o.PoseGraph, name: str) -> dict[str, Any]:
    """Return the times of batch solutions, structure building included, and chi2; medians of several runs."""
    problem, _ = graph.problem()

    def ours() -> Array:
        return solve_graph(problem, max_iterations=100, tolerance=_TOLERANCE).poses

    first, ours_s, rival, rival_s = ours(), [], None, []
    make = None if gtsam is None else _batch_rival(graph)
    runs = max(_RUNS, min(200, int(_SMALL_S / _timed(ours)[0])))
    for _ in range(runs):
        ours_s.append(_timed(ours)[0])
        if make is not None:
            seconds, rival = _timed(make)
            rival_s.append(seconds)
    result: dict[str, Any] = {
        "graph": name,
        "vertices": len(graph.ids),
        "edges": len(graph.pairs),
        "solve_ms": 1e3 * median(ours_s),
        "chi2": graph.chi2(first),
    }
    if rival is None:
        return result | _covariances(problem, None) | {"gtsam": _ABSENT}
    result |= {
        "gtsam_ms": 1e3 * median(rival_s),
        "gtsam_chi2": graph.chi2(rival),
        "times_faster": median(rival_s) / median(ours_s),
    }
    return result | _covariances(problem, graph)


def _covariances(problem: GraphProblem, rival: g2o.PoseGraph | None) -> dict[str, Any]:
    """Return the times of the covariances of all vertices: at once, one by one, and GTSAM's."""
    solution = solve_graph(problem, max_iterations=100, tolerance=_TOLERANCE)
    marginals, few = solution.marginals, range(0, len(problem.poses), -(-len(problem.poses) // 50))
    marginals.all()  # compiles, and factorises once for both
    at_once = min(_timed(marginals.all)[0] for _ in range(_RUNS))
    single = min(_timed(lambda: np.array([marginals.of(k) for k in few]))[0] for _ in range(2)) / len(few)
    result = {"covariances_ms": 1e3 * at_once, "covariances_one_by_one_ms": 1e3 * single * len(problem.poses)}
    if rival is None:
        return result
    factors, values = _batch_graph(rival)
    for k, pose in enumerate(solution.poses):
        values.update(k, gtsam.Pose2(*pose))

    def theirs() -> Array:
        found = gtsam.Marginals(factors, values)
        return np.array([found.marginalCovariance(k) for k in range(len(solution.poses))])

    return result | {"gtsam_covariances_ms": 1e3 * _timed(theirs)[0]}


def small(seed: int = 1) -> g2o.PoseGraph:
    """Return a graph of 50 vertices and 200 edges: a walk in a square, and what lies near each other."""
    rng = np.random.default_rng(seed)
    count, edges = 50, 200
    places = np.column_stack([rng.uniform(0.0, 20.0, (count, 2)), rng.uniform(-np.pi, np.pi, count)])
    away = np.linalg.norm(places[:, None, :2] - places[None, :, :2], axis=2)
    near = np.argwhere(np.triu(np.ones((count, count), bool), 2))
    near = near[np.argsort(away[near[:, 0], near[:, 1]], kind="stable")][: edges - count + 1]
    pairs = np.vstack([np.column_stack([np.arange(count - 1), np.arange(1, count)]), near]).astype(np.int64)
    true = [Pose2.from_array(place) for place in places]
    sds = np.array([0.05, 0.05, 0.02])
    measured = np.array([true[i].between(true[j]).as_array() for i, j in pairs])
    measured += sds * rng.standard_normal(measured.shape)
    poses = places + (0.3, 0.3, 0.1) * rng.standard_normal(places.shape)
    information = np.tile(np.diag(sds**-2.0), (len(pairs), 1, 1))
    return g2o.PoseGraph(tuple(range(count)), poses, pairs, measured, information, (), ())


def incremental(graph: g2o.PoseGraph, name: str) -> dict[str, Any]:
    """Return the times of a graph grown pose by pose with all edges to earlier ones, each time updated."""
    by_pose: list[list[int]] = [[] for _ in graph.ids]
    for k, pair in enumerate(graph.pairs.tolist()):
        by_pose[max(pair)].append(k)
    few = min(len(by_pose), 50)
    _grow(graph, by_pose[:few])  # compiles
    steps, poses = _grow(graph, by_pose)
    result: dict[str, Any] = {
        "graph": name,
        "total_s": float(steps.sum()),
        "step_ms_p50": 1e3 * float(np.median(steps)),
        "step_ms_p99": 1e3 * float(np.percentile(steps, 99)),
        "chi2": graph.chi2(poses),
    }
    if gtsam is None:
        return result | {"isam2": _ABSENT}
    rival, poses = _grow_rival(graph, by_pose)
    return result | {
        "isam2_total_s": float(rival.sum()),
        "isam2_step_ms_p50": 1e3 * float(np.median(rival)),
        "isam2_chi2": graph.chi2(poses),
        "times_faster": float(rival.sum() / steps.sum()),
    }


def _timed(call: Callable[[], Array]) -> tuple[float, Array]:
    began = perf_counter()
    found = call()
    return perf_counter() - began, found


def _grow(graph: g2o.PoseGraph, by_pose: list[list[int]]) -> tuple[Array, Array]:
    pairs, measured, information = graph.pairs.tolist(), graph.measured.tolist(), list(graph.information)
    growing, steps = IncrementalGraph(), np.empty(len(by_pose))
    for n, edges in enumerate(by_pose):
        began = perf_counter()
        growing.add_pose(_begin(growing.pose, graph, n, edges))
        if not edges:
            growing.add_prior(n, graph.poses[n], np.full(3, 1e-6))
        for k in edges:
            i, j = pairs[k]
            growing.add_edge(i, j, measured[k], information=information[k])
        growing.update()
        steps[n] = perf_counter() - began
    return steps, growing.poses


def _begin(pose: Callable[[int], Array], graph: g2o.PoseGraph, n: int, edges: list[int]) -> Array:
    """Return where a pose starts: at the end of the edge from the newest of those before it."""
    best = max(edges, key=lambda k: min(graph.pairs[k]), default=-1)
    if best < 0:
        return np.asarray(graph.poses[n])
    i, j = graph.pairs[best].tolist()
    step = Pose2.from_array(graph.measured[best])
    return (Pose2.from_array(pose(min(i, j))) @ (step if i < j else step.inverse())).as_array()


def _noise(information: Array) -> Any:
    return gtsam.noiseModel.Gaussian.Information(information)


def _batch_graph(graph: g2o.PoseGraph) -> tuple[Any, Any]:
    factors, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
    for (i, j), z, information in zip(graph.pairs.tolist(), graph.measured, graph.information, strict=True):
        factors.add(gtsam.BetweenFactorPose2(i, j, gtsam.Pose2(*z), _noise(information)))
    for k, pose in enumerate(graph.poses):
        values.insert(k, gtsam.Pose2(*pose))
    hold = gtsam.noiseModel.Isotropic.Sigma(3, 1e-6)
    factors.add(gtsam.PriorFactorPose2(0, gtsam.Pose2(*graph.poses[0]), hold))
    return factors, values


def _batch_rival(graph: g2o.PoseGraph) -> Callable[[], Array]:
    factors, values = _batch_graph(graph)

    def run() -> Array:
        return _poses(gtsam.GaussNewtonOptimizer(factors, values).optimize(), len(graph.poses))

    return run


def _grow_rival(graph: g2o.PoseGraph, by_pose: list[list[int]]) -> tuple[Array, Array]:
    pairs = graph.pairs.tolist()
    measured = [gtsam.Pose2(*z) for z in graph.measured]
    noise = [_noise(information) for information in graph.information]
    hold = gtsam.noiseModel.Isotropic.Sigma(3, 1e-6)
    growing, steps = gtsam.ISAM2(gtsam.ISAM2Params()), np.empty(len(by_pose))

    def pose(k: int) -> Array:
        found = growing.calculateEstimatePose2(k)
        return np.array([found.x(), found.y(), found.theta()])

    for n, edges in enumerate(by_pose):
        began = perf_counter()
        factors, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
        values.insert(n, gtsam.Pose2(*_begin(pose, graph, n, edges)))
        if not edges:
            factors.add(gtsam.PriorFactorPose2(n, gtsam.Pose2(*graph.poses[n]), hold))
        for k in edges:
            i, j = pairs[k]
            factors.add(gtsam.BetweenFactorPose2(i, j, measured[k], noise[k]))
        growing.update(factors, values)
        steps[n] = perf_counter() - began
    return steps, _poses(growing.calculateEstimate(), len(graph.poses))


def _poses(values: Any, count: int) -> Array:
    found = (values.atPose2(k) for k in range(count))
    return np.array([(pose.x(), pose.y(), pose.theta()) for pose in found])
