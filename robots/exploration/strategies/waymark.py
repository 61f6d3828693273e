"""Waymark's own: the shortest way to ground that nobody has told of, through what others have covered.

Where others said they went is left to them. What is claimed is left to the last, but never struck off: a tag
may be wrong, and a robot that has nothing better to do looks for itself.
"""

from __future__ import annotations

import os

import numpy as np

from robots.exploration.outlook import ways_beyond
from robots.exploration.strategies.information_gain import SEEN_M, SQUARE_M2, WORTH_M
from robots.exploration.strategy import ExplorationView, goals_of, ways_of
from robots.se2 import Array

_P = [float(v) for v in os.environ.get("WM", "3,1.5,15,6,4,6,4,1").split(",")]
WORTH_M, _DETOUR, _MOST_M, _PROMISED_M, _PROMISE_REACHES_M, _TROD_M, _TROD_REACHES_M, _OWN = _P


class Waymark:
    """Weighs ways to frontiers, and beyond them, against what is unknown to all and where others went."""

    def worths(self, view: ExplorationView) -> Array:
        """Return what is to be seen less the way and what others covered or took upon themselves."""
        goals = goals_of(view)
        untold, claimed = view.survey.shares(goals, SEEN_M)
        cells = np.array([frontier.goal for frontier in view.frontiers]).reshape(-1, 2)
        beyond = np.zeros(len(goals))
        if view.grid is not None:
            beyond = ways_beyond(view.grid, view.survey, cells, _MOST_M)
        seen = np.maximum(0.0, 1.0 - beyond / SEEN_M)  # behind claimed ground there is a wall
        return WORTH_M * untold * seen - _DETOUR * beyond - _PROMISED_M * promised(view) - _TROD_M * trodden(view) - ways_of(view)

    def reason(self, view: ExplorationView, index: int) -> str:
        """Return how much is to be seen, or that tags say otherwise."""
        untold, claimed = view.survey.shares(goals_of(view)[index : index + 1], SEEN_M)
        if claimed[0] > untold[0]:
            return "check ground that tags call covered"
        return f"see about {untold[0] * SQUARE_M2:.0f} m² of new ground"


def promised(view: ExplorationView) -> Array:
    """Return how near, 0 to 1, each frontier is to a place where another robot said it went, (n,)."""
    return _nearness(goals_of(view), view.survey.promised, _PROMISE_REACHES_M)


def trodden(view: ExplorationView) -> Array:
    """Return how near, 0 to 1, each frontier is to where robots drove, (n,)."""
    driven = [tag.memory.visited_m + np.array(tag.place_m) for tag in view.tags]
    if _OWN:
        driven.append(view.trail[:, :2])
    return _nearness(goals_of(view), np.concatenate([np.zeros((0, 2)), *driven]), _TROD_REACHES_M)


def _nearness(goals: Array, places: Array, reach_m: float) -> Array:
    if len(places) == 0 or len(goals) == 0:
        return np.zeros(len(goals))
    gaps = np.sqrt(((goals[:, None, :] - places[None, :, :]) ** 2).sum(axis=2).min(axis=1))
    near: Array = np.maximum(0.0, 1.0 - gaps / reach_m)
    return near
