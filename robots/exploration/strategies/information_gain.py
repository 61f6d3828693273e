"""Information gain: go where much is unknown for the way it takes, by this robot's own map alone."""

from __future__ import annotations

from robots.exploration.strategy import ExplorationView, goals_of, ways_of
from robots.se2 import Array

SEEN_M = 3.0  # to every side of a frontier
WORTH_M = 3.0  # of way, where all round a frontier is unknown
SQUARE_M2 = (2.0 * SEEN_M) ** 2


class InformationGain:
    """Weighs the way to a frontier against how much is unknown round it."""

    def worths(self, view: ExplorationView) -> Array:
        """Return what is to be seen less the way."""
        untold, claimed = view.survey.shares(goals_of(view), SEEN_M)
        return WORTH_M * (untold + claimed) - ways_of(view)

    def reason(self, view: ExplorationView, index: int) -> str:
        """Return how much is to be seen."""
        untold, claimed = view.survey.shares(goals_of(view)[index : index + 1], SEEN_M)
        return f"see about {(untold + claimed)[0] * SQUARE_M2:.0f} m² of new ground"
