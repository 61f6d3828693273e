"""Pairs by straight lines (Amigoni 2013, "AOJRF simplified coordination")."""

from __future__ import annotations

import numpy as np

from robots.exploration.coordination.team import Team, greedy_pairs


class Simplified:
    """Gives out the pair of robot and frontier worth most, then the next, by straight distances alone."""

    why = "the best that others leave me"

    def choose(self, team: Team) -> int:
        """Return this robot's frontier; what is worth most to it where none was left for it."""
        if len(team) == 1:
            return int(np.argmax(team.own))
        worths = np.array([team.worths_by(robot, team.straight(robot)) for robot in range(len(team))])
        mine = int(greedy_pairs(worths)[team.me])
        return mine if mine >= 0 else int(np.argmax(team.own))
