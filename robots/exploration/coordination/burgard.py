"""Utilities that fall where others will look (Burgard et al. 2005, Coordinated multi-robot exploration)."""

from __future__ import annotations

import numpy as np

from robots.exploration.coordination.team import NEVER, Team

UTILITY_M = 8.0  # of way that a frontier's whole utility, 1, is worth: 1 / beta


class Burgard:
    """Algorithm 1, with the strategy's worth in place of a utility that is 1 everywhere less beta V."""

    why = "where nobody else will look"

    def choose(self, team: Team) -> int:
        """Return this robot's frontier."""
        if len(team) == 1:
            return int(np.argmax(team.own))
        worths = team.worths
        apart = np.hypot(*(team.frontiers_m[:, None] - team.frontiers_m[None]).transpose(2, 0, 1))
        seen = np.clip(1.0 - apart / team.reach_m, 0.0, None)  # P(d): how likely one is seen from another
        utilities = np.ones(len(team.frontiers_m))
        while worths.max() > NEVER:
            value = worths + UTILITY_M * (utilities - 1.0)
            robot, frontier = np.unravel_index(int(np.argmax(value)), value.shape)
            if robot == team.me:
                return int(frontier)
            utilities -= seen[frontier]
            worths[robot, :] = NEVER
        return int(np.argmax(team.own))
