"""The interface of exploration strategies: what they see, and what they answer."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from robots.exploration.frontiers import Frontier
from robots.se2 import Pose2


@dataclass(frozen=True, slots=True)
class ExplorationView:
    """What a strategy may use, in the map frame.

    The robot's pose and its reachable frontiers, nearest first.
    """

    pose: Pose2
    frontiers: tuple[Frontier, ...]


@dataclass(frozen=True, slots=True)
class Choice:
    """A frontier to go to, and why, in words an operator understands."""

    frontier: Frontier
    reason: str


class Strategy(Protocol):
    """Chooses the next frontier; None when there is none worth going to."""

    def choose(self, view: ExplorationView) -> Choice | None:
        """Return the choice for this view."""
        ...
