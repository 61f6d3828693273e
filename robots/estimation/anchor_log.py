"""What one robot measured between its anchors and the tags it heard, to be reported and solved in a batch."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from robots.estimation.ranges.mean import RangeMean, table
from robots.estimation.tag_filter import RangeSighting
from robots.graph_report import GraphReport
from robots.se2 import Array, GaussianPose, Pose2

_FLOOR = np.eye(3) * 1e-6  # m2 and rad2: no displacement is known better than a millimetre
_Meeting = tuple[str, int, float, tuple[float, float], Array, Pose2]


class AnchorLog:
    """Displacements between anchors, and what was seen from each."""

    def __init__(self, stamp_s: float, yaw_rad: float | None) -> None:
        self._stamps = [stamp_s]
        self._yaws = [np.nan if yaw_rad is None else yaw_rad]
        self._edges: list[GaussianPose] = []
        self._ranges: dict[tuple[int, str], RangeMean] = {}
        self._passed: dict[tuple[int, str], tuple[tuple[float, float], Array]] = {}  # under the antenna
        self._meetings: list[_Meeting] = []

    @property
    def newest(self) -> int:
        """Index of the newest anchor."""
        return len(self._edges)

    @property
    def edges(self) -> list[GaussianPose]:
        """The measured displacements from each anchor to the next."""
        return self._edges

    def ranges_by_tag(self) -> dict[str, list[tuple[int, tuple[float, ...]]]]:
        """Return anchor and row (``RangeMean.row``) of what was heard of each tag, in the order of time."""
        found: dict[str, list[tuple[int, tuple[float, ...]]]] = {}
        for (anchor, tag_id), mean in self._ranges.items():
            found.setdefault(tag_id, []).append((anchor, mean.row))
        return found

    def add_anchor(self, displacement: GaussianPose, stamp_s: float, yaw_rad: float | None) -> None:
        """Append an anchor at the measured displacement from the newest one."""
        self._edges.append(GaussianPose(displacement.mean, displacement.covariance + _FLOOR))
        self._stamps.append(stamp_s)
        self._yaws.append(np.nan if yaw_rad is None else yaw_rad)

    def add_range(self, sighting: RangeSighting, anchor_from_base: GaussianPose) -> None:
        """Note a tag heard from a pose since the newest anchor."""
        self._ranges.setdefault((self.newest, sighting.tag_id), RangeMean()).add(sighting, anchor_from_base)

    def add_passed(self, tag_id: str, place_m: tuple[float, float], spread: Array) -> bool:
        """Note a tag under the antenna, in the newest anchor's frame; say whether that is news."""
        news = (self.newest, tag_id) not in self._passed
        self._passed.setdefault((self.newest, tag_id), (place_m, spread))
        return news

    def add_meeting(
        self, robot_id: str, stamp_s: float, place_m: tuple[float, float], spread: Array, base: Pose2
    ) -> None:
        """Note another robot at a place in the newest anchor's frame, seen from ``base`` in it."""
        self._meetings.append((robot_id, self.newest, stamp_s, place_m, spread, base))

    def passed_places(self, anchors: Sequence[Pose2]) -> dict[str, tuple[float, float]]:
        """Return where tags are that lay under the antenna, each where it was passed first."""
        places: dict[str, tuple[float, float]] = {}
        for (anchor, tag_id), (place, _) in self._passed.items():
            places.setdefault(tag_id, anchors[anchor].transform_point(*place))
        return places

    def report(
        self,
        anchors: Sequence[Pose2],
        tags: Mapping[str, tuple[float, float]],
        range_scale: float,
        range_offsets_m: Mapping[str, float],
    ) -> GraphReport:
        """Return the graph with anchors and tags where they are believed now.

        Ranges of tags that ``tags`` does not place are left out.
        """
        index = {tag_id: number for number, tag_id in enumerate(tags)}
        heard = {(a, index[t]): mean for (a, t), mean in self._ranges.items() if t in index}
        passed = [(key, seen) for key, seen in self._passed.items() if key[1] in index]
        count = len(self._edges)
        return GraphReport(
            poses=np.array([pose.as_array() for pose in anchors]).reshape(-1, 3),
            stamps_s=np.array(self._stamps),
            yaws_rad=np.array(self._yaws),
            tag_ids=tuple(tags),
            tags=np.array(list(tags.values()), np.float64).reshape(-1, 2),
            edge_pairs=np.stack([np.arange(count), np.arange(1, count + 1)], axis=1).astype(np.int64),
            edge_poses=np.array([edge.mean.as_array() for edge in self._edges]).reshape(-1, 3),
            edge_covariances=np.array([edge.covariance for edge in self._edges]).reshape(-1, 3, 3),
            sighting_pairs=np.array([(a, index[t]) for (a, t), _ in passed], np.int64).reshape(-1, 2),
            sighting_offsets=np.array([place for _, (place, _) in passed]).reshape(-1, 2),
            sighting_covariances=np.array([spread for _, (_, spread) in passed]).reshape(-1, 2, 2),
            meeting_robots=tuple(met[0] for met in self._meetings),
            meeting_poses=np.array([met[1] for met in self._meetings], np.int64),
            meeting_stamps_s=np.array([met[2] for met in self._meetings]),
            meeting_offsets=np.array([met[3] for met in self._meetings]).reshape(-1, 2),
            meeting_covariances=np.array([met[4] for met in self._meetings]).reshape(-1, 2, 2),
            meeting_bases=np.array([met[5].as_array() for met in self._meetings]).reshape(-1, 3),
            **table(heard),
            range_scale=range_scale,
            range_offsets_m=np.array([range_offsets_m.get(tag_id, 0.0) for tag_id in tags]),
        )
