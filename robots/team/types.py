"""What the team knows together, as it crosses borders. All of it in the world frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robots.se2 import Array, Pose2
from robots.types import FloatArray32


@dataclass(frozen=True, slots=True)
class StartPose:
    """A surveyed start.

    The pose of the base in the world, and its standard deviations in metres and radians.
    """

    pose: Pose2
    sd_m: float
    sd_rad: float


@dataclass(frozen=True, slots=True, eq=False)
class TeamRobot:
    """A robot in the team's map.

    ``anchors`` (n, 3) world poses of its pose vertices, ``trail_m`` (k, 2) where it drove. Not ``located``:
    nothing joins it to the world yet; its poses are in its own map frame.
    """

    robot_id: str
    located: bool
    anchors: Array
    trail_m: FloatArray32


@dataclass(frozen=True, slots=True, eq=False)
class TeamTag:
    """A tag in the world: place in metres, covariance (2, 2) in m2, how often and by whom it was read."""

    tag_id: str
    x_m: float
    y_m: float
    covariance: Array
    sightings: int
    robots: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class TeamVictim:
    """A victim in the world, merged from all robots that saw one there."""

    victim_id: str
    x_m: float
    y_m: float
    covariance: Array
    confidence: float
    sightings: int
    robots: tuple[str, ...]
    first_seen_s: float
    last_seen_s: float


@dataclass(frozen=True, slots=True, eq=False)
class TeamGrid:
    """The fused map.

    ``cells`` int8 (h, w), 0..100 occupancy or -1 unknown; cell (0, 0)'s lower left corner at ``origin_m``.
    """

    cells: NDArray[np.int8]
    origin_m: tuple[float, float]
    resolution_m: float
    version: int


@dataclass(frozen=True, slots=True, eq=False)
class TeamUpdate:
    """Everything the team knows together, in the world frame.

    ``links``: pairs of tags driven one after the other.
    """

    robots: tuple[TeamRobot, ...]
    tags: tuple[TeamTag, ...]
    links: tuple[tuple[str, str], ...]
    victims: tuple[TeamVictim, ...]
    grid: TeamGrid | None
    explored_m2: float
