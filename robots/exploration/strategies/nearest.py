"""Nearest frontier (Yamauchi 1997): go where the way to the unknown is shortest."""

from __future__ import annotations

from robots.exploration.strategy import Choice, ExplorationView


class Nearest:
    """Takes the frontier that costs least to reach."""

    def choose(self, view: ExplorationView) -> Choice | None:
        """Return the nearest frontier."""
        if not view.frontiers:
            return None
        nearest = view.frontiers[0]
        return Choice(nearest, f"the nearest edge of the unknown, {nearest.length_m:.1f} m wide")
