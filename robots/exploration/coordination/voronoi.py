"""Everybody has the frontiers it is nearest to."""

from __future__ import annotations

import numpy as np

from robots.exploration.coordination.team import Team


class Voronoi:
    """Takes what is worth most of its own frontiers, and of all where it has none."""

    why = "as nobody is nearer to it"

    def choose(self, team: Team) -> int:
        """Return the frontier."""
        owned = np.argmin(team.ways, axis=0) == team.me
        return int(np.argmax(np.where(owned, team.own, -np.inf) if owned.any() else team.own))
