"""Waymark's own: go where much is unknown to all whose word was read, for the way it takes.

Ground that others have covered and closed is left to the last, but never struck off: a tag may be wrong, and
a robot that has nothing better to do looks for itself.
"""

from __future__ import annotations

from robots.exploration.strategies.information_gain import SEEN_M, SQUARE_M2, WORTH_M
from robots.exploration.strategy import ExplorationView, goals_of, ways_of
from robots.se2 import Array

_CLAIMED_M = 15.0  # of way, where all round a frontier is claimed


class Waymark:
    """Weighs the way to a frontier against what is unknown round it and what others have claimed."""

    def worths(self, view: ExplorationView) -> Array:
        """Return what is to be seen less what is claimed and the way."""
        untold, claimed = view.survey.shares(goals_of(view), SEEN_M)
        return WORTH_M * untold - _CLAIMED_M * claimed - ways_of(view)

    def reason(self, view: ExplorationView, index: int) -> str:
        """Return how much is to be seen, or that tags say otherwise."""
        untold, claimed = view.survey.shares(goals_of(view)[index : index + 1], SEEN_M)
        if claimed[0] > untold[0]:
            return "check ground that tags call covered"
        return f"see about {untold[0] * SQUARE_M2:.0f} m² of new ground"
