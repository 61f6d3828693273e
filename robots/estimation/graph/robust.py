"""Which robust edges of a graph to believe, where a descent alone would be caught between them.

The graph is grown pose after pose; each edge is held against the covariance of what all earlier ones say of
it before it may bend anything (``graph_checks.innovation``). Drift is known to be large where it is large: a
right loop far off passes, a wrong one nearby does not.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from robots.estimation.graph.factors import BoolArray
from robots.estimation.graph.incremental import IncrementalGraph
from robots.estimation.graph.problem import GraphError, GraphProblem
from robots.se2 import Pose2


def believed(problem: GraphProblem, kernel_sd: float) -> BoolArray:
    """Return which edges (k,) are believed once all are in; those not robust always are."""
    robust = np.zeros(len(problem.edge_pairs), np.bool_)
    if problem.edge_robust is not None:
        robust |= problem.edge_robust
    pairs, measured = problem.edge_pairs.tolist(), problem.edge_poses.tolist()
    edges: list[list[int]] = [[] for _ in problem.poses]
    for k, pair in enumerate(pairs):
        edges[max(pair)].append(k)
    sightings: list[list[int]] = [[] for _ in problem.poses]
    for k, (i, _) in enumerate(problem.sighting_pairs.tolist()):
        sightings[i].append(k)
    graph, tags, added = IncrementalGraph(kernel_sd), dict[int, int](), list[int]()
    priors: dict[int, list[int]] = {}
    for p, index in enumerate(problem.prior_index.tolist()):
        priors.setdefault(index, []).append(p)
    headings = dict(zip(problem.heading_index.tolist(), range(len(problem.heading_index)), strict=True))
    for n, given in enumerate(problem.poses):
        graph.add_pose(_begin(graph, n, given, [k for k in edges[n] if not robust[k]], pairs, measured))
        for p in priors.get(n, []):
            graph.add_prior(n, problem.prior_poses[p], problem.prior_sds[p])
        if n in headings:
            h = headings[n]
            graph.add_heading(n, float(problem.heading_rad[h]), float(problem.heading_sd_rad[h]))
        for k in edges[n]:
            information, covariance = None, None
            if problem.edge_information is not None:
                information = problem.edge_information[k]
            else:
                covariance = problem.edge_covariances[k]
            i, j = pairs[k]
            graph.add_edge(i, j, measured[k], covariance, information, bool(robust[k]))
            added.append(k)
        for k in sightings[n]:
            tag = int(problem.sighting_pairs[k, 1])
            if tag not in tags:
                here = Pose2.from_array(graph.pose(n))
                tags[tag] = graph.add_tag(here.transform_point(*problem.sighting_offsets[k].tolist()))
            graph.add_sighting(n, tags[tag], problem.sighting_offsets[k], problem.sighting_covariances[k])
        try:
            graph.update()
        except GraphError:  # not joined to what is held yet; a later pose may join it
            continue
    weights = np.ones(len(pairs))
    weights[added] = graph.edge_weights
    found: BoolArray = ~robust | (weights > 0.5)
    return found


def only(problem: GraphProblem, kept: BoolArray) -> GraphProblem:
    """Return the graph with the edges that are ``kept`` (k,), none of them robust any more."""
    information = problem.edge_information
    return replace(
        problem,
        edge_pairs=problem.edge_pairs[kept],
        edge_poses=problem.edge_poses[kept],
        edge_covariances=problem.edge_covariances[kept] if information is None else problem.edge_covariances,
        edge_information=None if information is None else information[kept],
        edge_robust=None,
    )


def _begin(
    graph: IncrementalGraph,
    n: int,
    given: np.ndarray,
    trusted: list[int],
    pairs: list[list[int]],
    measured: list[list[float]],
) -> np.ndarray:
    """Return where pose n starts: at the end of a trusted edge from an earlier one, else as given."""
    for k in trusted:
        i, j = pairs[k]
        step = Pose2.from_array(np.array(measured[k]))
        if i < n:
            return (Pose2.from_array(graph.pose(i)) @ step).as_array()
        if j < n:
            return (Pose2.from_array(graph.pose(j)) @ step.inverse()).as_array()
    return given
