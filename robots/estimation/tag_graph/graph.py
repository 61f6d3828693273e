"""One robot's growing tag graph.

Anchors it has passed, tags it has read, and the measurements between them.
"""

from __future__ import annotations

from math import cos, sin

import numpy as np

from robots.config import AgentConfig, GraphConfig
from robots.estimation.graph.solve import GraphProblem, GraphSolution, solve
from robots.estimation.ranges.mean import RangeMean, table
from robots.estimation.ranges.views import as_sightings
from robots.estimation.tag_filter import RangeSighting
from robots.graph_report import GraphReport
from robots.se2 import Array, GaussianPose, Pose2

_FLOOR = 1e-6  # m2 and rad2: no displacement is known better than a millimetre
_START_SD = 1e-3
_BEND_SD_RAD = 0.035  # headings of a compass are this much off for minutes at a time


class TagGraph:
    """Pose vertices in the map frame, the first at the start.

    Each next one is joined to its predecessor by an edge.
    """

    def __init__(self, config: AgentConfig, start: Pose2, stamp_s: float, yaw_rad: float | None) -> None:
        self._config = config
        self.poses: list[Pose2] = [start]
        self._stamps: list[float] = [stamp_s]
        self._yaws: list[float] = [np.nan if yaw_rad is None else yaw_rad]
        self._edges: list[tuple[int, int, GaussianPose]] = []
        self._sightings: dict[tuple[int, int], tuple[int, Array, Array]] = {}  # how many, mean place, spread
        self._loops: list[tuple[int, int, GaussianPose]] = []
        self._ranges: dict[tuple[int, int], RangeMean] = {}
        self._meetings: list[tuple[str, int, float, tuple[float, float], Array, Pose2]] = []
        self.tags: dict[str, tuple[int, tuple[float, float]]] = {}  # id -> index, place in the map frame
        self.last_covariance: Array = np.eye(3) * _START_SD**2  # of the newest pose, in the map frame

    @property
    def last_belief(self) -> GaussianPose:
        """The newest pose with its covariance."""
        return GaussianPose(self.poses[-1], self.last_covariance)

    @property
    def newest(self) -> int:
        """Index of the newest pose vertex."""
        return len(self.poses) - 1

    def add_pose(self, displacement: GaussianPose, stamp_s: float, yaw_rad: float | None) -> int:
        """Append a vertex at the measured displacement from the newest one; return its index."""
        covariance = displacement.covariance + np.eye(3) * _FLOOR
        measured = GaussianPose(displacement.mean, covariance)
        here = GaussianPose(self.poses[-1], self.last_covariance) @ measured
        self.poses.append(here.mean)
        self.last_covariance = here.covariance
        self._stamps.append(stamp_s)
        self._yaws.append(np.nan if yaw_rad is None else yaw_rad)
        self._edges.append((self.newest - 1, self.newest, measured))
        return self.newest

    def add_sighting(self, tag_id: str, place_m: tuple[float, float], covariance: Array) -> bool:
        """Note a tag at a place in the newest pose's frame, covariance (2, 2).

        Say whether that is news of a tag that was known before. Several sightings of a tag from one pose
        share their errors: their mean counts as one.
        """
        new = tag_id not in self.tags
        if new:
            self.tags[tag_id] = (len(self.tags), self.poses[-1].transform_point(*place_m))
        pair = (self.newest, self.tags[tag_id][0])
        news = not new and pair not in self._sightings
        count, mean, spread = self._sightings.get(pair, (0, np.zeros(2), covariance))
        mean = mean + (np.array(place_m) - mean) / (count + 1)
        self._sightings[pair] = (count + 1, mean, spread)
        return news

    def add_range(self, sighting: RangeSighting, base: GaussianPose) -> bool:
        """Note a tag seen by range and bearing from ``base`` in the newest pose's frame; say as above."""
        antenna = base.mean @ sighting.base_from_antenna
        bearing = sighting.bearing_rad or 0.0
        ahead = sighting.range_m * cos(bearing), sighting.range_m * sin(bearing)
        new = sighting.tag_id not in self.tags
        if new:
            place = (self.poses[-1] @ antenna).transform_point(*ahead)
            self.tags[sighting.tag_id] = (len(self.tags), place)
        pair = (self.newest, self.tags[sighting.tag_id][0])
        news = not new and pair not in self._ranges
        self._ranges.setdefault(pair, RangeMean()).add(sighting, base)
        return news

    def add_loop(self, earlier: int, later: int, earlier_from_later: GaussianPose) -> None:
        """Note that the laser matched two poses."""
        self._loops.append((earlier, later, earlier_from_later))

    def add_meeting(
        self, robot_id: str, stamp_s: float, place_m: tuple[float, float], spread: Array, base: Pose2
    ) -> None:
        """Note another robot at a place in the newest pose's frame, covariance (2, 2), seen from ``base``."""
        self._meetings.append((robot_id, self.newest, stamp_s, place_m, spread, base))

    def solve(self) -> None:
        """Move poses and tags to where they best explain all displacements (eq. 5)."""
        solution = self._solve()
        self.poses = [Pose2.from_array(row) for row in solution.poses]
        places = [(float(x), float(y)) for x, y in solution.tags]
        self.tags = {tag_id: (index, places[index]) for tag_id, (index, _) in self.tags.items()}
        self.last_covariance = solution.pose_covariance(self.newest)

    def relative(self, first: int, second: int) -> GaussianPose:
        """Return pose ``second`` in the frame of pose ``first`` as everything measured so far has it."""
        solution = self._solve()
        a, b = (Pose2.from_array(solution.poses[index]) for index in (first, second))
        return GaussianPose(a.between(b), solution.marginals.relative(first, second))

    def _solve(self) -> GraphSolution:
        return solve_report(self.report(), self._config.graph)

    def report(self) -> GraphReport:
        """Return the graph as it leaves the process."""
        places = sorted(self.tags.items(), key=lambda item: item[1][0])
        seen = list(self._sightings.values())
        return GraphReport(
            poses=np.array([pose.as_array() for pose in self.poses]),
            stamps_s=np.array(self._stamps),
            yaws_rad=np.array(self._yaws),
            tag_ids=tuple(tag_id for tag_id, _ in places),
            tags=np.array([place for _, (_, place) in places]).reshape(-1, 2),
            edge_pairs=np.array([(i, j) for i, j, _ in self._edges], np.int64).reshape(-1, 2),
            edge_poses=np.array([edge.mean.as_array() for _, _, edge in self._edges]).reshape(-1, 3),
            edge_covariances=np.array([edge.covariance for _, _, edge in self._edges]).reshape(-1, 3, 3),
            sighting_pairs=np.array(list(self._sightings), np.int64).reshape(-1, 2),
            sighting_offsets=np.array([mean for _, mean, _ in seen]).reshape(-1, 2),
            sighting_covariances=np.array([spread for _, _, spread in seen]).reshape(-1, 2, 2),
            loop_pairs=np.array([(i, j) for i, j, _ in self._loops], np.int64).reshape(-1, 2),
            loop_poses=np.array([loop.mean.as_array() for _, _, loop in self._loops]).reshape(-1, 3),
            loop_covariances=np.array([loop.covariance for _, _, loop in self._loops]).reshape(-1, 3, 3),
            meeting_robots=tuple(met[0] for met in self._meetings),
            meeting_poses=np.array([met[1] for met in self._meetings], np.int64),
            meeting_stamps_s=np.array([met[2] for met in self._meetings]),
            meeting_offsets=np.array([met[3] for met in self._meetings]).reshape(-1, 2),
            meeting_covariances=np.array([met[4] for met in self._meetings]).reshape(-1, 2, 2),
            meeting_bases=np.array([met[5].as_array() for met in self._meetings]).reshape(-1, 3),
            **table(self._ranges),
        )


