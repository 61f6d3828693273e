"""Go where the fewest have been (Svennebring and Koenig 2004, Building terrain-covering ant robots).

The nodes are the tags: each holds how often every robot passed it. Nothing is heard, and nothing needs to be.
"""

from __future__ import annotations

import numpy as np

from robots.exploration.coordination.team import Team
from robots.se2 import Array

NODE_M = 4.0  # a frontier belongs to the nearest tag within so far, else nobody has been there


class NodeCounting:
    """Takes a frontier at the tag that was passed least, and of several the one that is worth most."""

    why = "where fewer have been"

    def choose(self, team: Team) -> int:
        """Return the frontier."""
        counts = self.counts(team)
        return int(np.argmax(np.where(counts == counts.min(), team.own, -np.inf)))

    def counts(self, team: Team) -> Array:
        """Return how often robots passed where the frontiers are, (n,), by the tags that were read."""
        tags = team.view.tags
        if not tags:
            return np.zeros(len(team.frontiers_m))
        passed = np.array([float(sum(each.count for each in tag.memory.passes)) for tag in tags])
        places = np.array([tag.place_m for tag in tags])
        away = np.hypot(*(team.frontiers_m[:, None] - places[None]).transpose(2, 0, 1))
        return np.where(away.min(axis=1) <= NODE_M, passed[away.argmin(axis=1)], 0.0)
