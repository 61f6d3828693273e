"""Waymark's own: the shortest way to ground that nobody has told of, through what others have covered.

A frontier in claimed ground is worth going to for what lies beyond, so covered ground is crossed quickly, or
left to those who are there. Tags tell what was known when they were written: where others went and drove,
more will have been seen since, so robots keep away from there too. Nothing is struck off: a tag may be wrong,
and a robot that has nothing better to do looks for itself.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from robots.exploration.frontiers import Frontier
from robots.exploration.strategies.information_gain import SEEN_M, SQUARE_M2, WORTH_M
from robots.exploration.strategies.sweep import Sweep
from robots.exploration.strategy import ExplorationView, goals_of, ways_of
from robots.exploration.told.claims import FROM_AFAR_M, driven
from robots.exploration.told.far_sight import FarFrontier, FarSight
from robots.exploration.told.outlook import ways_beyond
from robots.se2 import Array

_DETOUR = 1.5  # what a metre through claimed ground costs: nothing is known of its walls
_FARTHEST_M = 15.0  # beyond claimed ground: farther counts alike
_JUST_DRIVEN = 16  # points of the robot's own trail, 4 m, that say nothing yet
# a tag read under its feet knows of the ground ahead what its writer did: so much it costs to follow
_ALONG_M = 4.0
_TAKEN_M, _TAKEN_WITHIN_M = 6.0, 4.0  # what it costs to go where others went, and how near that is


class Waymark:
    """Weighs ways to frontiers and beyond them against what nobody has told of and where others are."""

    def __init__(self) -> None:
        self._far = FarSight()
        self._sweep = Sweep()

    def candidates(self, view: ExplorationView) -> tuple[Frontier, ...]:
        """Return the frontiers; with a small map, those beyond which nothing is covered, or ways far off."""
        if view.settings.safe.sweep:
            return self._sweep.candidates(view)
        return self._far.candidates(view) if view.settings.local_map_m else view.frontiers

    def worths(self, view: ExplorationView) -> Array:
        """Return what is to be seen less the way, the way beyond, and what others took upon themselves."""
        if view.settings.safe.sweep:
            return self._sweep.worths(view)
        if view.settings.local_map_m:  # what is claimed was left out
            return WORTH_M * self._far.untold(places_of(view), SEEN_M) - ways_of(view)
        return _prospects(view) - ways_of(view)

    def reason(self, view: ExplorationView, index: int) -> str:
        """Return how much is to be seen, or why it goes where others were."""
        if view.settings.safe.sweep:
            area_m2 = self._sweep.gains(view)[index]
            return f"make about {area_m2:.0f} m² of ground safe on the way"
        if isinstance(view.frontiers[index], FarFrontier):
            return "ground that was left open, along tags"
        untold, claimed = (shares[index] for shares in view.survey.shares(goals_of(view), SEEN_M))
        if claimed <= untold:
            return f"see about {untold * SQUARE_M2:.0f} m² {_of_whom(view)}{_elsewhere(view, index)}"
        beyond = float(_beyond(view)[index])
        if beyond >= _FARTHEST_M:
            return "check ground that tags call covered: nothing else is left"
        return f"cross covered ground to what {'' if beyond < 1.0 else f'{beyond:.0f} m '}beyond it is open"


def promised(view: ExplorationView) -> Array:
    """Return how near, 0 to 1, each frontier is to a place where another robot said it went, (n,)."""
    return _nearness(goals_of(view), view.survey.promised)


def trodden(view: ExplorationView) -> Array:
    """Return how near, 0 to 1, each frontier is to where robots drove, this one or those it read of, (n,)."""
    return _nearness(goals_of(view), _trails(view))


def _prospects(view: ExplorationView) -> Array:
    """Return what is to be seen at frontiers, or beyond claimed ground less the way through it, (n,)."""
    survey = view.survey
    if view.grid is None or not survey.claimed.any():
        untold, _ = survey.shares(goals_of(view), SEEN_M)
        return WORTH_M * untold - _TAKEN_M * (promised(view) + trodden(view))
    taken = survey.nearness(survey.promised, _TAKEN_WITHIN_M) + survey.nearness(
        _trails(view), _TAKEN_WITHIN_M
    )
    lost = WORTH_M * (1.0 - survey.untold(SEEN_M)) + _TAKEN_M * taken
    cells = np.array([frontier.goal for frontier in view.frontiers]).reshape(-1, 2)
    most_m = _FARTHEST_M + WORTH_M / _DETOUR
    worths: Array = WORTH_M - _DETOUR * ways_beyond(view.grid, survey, cells, most_m, lost / _DETOUR)
    if view.tag_reach_m < FROM_AFAR_M:
        worths -= _ALONG_M * (promised(view) + trodden(view))
    return worths


def _trails(view: ExplorationView) -> Array:
    """Return where robots drove, this one or those it read of, (n, 2)."""
    return np.concatenate([view.trail[:-_JUST_DRIVEN, :2], driven(view.tags)])


def places_of(view: ExplorationView) -> Array:
    """Return where the new ground is, (n, 2), of each candidate."""
    places = [f.at_m if isinstance(f, FarFrontier) else f.goal_m for f in view.frontiers]
    return np.array(places).reshape(-1, 2)


def _beyond(view: ExplorationView) -> Array:
    if view.grid is None:
        return np.zeros(len(view.frontiers))
    cells = np.array([frontier.goal for frontier in view.frontiers]).reshape(-1, 2)
    return ways_beyond(view.grid, view.survey, cells, _FARTHEST_M)


def _nearness(goals: Array, places: Array) -> Array:
    if len(places) == 0 or len(goals) == 0:
        return np.zeros(len(goals))
    near: Array = np.maximum(0.0, 1.0 - np.sqrt(_squared_gaps(goals, places)) / _TAKEN_WITHIN_M)
    return near


@njit(cache=True)
def _squared_gaps(goals: Array, places: Array) -> Array:
    """Return the squared distance of each goal (n, 2) to the nearest place (m, 2), (n,)."""
    gaps = np.full(len(goals), np.inf)
    for k in range(len(goals)):
        for m in range(len(places)):
            dx, dy = goals[k, 0] - places[m, 0], goals[k, 1] - places[m, 1]
            gaps[k] = min(gaps[k], dx * dx + dy * dy)
    return gaps


def _of_whom(view: ExplorationView) -> str:
    return "that nobody has told of" if view.tags else "of new ground"


def _elsewhere(view: ExplorationView, index: int) -> str:
    """Return which way is left to others, where the nearest frontier is passed over for what tags say."""
    if index == 0 or not view.tags:
        return ""
    passed = view.frontiers[0].goal_m
    _, claimed = view.survey.shares(goals_of(view), SEEN_M)
    near_others = promised(view) + trodden(view)
    taken = float(near_others[0]) > float(near_others[index])
    if claimed[0] < 0.25 and not taken:
        return ""
    said = "is covered" if claimed[0] >= 0.25 else "is taken"
    chosen = view.frontiers[index].goal_m
    return f": tags say the {_towards(view, passed)} {said}, going {_towards(view, chosen)}"


def _towards(view: ExplorationView, point: tuple[float, float]) -> str:
    """Return the direction of a point; x points north, y west."""
    north, west = point[0] - view.pose.x, point[1] - view.pose.y
    if abs(north) >= abs(west):
        return "north" if north >= 0.0 else "south"
    return "west" if west >= 0.0 else "east"
