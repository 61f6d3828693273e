"""Waymark's own: go where much is unknown to all whose word was read, for the way it takes.

Ground that others have covered and closed is left to the last, but never struck off: a tag may be wrong, and
a robot that has nothing better to do looks for itself.
"""

from __future__ import annotations

import numpy as np

from robots.exploration.far_sight import FarFrontier, FarSight
from robots.exploration.frontiers import Frontier
from robots.exploration.strategies.information_gain import SEEN_M, SQUARE_M2, WORTH_M
from robots.exploration.strategy import ExplorationView, goals_of, ways_of
from robots.se2 import Array

_CLAIMED_M = 15.0  # of way, where all round a frontier is claimed


class Waymark:
    """Weighs the way to a frontier against what is unknown round it and what others have claimed."""

    def __init__(self) -> None:
        self._far = FarSight()

    def candidates(self, view: ExplorationView) -> tuple[Frontier, ...]:
        """Return the frontiers; with a small map, those beyond which nothing is covered, or ways far off."""
        return self._far.candidates(view) if view.settings.local_map_m else view.frontiers

    def worths(self, view: ExplorationView) -> Array:
        """Return what is to be seen less what is claimed and the way."""
        if view.settings.local_map_m:  # what is claimed was left out
            untold, _ = self._far.survey().shares(places_of(view), SEEN_M)
            return WORTH_M * untold - ways_of(view)
        untold, claimed = view.survey.shares(goals_of(view), SEEN_M)
        return WORTH_M * untold - _CLAIMED_M * claimed - ways_of(view)

    def reason(self, view: ExplorationView, index: int) -> str:
        """Return how much is to be seen, or that tags say otherwise."""
        frontier = view.frontiers[index]
        if isinstance(frontier, FarFrontier):
            return "ground that was left open, along tags"
        untold, claimed = view.survey.shares(goals_of(view)[index : index + 1], SEEN_M)
        if claimed[0] > untold[0]:
            return "check ground that tags call covered"
        return f"see about {untold[0] * SQUARE_M2:.0f} m² of new ground"


def places_of(view: ExplorationView) -> Array:
    """Return where the new ground is, (n, 2), of each candidate."""
    places = [f.at_m if isinstance(f, FarFrontier) else f.goal_m for f in view.frontiers]
    return np.array(places).reshape(-1, 2)
