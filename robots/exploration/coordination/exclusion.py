"""Keep away from where others go: the rule of one line that gets most of what coordination has to give."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robots.exploration.coordination.team import Team, near

KEEP_OFF_M = 4.0


class Exclusion:
    """Takes what is worth most beyond 4 m of the others' goals, or anywhere where nothing is."""

    why = "away from where others go"

    def choose(self, team: Team) -> int:
        """Return the frontier."""
        excluded = self.excluded(team)
        worths = team.own
        return int(np.argmax(worths if excluded.all() else np.where(excluded, -np.inf, worths)))

    def excluded(self, team: Team) -> NDArray[np.bool_]:
        """Return which frontiers lie too near to a goal of somebody else, (n,).

        Of two that go to one place, the one with the shorter way stays, or the first by name.
        """
        excluded = np.zeros(len(team.frontiers_m), bool)
        mine = team.goals_m[team.me]
        for robot, goal in enumerate(team.goals_m):
            if robot == team.me or goal is None:
                continue
            close = near(goal, team.frontiers_m, KEEP_OFF_M)
            same = team.heading_for(team.me)
            if mine is not None and same is not None and close[same]:
                ways = team.ways_of(team.me)[same], team.ways_of(robot)[same]
                if (ways[0], team.me) < (ways[1], robot):
                    continue
            excluded |= close
        return excluded
