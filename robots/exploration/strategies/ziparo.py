"""Ziparo 2007 section 5: ahead rather than back, and away from where tags say that robots have been.

A strategy for a map of four metres round the robot, which forgets: what was explored before is remembered by
the tags within reach of that map alone. A tag holds the cells of 0.4 m round it through which robots went,
and of each whether once or more often; that is count(p) as far as a tag of 2,048 bits has room for it. A cell
that several tags hold counts once, because a pose is written into one tag and 1 / d is taken of every tag.
"""

from __future__ import annotations

from math import atan2

import numpy as np

from robots.exploration.frontiers import Frontier
from robots.exploration.strategy import ExplorationView, goals_of
from robots.exploration.told.claims import KnownTag
from robots.se2 import Array, Pose2, wrap
from robots.tags.memory import VISITED_M

_NEAREST_M = VISITED_M  # 1 / d grows without bound at a pose itself


class Ziparo:
    """Weighs the turn to a frontier and how much was driven round it."""

    local_map_m = 4.0
    tag_every_m = 1.0  # "we take care of having the RFIDs at one meter distance from each other"

    def __init__(self) -> None:
        self._visited: tuple[tuple[KnownTag, ...], tuple[Frontier, ...], Pose2, Array] | None = None

    def worths(self, view: ExplorationView) -> Array:
        """Return u(f) of eq. (7)."""
        told = view.settings.ziparo
        worths: Array = -told.gamma_angle * angles(view) ** 2 - told.gamma_visited * self._visits(view)  # (7)
        return worths

    def reason(self, view: ExplorationView, index: int) -> str:
        """Return where it lies and what tags say of it."""
        turn = angles(view)[index]
        way = "ahead" if turn < 0.5 else "to the side" if turn < 2.0 else "back"
        told = self._visits(view)[index]
        return f"the unknown {way}; tags tell of {'no' if told == 0.0 else f'{told:.0f}'} visits near it"

    def _visits(self, view: ExplorationView) -> Array:
        """Return visited(f), kept from weighing to giving reasons."""
        known = self._visited
        if (
            known is None
            or known[0] is not view.tags
            or known[1] is not view.frontiers
            or known[2] != view.pose
        ):
            known = self._visited = view.tags, view.frontiers, view.pose, visited(view)
        return known[3]


def angles(view: ExplorationView) -> Array:
    """Return how far the robot would turn towards each frontier, (n,) in radians, 0 to pi."""
    pose = view.pose
    return np.array(
        [abs(wrap(atan2(f.goal_m[1] - pose.y, f.goal_m[0] - pose.x) - pose.theta)) for f in view.frontiers]
    )


def visited(view: ExplorationView) -> Array:
    """Return visited(f) of eq. (8), (n,) in 1/m: of the tags in reach of the local map, the LRS."""
    places, counts = local_visits(view)
    if len(places) == 0:
        return np.zeros(len(view.frontiers))
    apart = np.hypot(*(goals_of(view)[:, None] - places[None]).transpose(2, 0, 1))
    total: Array = (counts / np.maximum(apart, _NEAREST_M)).sum(axis=1)  # (8)
    return total


def local_visits(view: ExplorationView) -> tuple[Array, Array]:
    """Return where robots were, (m, 2), and count(p), (m,), as the tags in reach of the local map say."""
    reach = (view.settings.local_map_m or Ziparo.local_map_m) / 2.0
    x, y = view.pose.x, view.pose.y
    near = [
        tag for tag in view.tags
        if -reach <= tag.place_m[0] - x <= reach and -reach <= tag.place_m[1] - y <= reach
    ]  # fmt: skip
    told = [(tag.memory.visited_m + np.array(tag.place_m)) / VISITED_M for tag in near]
    cells = np.rint(np.concatenate([np.zeros((0, 2)), *told]))
    counts = np.concatenate([np.zeros(0), *(tag.memory.visited[tag.memory.visited > 0] for tag in near)])
    order = np.lexsort((-counts, cells[:, 1], cells[:, 0]))
    cells, counts = cells[order], counts[order]
    first = np.ones(len(cells), bool)  # of each cell what was said most
    first[1:] = (cells[1:] != cells[:-1]).any(axis=1)
    return cells[first] * VISITED_M, counts[first]
