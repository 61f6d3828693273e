"""One robot's growing tag graph.

Anchors it has passed, tags it has read, and the measurements between them.
"""

from __future__ import annotations

import numpy as np

from robots.config import AgentConfig
from robots.estimation.graph import GraphProblem, GraphSolution, solve
from robots.se2 import Array, GaussianPose, Pose2
from robots.types import GraphReport

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
        self._sightings: list[tuple[int, int]] = []
        self.tags: dict[str, tuple[int, tuple[float, float]]] = {}  # id -> index, place in the map frame
        self.last_covariance: Array = np.eye(3) * _START_SD**2  # of the newest pose, in the map frame

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

    def add_sighting(self, tag_id: str) -> bool:
        """Note that a tag lies under the antenna at the newest pose; say whether the tag is new."""
        new = tag_id not in self.tags
        if new:
            place = self.poses[-1].transform_point(self._config.antenna.ahead_m, 0.0)
            self.tags[tag_id] = (len(self.tags), place)
        self._sightings.append((self.newest, self.tags[tag_id][0]))
        return new

    def solve(self) -> None:
        """Move poses and tags to where they best explain all displacements (eq. 5)."""
        solution = self._solve()
        self.poses = [Pose2.from_array(row) for row in solution.poses]
        places = [(float(x), float(y)) for x, y in solution.tags]
        self.tags = {tag_id: (index, places[index]) for tag_id, (index, _) in self.tags.items()}
        self.last_covariance = solution.pose_covariance(self.newest)

    def _solve(self) -> GraphSolution:
        config = self._config.graph
        return solve(self.problem(), config.method, config.max_iterations, config.tag_kernel_sd)

    def problem(self) -> GraphProblem:
        """Return the arrays of the graph, held in place at its start."""
        report = self.report()
        known = np.flatnonzero(np.isfinite(report.yaws_rad))
        return GraphProblem(
            poses=report.poses,
            tags=report.tags,
            edge_pairs=report.edge_pairs,
            edge_poses=report.edge_poses,
            edge_covariances=report.edge_covariances,
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

    def report(self) -> GraphReport:
        """Return the graph as it leaves the process."""
        places = sorted(self.tags.items(), key=lambda item: item[1][0])
        antenna = self._config.antenna
        n = len(self._sightings)
        return GraphReport(
            poses=np.array([pose.as_array() for pose in self.poses]),
            stamps_s=np.array(self._stamps),
            yaws_rad=np.array(self._yaws),
            tag_ids=tuple(tag_id for tag_id, _ in places),
            tags=np.array([place for _, (_, place) in places]).reshape(-1, 2),
            edge_pairs=np.array([(i, j) for i, j, _ in self._edges], np.int64).reshape(-1, 2),
            edge_poses=np.array([edge.mean.as_array() for _, _, edge in self._edges]).reshape(-1, 3),
            edge_covariances=np.array([edge.covariance for _, _, edge in self._edges]).reshape(-1, 3, 3),
            sighting_pairs=np.array(self._sightings, np.int64).reshape(-1, 2),
            sighting_offsets=np.tile([antenna.ahead_m, 0.0], (n, 1)),
            sighting_covariances=np.tile(np.diag(antenna.variances), (n, 1, 1)),
        )
