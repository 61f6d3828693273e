"""What an agent asks of SLAM, whichever kind of tag it is made for, and the choice between the kinds."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from robots.config import AgentConfig
from robots.estimation.ekf.filter import EkfFilter
from robots.estimation.filter_slam import FilterSlam
from robots.estimation.passage import Passage
from robots.estimation.rslam.range_slam import RangeSlam
from robots.estimation.slip.patches import UNKNOWN
from robots.estimation.tag_filter import TagFilter
from robots.estimation.tag_graph.slam import TagSlam
from robots.graph_report import GraphReport
from robots.se2 import GaussianPose, Pose2
from robots.tags.map_memory import TagBelief
from robots.types import ImuReading, LaserScan, Observation

FILTERS: dict[str, Callable[[str, AgentConfig, Pose2], TagFilter]] = {  # robot, configuration, start
    "rslam": RangeSlam,
    "ekf": EkfFilter,
}


class Slam(Protocol):
    """Pose, anchors and tags of one robot in its map frame, and in the tracker's frame, which never jumps.

    The map frame begins at the robot's start; with an inertial unit its x axis points north.
    """

    @property
    def distance_m(self) -> float:
        """Way driven so far."""

    @property
    def local_from_base(self) -> Pose2:
        """Pose in the tracker's frame."""

    @property
    def anchor(self) -> int:
        """The newest pose vertex."""

    @property
    def anchor_from_base(self) -> GaussianPose:
        """Pose since the newest anchor."""

    @property
    def pose(self) -> Pose2:
        """Pose in the map frame."""

    @property
    def belief(self) -> GaussianPose:
        """Pose in the map frame with its covariance."""

    @property
    def anchors(self) -> list[Pose2]:
        """All pose vertices in the map frame."""

    def tag_place(self, tag_id: str) -> tuple[float, float]:
        """Return where a tag is in the map frame.

        Raises:
            KeyError: it is not known where.
        """

    def tag_places(self) -> list[tuple[float, float]]:
        """Return where the tags are whose place is known, in the map frame."""

    def own_map(self) -> tuple[TagBelief, ...]:
        """Return the tags as this robot's own measurements have them, to be left in memories."""

    def take_doubts(self) -> tuple[str, ...]:
        """Return, once, what is wrong with tags, ranges and maps, each in a sentence for the operator."""

    def predict(
        self, observation: Observation, moved: bool, slipping: bool, slip_share: float = UNKNOWN
    ) -> None:
        """Move by wheels and inertial unit; without ``moved`` the wheels do not count.

        ``slip_share``: of slippage among moments like this one (``slip/tree.py``).
        """

    def match(self, scan: LaserScan) -> None:
        """Fuse the scan matcher's pose."""

    def pass_tags(self, observation: Observation) -> Passage:
        """Take in what was read of tags, and their memories."""

    def report(self) -> GraphReport:
        """Return the graph as it leaves the process."""

    def smoothed(self) -> GraphReport:
        """Return the graph as a batch solve of all that was recorded has it; nothing changes here."""


def begin_slam(robot_id: str, config: AgentConfig, stamp_s: float, imu: ImuReading | None) -> Slam:
    """Begin the map of a robot at its first observation, in the way the configuration asks for."""
    make_filter = FILTERS.get(config.slam)
    if make_filter is None:
        return TagSlam(config, stamp_s, imu)
    return FilterSlam(robot_id, config, stamp_s, imu, make_filter)
