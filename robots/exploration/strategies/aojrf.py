"""The Amsterdam Oxford Joint Rescue Forces' strategy (Amigoni 2013 eq. 1): free ground beyond over the way.

As printed, u = A P / d^b. With a full battery b is 0 and no way would count, where the paper calls u falling
with d: b is one in a hundred at least, so that of two places that are worth the same the nearer is taken.
A way of less than a metre counts as one, because below it the power turns the other way round.
"""

from __future__ import annotations

from math import exp, hypot

import numpy as np

from robots.exploration.frontiers import Frontier
from robots.exploration.strategies.sight import Sight
from robots.exploration.strategies.three_grids import Candidate, find_candidates, three_grids
from robots.exploration.strategy import ExplorationView, ways_of
from robots.se2 import Array

_LEAST_B = 0.01
_LEAST_WAY_M = 1.0


class Aojrf:
    """Weighs the free ground beyond the safe, the chance to report from there, the way and the battery."""

    keeps_goals = True  # "go to their destination locations and start again"

    def __init__(self) -> None:
        self._sight = Sight()

    def candidates(self, view: ExplorationView) -> tuple[Frontier, ...]:
        """Return the middles of the free ground beyond each boundary of the safe."""
        return safe_candidates(view, self._sight)

    def worths(self, view: ExplorationView) -> Array:
        """Return u(p, r) of eq. (1), in square metres."""
        b = max(1.0 - view.battery, _LEAST_B)
        ways = np.maximum(ways_of(view), _LEAST_WAY_M)
        worths: Array = areas_of(view) * chances_of(view) / ways**b  # (1)
        return worths

    def reason(self, view: ExplorationView, index: int) -> str:
        """Return what there is to gain."""
        return beyond(view, index)


def safe_candidates(view: ExplorationView, sight: Sight) -> tuple[Frontier, ...]:
    """Return the candidate locations of Amigoni 2013 section 3.1; ``sight`` is the robot's, kept up."""
    if view.grid is None or view.costs is None:
        return ()
    trails = np.concatenate([view.trail, view.mates_trail])
    grids = three_grids(view.grid, trails, view.settings.safe.safe_m, sight)
    return find_candidates(view.grid, view.costs, grids)


def areas_of(view: ExplorationView) -> Array:
    """Return A(p): the free ground beyond, (n,) in m2; of a frontier in place of a candidate, a guess."""
    return np.array(
        [f.area_m2 if isinstance(f, Candidate) else f.length_m * f.length_m for f in view.frontiers]
    )


def chances_of(view: ExplorationView) -> Array:
    """Return P(p), (n,): the chance to reach the base from there by radio, a bell over the distance."""
    reach_m, (x, y) = view.settings.safe.base_reach_m, view.base_m
    return np.array(
        [exp(-0.5 * (hypot(f.goal_m[0] - x, f.goal_m[1] - y) / reach_m) ** 2) for f in view.frontiers]
    )


def beyond(view: ExplorationView, index: int) -> str:
    """Return what lies beyond a candidate, in words."""
    frontier = view.frontiers[index]
    if not isinstance(frontier, Candidate):
        return "the nearest edge of the unknown: no free ground beyond the safe can be reached"
    chance = chances_of(view)[index]
    return (
        f"{frontier.area_m2:.0f} m² of free ground beyond the safe; {chance:.0%} to reach the base from there"
    )
