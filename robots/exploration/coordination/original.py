"""Pairs by ways that are planned only where they count (Amigoni 2013, "AOJRF original coordination").

It gives out what the market of Simmons et al. (2000) and Zlot et al. (2002) gives out. As a straight line is
never longer than the way, and worth falls with distance, the pair found is the best by ways that there is;
that holds for strategies that weigh a frontier by its own way, like eq. (1), and not where another's way
moves the scale, like eq. (2). Robots that are on their way keep their goals (``Team.worths_by``): what they
head for is given out to them before the best of the others is looked for.
"""

from __future__ import annotations

import numpy as np

from robots.exploration.coordination.team import NEVER, Team


class Original:
    """Section 3.3, steps 1 to 5."""

    why = "the best that others leave me"

    def choose(self, team: Team) -> int:
        """Return this robot's frontier; what is worth most to it where none was left for it."""
        if len(team) == 1:
            return int(np.argmax(team.own))
        ways = np.array([team.straight(robot) for robot in range(len(team))])
        worths = np.array([team.worths_by(robot, ways[robot]) for robot in range(len(team))])  # step 1
        planned = np.zeros(worths.shape, bool)
        while worths.max() > NEVER:
            robot, frontier = np.unravel_index(int(np.argmax(worths)), worths.shape)  # step 2
            if not planned[robot, frontier]:  # step 3
                planned[robot, frontier] = True
                team.planned += 1
                way = team.ways_of(int(robot))[frontier]
                if not np.isfinite(way):
                    worths[robot, frontier] = NEVER
                    continue
                ways[robot, frontier] = max(way, ways[robot, frontier])
                open_ = worths[robot] > NEVER
                worths[robot] = np.where(open_, team.worths_by(int(robot), ways[robot]), NEVER)
                continue  # step 4: is it still the best?
            if robot == team.me:
                return int(frontier)
            worths[robot, :] = NEVER  # step 5
            worths[:, frontier] = NEVER
        return int(np.argmax(team.own))


def ways_planned_alone(team: Team) -> int:
    """Return how many ways steps 1 to 4 plan for this robot alone ("no coordination")."""
    me, ways = team.me, team.straight(team.me)
    planned = np.zeros(len(ways), bool)
    while not planned.all():
        best = int(np.argmax(team.worths_by(me, ways)))
        if planned[best]:
            break
        planned[best] = True
        ways[best] = max(team.ways_of(me)[best], ways[best])
    return int(planned.sum())