def solve_report(report: GraphReport, config: GraphConfig) -> GraphSolution:
    """Solve one robot's graph, held in place at its start (eq. 5).

    Raises:
        GraphError: it cannot be solved; the message says why.
    """
    return solve(
        graph_problem(as_sightings(report)), config.method, config.max_iterations, config.tag_kernel_sd
    )


def graph_problem(report: GraphReport) -> GraphProblem:
    """Return the arrays of one robot's graph, held in place at its start."""
    edges = len(report.edge_pairs)
    known = np.flatnonzero(np.isfinite(report.yaws_rad))
    return GraphProblem(
        poses=report.poses,
        tags=report.tags,
        edge_pairs=np.concatenate([report.edge_pairs, report.loop_pairs]),
        edge_poses=np.concatenate([report.edge_poses, report.loop_poses]),
        edge_covariances=np.concatenate([report.edge_covariances, report.loop_covariances]),
        edge_robust=np.arange(edges + len(report.loop_pairs)) >= edges,
        sighting_pairs=report.sighting_pairs,
        sighting_offsets=report.sighting_offsets,
        sighting_covariances=report.sighting_covariances,
        prior_index=np.zeros(1, np.int64),
        prior_poses=report.poses[:1],
        prior_sds=np.full((1, 3), _START_SD),
        heading_index=known,
        heading_rad=report.yaws_rad[known],
        heading_sd_rad=np.full(len(known), _BEND_SD_RAD),
    )
