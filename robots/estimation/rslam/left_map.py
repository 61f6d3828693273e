"""The map of nodes that a robot leaves in memories: a batch solve of all that it measured itself.

A particle filter's map claims too much: resampling forgets how else its frame might lie, and errors of ranges
that come back with every visit count as news. The batch knows both. Each solve begins where the one before
ended, so that it stays in one valley from the known start on, whatever the filter did.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from robots.config import AgentConfig
from robots.estimation.anchor_log import AnchorLog
from robots.estimation.graph.problem import GraphError
from robots.estimation.ranges.smoothing import RangeSolution, smooth_ranges
from robots.estimation.ranges.views import as_sightings, views_of
from robots.estimation.rslam.places import vote
from robots.estimation.tag_graph.graph import graph_problem
from robots.graph_report import GraphReport
from robots.se2 import Array, Pose2
from robots.tags.map_memory import TagBelief, WriterMap

_GROWN = 1.3  # times as many anchors as at the last solve: then it is due again
_FEWEST = 5  # anchors
_VOTES = 40  # ranges of a node that look for its place
_LEAST_SD_M = 0.02  # of a place


class LeftMap:
    """What is left in memories, solved anew as the log grows."""

    def __init__(self, config: AgentConfig, start: Pose2) -> None:
        self._config = config
        self._poses = [start]
        self._tags: dict[str, tuple[float, float]] = {}
        self._offsets: dict[str, float] = {}
        self._scale = 1.0
        self._beliefs: tuple[TagBelief, ...] = ()
        self._frame: tuple[float, ...] = ()

    def is_due(self, log: AnchorLog) -> bool:
        """Tell whether the log has grown so much that another solve is worth its time."""
        return log.newest >= max(_FEWEST, _GROWN * (len(self._poses) - 1))

    def solve(self, log: AnchorLog) -> None:
        """Solve everything in the log; where it cannot be solved the last map stays."""
        self._extend(log)
        self._place(log)
        report = log.report(self._poses, self._tags, self._scale, self._offsets)
        if not len(report.range_pairs):
            return
        radio = self._config.rslam
        report = replace(report, range_scale_sd=radio.scale_sd, range_offset_sd_m=radio.offset_sd_m)
        links_from = len(report.edge_pairs) + len(report.sighting_pairs)
        try:
            found = smooth_ranges(
                graph_problem(as_sightings(report)),
                views_of(report, links_from),
                self._config.graph.tag_kernel_sd,
            )
        except GraphError:
            return
        self._keep(report, found)

    def map(self, writer: str, revision: int) -> WriterMap:
        """Return the map as it is left; without beliefs before the first solve."""
        return WriterMap(writer, revision, self._beliefs, self._frame)

    def _extend(self, log: AnchorLog) -> None:
        for edge in log.edges[len(self._poses) - 1 :]:
            self._poses.append(self._poses[-1] @ edge.mean)

    def _place(self, log: AnchorLog) -> None:
        """Look for the places of nodes that have none yet."""
        for tag_id, rows in log.ranges_by_tag().items():
            if tag_id in self._tags:
                continue
            kept = np.unique(np.linspace(0, len(rows) - 1, _VOTES).astype(int))
            places = np.array(
                [(self._poses[rows[k][0]] @ Pose2(*rows[k][1][:3])).as_array()[:2] for k in kept]
            )
            ranges = np.array([rows[k][1][3] for k in kept])
            shares = np.array([rows[k][1][4] / rows[k][1][3] for k in kept])
            noises = np.column_stack([np.zeros(len(kept)), shares])
            radio = self._config.rslam
            found = vote(places, ranges, noises, (self._scale, radio.scale_sd), radio.offset_sd_m)
            if found:
                self._tags[tag_id] = found[0].x_m, found[0].y_m

    def _keep(self, report: GraphReport, found: RangeSolution) -> None:
        self._poses = [Pose2.from_array(row) for row in found.graph.poses]
        self._tags = dict(zip(report.tag_ids, map(tuple, found.graph.tags.tolist()), strict=True))
        self._offsets = dict(zip(report.tag_ids, found.offsets_m.tolist(), strict=True))
        self._scale = float(found.scales[0])
        count, first = len(report.tag_ids), len(found.graph.poses)
        joint = found.solution.marginals.joint(first + np.arange(count))
        rows = np.arange(3 * count).reshape(-1, 3)[:, :2].ravel()
        spread = parted(found.graph.tags, joint[np.ix_(rows, rows)])
        self._beliefs = tuple(
            TagBelief(tag_id, float(x), float(y), float(c[0, 0]), float(c[0, 1]), float(c[1, 1]))
            for tag_id, (x, y), c in zip(report.tag_ids, found.graph.tags, spread.places, strict=True)
        )
        self._frame = tuple(spread.frame[np.triu_indices(3)].tolist())


@dataclass(frozen=True, slots=True)
class Parted:
    """A covariance in parts: of the frame (x, y, turn), (3, 3), and of each place in it, (k, 2, 2)."""

    frame: Array
    places: Array


def parted(places: Array, covariance: Array) -> Parted:
    """Part the covariance (2k, 2k) of places (k, 2) into that of a motion of all and what is left of each."""
    count = len(places)
    by_node = np.zeros((count, 2, 3))
    by_node[:, 0, 0] = by_node[:, 1, 1] = 1.0
    by_node[:, 0, 2], by_node[:, 1, 2] = -places[:, 1], places[:, 0]
    rigid = by_node.reshape(-1, 3)
    least = _LEAST_SD_M**2 * np.eye(2)
    own = [covariance[k : k + 2, k : k + 2] + least for k in range(0, 2 * count, 2)]
    weighted = np.linalg.solve(np.array(own), by_node).reshape(-1, 3).T
    taken = np.linalg.pinv(weighted @ rigid, hermitian=True) @ weighted
    left = np.eye(2 * count) - rigid @ taken
    rest = left @ covariance @ left.T
    blocks = [rest[k : k + 2, k : k + 2] + least for k in range(0, 2 * count, 2)]
    return Parted(taken @ covariance @ taken.T, np.array(blocks))
