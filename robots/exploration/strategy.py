"""The interface of exploration strategies: what they see, and what they answer."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from robots.config import PlanningConfig
from robots.exploration.frontiers import Frontier
from robots.exploration.told.claims import KnownTag
from robots.exploration.told.survey import Survey
from robots.planning.plan_grid import PlanGrid
from robots.se2 import Array, Pose2
from robots.tags.memory import TagMemory


@dataclass(frozen=True, slots=True, eq=False)
class ExplorationView:
    """What a strategy may use, in the map frame.

    The robot's pose, its reachable frontiers, nearest first, and ``survey``: what is unknown, to it and to
    those whose word it has read in tags. ``grid`` and ``costs`` int32 (h, w): the plan grid, and what
    driving to each of its cells costs in fifths of a cell (UNREACHED where it cannot). ``trail`` (k, 4): x,
    y, heading, stamp of where it was, oldest first, ``mates_trail`` (m, 4) of where others were that were
    heard, ``mates_ways`` (l, 3) of places on their straight ways to their goals; ``path_m`` (n, 2): the rest
    of its way to its last goal, ``goal_m`` where it is on its way to, ``aside_m`` goals that came to nothing
    and are left for a while; ``tags``: all that it read, from up to ``tag_reach_m`` off, ``base_m`` where
    reports go; ``battery`` 1 full, 0 empty; ``ways_m`` (f,): what it costs to get to the frontiers, where
    that is not what they say themselves.
    """

    pose: Pose2
    frontiers: tuple[Frontier, ...]
    survey_of: Callable[[], Survey]
    now_s: float = 0.0
    grid: PlanGrid | None = None
    costs: NDArray[np.int32] | None = None
    trail: Array = field(default_factory=lambda: np.zeros((0, 4)))
    path_m: Array = field(default_factory=lambda: np.zeros((0, 2)))
    goal_m: tuple[float, float] | None = None
    aside_m: tuple[tuple[float, float], ...] = ()
    tags: tuple[KnownTag, ...] = ()
    tag_reach_m: float = 0.0
    mates_trail: Array = field(default_factory=lambda: np.zeros((0, 4)))
    mates_ways: Array = field(default_factory=lambda: np.zeros((0, 3)))
    base_m: tuple[float, float] = (0.0, 0.0)
    battery: float = 1.0
    settings: PlanningConfig = field(default_factory=PlanningConfig)
    ways_m: Array | None = None

    @property
    def survey(self) -> Survey:
        """What is unknown, made when it is first asked for: not every strategy does."""
        return self.survey_of()

    def with_ways(self, ways_m: Array) -> ExplorationView:
        """Return the view in which the ways to the frontiers, (n,), cost so many metres.

        So a strategy can be asked with straight lines for ways, or for a teammate somewhere else.
        """
        return replace(self, ways_m=ways_m)


class Strategy(Protocol):
    """Weighs frontiers against each other."""

    def worths(self, view: ExplorationView) -> Array:
        """Return how much each frontier is worth (n,), in metres of way; the robot goes to the greatest."""
        ...

    def reason(self, view: ExplorationView, index: int) -> str:
        """Return why a frontier is chosen, in words an operator understands, after "driving 3 m to"."""
        ...


@runtime_checkable
class OwnCandidates(Protocol):
    """A strategy that looks for places of its own, beside or in place of the frontiers."""

    def candidates(self, view: ExplorationView) -> tuple[Frontier, ...]:
        """Return the places to weigh; where there are none, the nearest frontier is gone to."""
        ...


@runtime_checkable
class KeepsGoals(Protocol):
    """A strategy that decides anew when the robot has come to where it was sent, not on the way."""

    keeps_goals: bool


@runtime_checkable
class AnswersTags(Protocol):
    """A strategy with rules of its own for the ground that a tag holds after it was read."""

    def answer(self, memory: TagMemory, view: ExplorationView, tag_m: tuple[float, float]) -> TagMemory:
        """Return a memory whose windows a tag at a place in the map frame is to hold, given what it said."""
        ...


@runtime_checkable
class TakesTheBest(Protocol):
    """A strategy printed as taking what is worth most, whatever the robot is on its way to."""

    takes_the_best: bool


@runtime_checkable
class PlansLocally(Protocol):
    """A strategy made for a small map round the robot, with ways by eq. (6) of Ziparo 2007.

    It wants a tag wherever none is known within ``tag_every_m``.
    """

    local_map_m: float
    tag_every_m: float


def goals_of(view: ExplorationView) -> Array:
    """Return where the frontiers are, (n, 2), in the map frame."""
    return np.array([frontier.goal_m for frontier in view.frontiers]).reshape(-1, 2)


def ways_of(view: ExplorationView) -> Array:
    """Return what it costs to get to the frontiers, (n,), in metres."""
    if view.ways_m is not None:
        return view.ways_m
    return np.array([frontier.cost_m for frontier in view.frontiers])
