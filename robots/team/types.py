"""What the team knows together, as it crosses borders. All of it in the world frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from robots.se2 import Array, Pose2
from robots.types import FloatArray32

TagCondition = Literal["sound", "moved", "cloned", "doubtful"]


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
    nothing joins it to the world yet; its poses are in its own map frame. ``covariance`` (3, 3) of its newest
    anchor in the joint solution; None where it is not located.
    """

    robot_id: str
    located: bool
    anchors: Array
    trail_m: FloatArray32
    covariance: Array | None = None


@dataclass(frozen=True, slots=True, eq=False)
class TeamTag:
    """A tag in the world: place in metres, covariance (2, 2) in m2, how often and by whom it was read.

    ``state``: *sound*; *moved*: it lies here now, and lay elsewhere before; *cloned*: one of several places
    where tags answer to this id, the others are ``ID#2`` and so on; *doubtful*: a sighting contradicted all
    others. ``notice``: what is wrong with it, for the operator; empty where nothing is.
    """

    tag_id: str
    x_m: float
    y_m: float
    covariance: Array
    sightings: int
    robots: tuple[str, ...]
    state: TagCondition = "sound"
    notice: str = ""


@dataclass(frozen=True, slots=True)
class TeamNotice:
    """Something the operator should know about a tag or a robot's way.

    ``about``: id of the tag, or of the robot for ``way``. ``since_s``: mission time of the first sighting, or
    way, that shows it. ``robots``: who saw it.
    """

    kind: Literal["moved", "cloned", "doubtful", "way"]
    about: str
    text: str
    since_s: float
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
    kind: str = "person"


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

    ``links``: pairs of tags driven one after the other. ``notices``: what is wrong, by kind and subject.
    """

    robots: tuple[TeamRobot, ...]
    tags: tuple[TeamTag, ...]
    links: tuple[tuple[str, str], ...]
    victims: tuple[TeamVictim, ...]
    grid: TeamGrid | None
    explored_m2: float
    notices: tuple[TeamNotice, ...] = ()
