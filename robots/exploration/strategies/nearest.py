"""Nearest frontier (Yamauchi 1997): go where the way to the unknown is shortest."""

from __future__ import annotations

from robots.exploration.strategy import ExplorationView, ways_of
from robots.se2 import Array


class Nearest:
    """Takes the frontier that costs least to reach."""

    def worths(self, view: ExplorationView) -> Array:
        """Return the ways, the shortest worth most."""
        return -ways_of(view)

    def reason(self, view: ExplorationView, index: int) -> str:
        """Return which edge it is."""
        which = "the nearest edge" if index == 0 else "an edge"
        return f"{which} of the unknown, {view.frontiers[index].length_m:.1f} m wide"
