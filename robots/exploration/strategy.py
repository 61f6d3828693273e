"""The interface of exploration strategies: what they see, and what they answer."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from robots.exploration.claims import Survey
from robots.exploration.frontiers import Frontier
from robots.se2 import Array, Pose2


@dataclass(frozen=True, slots=True)
class ExplorationView:
    """What a strategy may use, in the map frame.

    The robot's pose, its reachable frontiers, nearest first, and what is unknown, to it and to those whose
    word it has read in tags.
    """

    pose: Pose2
    frontiers: tuple[Frontier, ...]
    survey: Survey


class Strategy(Protocol):
    """Weighs frontiers against each other."""

    def worths(self, view: ExplorationView) -> Array:
        """Return how much each frontier is worth (n,), in metres of way; the robot goes to the greatest."""
        ...

    def reason(self, view: ExplorationView, index: int) -> str:
        """Return why a frontier is chosen, in words an operator understands, after "driving 3 m to"."""
        ...


def goals_of(view: ExplorationView) -> Array:
    """Return where the frontiers are, (n, 2), in the map frame."""
    return np.array([frontier.goal_m for frontier in view.frontiers]).reshape(-1, 2)


def ways_of(view: ExplorationView) -> Array:
    """Return what it costs to get to the frontiers, (n,), in metres."""
    return np.array([frontier.cost_m for frontier in view.frontiers])
