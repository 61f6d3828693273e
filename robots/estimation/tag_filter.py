"""What SLAM over radio tags asks of its filter, whichever it is."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

from robots.se2 import Array, GaussianPose, Pose2
from robots.tags.map_memory import TagBelief, WriterMap


@dataclass(frozen=True, slots=True, eq=False)
class Dropped:
    """Where the robot dropped a tag, in the base frame as it is now, with covariance (2, 2)."""

    place_m: tuple[float, float]
    covariance: Array


@dataclass(frozen=True, slots=True)
class RangeSighting:
    """A tag seen by range and, where the radio has a direction, by bearing from the antenna's axis.

    ``range_m`` as measured, with whatever the radio adds to it. Of a signal strength, ``median_m`` and
    ``log_sd`` tell more: the logarithm of the range is normal about that of the median. ``independent``: the
    range's error has nothing to do with that of the tag's sighting before, as errors of range finders have.
    ``dropped``: this robot dropped it a moment ago. ``in_cone``: all that is known of the bearing is that it
    lies in the antenna's cone.
    """

    tag_id: str
    stamp_s: float
    range_m: float
    range_sd_m: float
    bearing_rad: float | None = None
    bearing_sd_rad: float | None = None
    base_from_antenna: Pose2 = field(default_factory=Pose2)
    median_m: float | None = None
    log_sd: float | None = None
    independent: bool = False
    dropped: Dropped | None = None
    in_cone: bool = False


class TagFilter(Protocol):
    """A filter over the robot's pose and the tags, in the map frame, which begins at the robot's start."""

    @property
    def range_scale(self) -> float:
        """What it has learnt of the radios: measured = scale * true + offset of the tag."""

    @property
    def belief(self) -> GaussianPose:
        """The robot's pose."""

    def predict(self, moved: GaussianPose) -> None:
        """Move by a displacement in the frame of the pose before, with its covariance (3, 3)."""

    def see_heading(self, heading_rad: float, sd_rad: float) -> None:
        """Take in the heading of a compass."""

    def see(self, sighting: RangeSighting) -> bool:
        """Take in a sighting of a tag; say whether it was used."""

    def anchor(self) -> None:
        """Remember the pose here as a vertex of the graph."""

    def anchors(self) -> list[Pose2]:
        """Return all poses remembered, as they are believed now; the first is the start."""

    def tags(self) -> dict[str, TagBelief]:
        """Return the tags whose places are known so far."""

    def range_offset(self, tag_id: str) -> float:
        """Return by how much ranges of a tag are too long, in metres; 0 where nothing was learnt."""

    def own_map(self) -> tuple[TagBelief, ...]:
        """Return the tags as this robot's own measurements alone have them, to be left in memories."""

    def read_map(self, other: WriterMap) -> None:
        """Take in a map that another robot left: a newer one of a writer stands for its older ones."""

    def take_doubts(self) -> tuple[str, ...]:
        """Return, once, what is wrong with tags, ranges and maps, each in a sentence for the operator."""
