"""The best map: one batch solve of everything a robot recorded, with loops closed wherever it came by again.

While a robot drives, loops are closed at tags alone: there the id says which place it is. Once the graph is
solved it says so everywhere, and the surroundings of any two vertices near each other can be matched.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import sqrt

import numpy as np
from scipy.spatial import cKDTree

from robots.config import AgentConfig
from robots.estimation.graph.solve import GraphSolution
from robots.estimation.ranges.smoothing import smooth_ranges
from robots.estimation.ranges.views import as_sightings, views_of
from robots.estimation.scans.loop_closing import Loop, LoopCloser
from robots.estimation.tag_graph.graph import graph_problem, solve_report
from robots.graph_report import GraphReport
from robots.se2 import GaussianPose, Pose2

_NEAR_M = 2.5  # vertices so near to each other see much the same
_NEIGHBOURS = 6  # of each vertex: more say the same again
# No tag vouches for the place here, and places look alike (at MIT one such loop bent the map by metres).
_SURE_OVERLAP, _SURE_MARGIN = 0.9, 0.3
_CERTAIN_SD_M = 1.5  # a pair that the graph knows less well may be any two places that look alike


def smooth(report: GraphReport, loops: LoopCloser, config: AgentConfig) -> GraphReport:
    """Return the graph with its loops closed everywhere, solved robustly; as it was where nothing is solved.

    Raises:
        GraphError: it cannot be solved; the message says why.
    """
    if config.slam != "tag-graph" or config.poses != "slam":
        return report
    solution = solve_report(report, config.graph)
    if config.loops.laser:
        report = _with_loops(report, list(_loops_everywhere(report, solution, loops)))
        solution = solve_report(report, config.graph)
    return smooth_radio(replace(report, poses=solution.poses, tags=solution.tags), config)


def smooth_radio(report: GraphReport, config: AgentConfig) -> GraphReport:
    """Return the graph of a filter over radio tags as a batch solve of its ranges has it.

    Raises:
        GraphError: it cannot be solved; the message says why.
    """
    if not len(report.range_pairs) or config.poses != "slam":
        return report
    links_from = len(report.edge_pairs) + len(report.loop_pairs) + len(report.sighting_pairs)
    graph = graph_problem(as_sightings(report))
    solution = smooth_ranges(graph, views_of(report, links_from), config.graph.tag_kernel_sd)
    return replace(
        report,
        poses=solution.graph.poses,
        tags=solution.graph.tags,
        range_scale=float(solution.scales[0]),
        range_offsets_m=solution.offsets_m,
    )


def _loops_everywhere(report: GraphReport, solution: GraphSolution, loops: LoopCloser) -> Iterator[Loop]:
    """Yield a loop for each vertex and those near it that were passed at another time."""
    known = {(int(i), int(j)) for i, j in report.loop_pairs}
    places = solution.poses[:, :2]
    tree = cKDTree(places)
    for later in range(len(places)):
        near = sorted(tree.query_ball_point(places[later], _NEAR_M))
        near.sort(key=lambda i: float(np.hypot(*(places[i] - places[later]))))
        earlier = [i for i in near if i < later and loops.apart(i, later)]
        for i in earlier[:_NEIGHBOURS]:
            if (i, later) in known:
                continue
            between = Pose2.from_array(solution.poses[i]).between(Pose2.from_array(solution.poses[later]))
            belief = GaussianPose(between, solution.marginals.relative(i, later))
            if sqrt(float(np.linalg.eigvalsh(belief.covariance[:2, :2])[1])) > _CERTAIN_SD_M:
                continue
            match = loops.match(i, later, belief)
            if match is not None and match.overlap >= _SURE_OVERLAP and match.margin >= _SURE_MARGIN:
                yield Loop(i, later, match.pose)


def _with_loops(report: GraphReport, loops: list[Loop]) -> GraphReport:
    if not loops:
        return report
    pairs = np.array([(loop.earlier, loop.later) for loop in loops], np.int64)
    poses = np.array([loop.earlier_from_later.mean.as_array() for loop in loops])
    covariances = np.array([loop.earlier_from_later.covariance for loop in loops])
    return replace(
        report,
        loop_pairs=np.concatenate([report.loop_pairs, pairs]),
        loop_poses=np.concatenate([report.loop_poses, poses]),
        loop_covariances=np.concatenate([report.loop_covariances, covariances]),
    )
