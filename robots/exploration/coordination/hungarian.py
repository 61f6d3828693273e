"""The assignment of frontiers to robots that is worth most to the whole team (Kuhn 1955)."""

from __future__ import annotations

import numpy as np
from scipy.optimize import linear_sum_assignment

from robots.exploration.coordination.team import NEVER, Team
from robots.se2 import Array

_NO_WAY_M = 1e6


class Hungarian:
    """Everybody gets another frontier, so that the sum of what they are worth is greatest."""

    why = "my part of what is best for all"

    def choose(self, team: Team) -> int:
        """Return this robot's frontier; what is worth most to it where there are too few."""
        if len(team) > 1:
            mine = assigned(team.worths)[team.me]
            if mine >= 0:
                return int(mine)
        return int(np.argmax(team.own))


def assigned(worths: Array) -> Array:
    """Return a frontier for each robot, (m,), -1 where none is left or none can be reached."""
    rows, columns = linear_sum_assignment(np.maximum(worths, -_NO_WAY_M), maximize=True)
    chosen = np.full(len(worths), -1)
    chosen[rows] = np.where(worths[rows, columns] > NEVER, columns, -1)
    return chosen
