"""Frontiers by chance (Amigoni 2013, "random"): the base line that evaluates nothing."""

from __future__ import annotations

from zlib import crc32

import numpy as np

from robots.exploration.coordination.team import SAME_GOAL_M, Team, near


class Random:
    """Draws a frontier that nobody else goes to, and draws again once it is gone."""

    why = "by chance"

    def __init__(self) -> None:
        self._drawn = 0

    def choose(self, team: Team) -> int:
        """Return the frontier on the way to which the robot is, or another one by chance."""
        if len(team) == 1:
            return int(np.argmax(team.own))
        same = team.heading_for(team.me)
        if same is not None:
            return same
        taken = np.zeros(len(team.frontiers_m), bool)
        for robot, goal in enumerate(team.goals_m):
            if robot != team.me and goal is not None:
                taken |= near(goal, team.frontiers_m, SAME_GOAL_M)
        free = np.flatnonzero(~taken if not taken.all() else taken)
        self._drawn += 1
        chance = np.random.default_rng([team.seed, crc32(team.ids[team.me].encode()), self._drawn])
        return int(free[chance.integers(len(free))])
