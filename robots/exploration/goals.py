"""Which edge of the unknown to go to, and which were put aside to be tried again later."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import hypot

from robots.config import ConfigError, PlanningConfig
from robots.exploration.coordination import coordination_of
from robots.exploration.coordination.original import ways_planned_alone
from robots.exploration.coordination.team import SAME_GOAL_M, Selfish, Team
from robots.exploration.frontiers import Frontier, Leg, find_frontiers
from robots.exploration.ground import Ground
from robots.exploration.strategies import STRATEGIES
from robots.exploration.strategy import (
    AnswersTags,
    ExplorationView,
    KeepsGoals,
    OwnCandidates,
    Strategy,
)
from robots.exploration.team.communication import Communication
from robots.orders import Methods
from robots.planning.travel import UNREACHED
from robots.types import FrontierReport

MAX_REPORTED = 48
_ARRIVED_M = 0.4
_ASIDE_M = 0.7
_ASIDE_S = (20.0, 60.0)  # a goal that came to nothing is tried again after so long, and then again
_HINDERED_S, _HINDRANCES = 20.0, 8  # one that others kept the robot from: that says nothing of the goal
_TIMES_CHOSEN = 3
_TRIES = 1 + len(_ASIDE_S)
_FORGOTTEN_S = 600.0  # and once more after so long: what stood in the way may have gone


Place = tuple[float, float]


@dataclass(slots=True)
class _Aside:
    x: float
    y: float
    until_s: float = 0.0
    tries: int = 0
    hindrances: int = 0

    @property
    def is_given_up(self) -> bool:
        return self.tries >= _TRIES or self.hindrances >= _HINDRANCES


@dataclass(frozen=True, slots=True)
class Choice:
    """A frontier to go to and why, in words after "driving 3 m to"."""

    frontier: Frontier
    why: str


def strategy_of(name: str) -> Strategy:
    """Return a strategy by its name. Raises ConfigError: there is none of that name."""
    if name not in STRATEGIES:
        known = ", ".join(sorted(STRATEGIES))
        raise ConfigError(f"planning.explore: no strategy is called {name!r}; known are {known}")
    return STRATEGIES[name]()


class Goals:
    """Weighs edges of the unknown by a strategy, keeps to the one chosen, puts aside what comes to nothing.

    ``goal_m`` (x, y) in the map frame; ``reports`` the edges of the last plan, best first.
    """

    def __init__(self, planning: PlanningConfig, communication: Communication) -> None:
        self.strategy = strategy_of(planning.explore)
        self.coordination = coordination_of(planning.coordinate)
        self._communication = communication
        self.goal_m: tuple[float, float] | None = None
        self.reports: tuple[FrontierReport, ...] = ()
        self._chosen: list[Place] = []  # when the goal was another before
        self.view: ExplorationView | None = None  # at the last choice, where the strategy answers tags by it
        self._why = ""
        self._planned = 0
        self._aside: list[_Aside] = []

    def change(self, methods: Methods) -> None:
        """Go on by other methods; an empty name leaves one as it is. Names are known ones."""
        if methods.explore:
            self.strategy = strategy_of(methods.explore)
        if methods.coordinate:
            self.coordination = coordination_of(methods.coordinate)
        if methods.communication:
            self._communication.kind = methods.communication

    def put_aside(self, goal_m: tuple[float, float], now_s: float, hindered: bool = False) -> None:
        """Leave a goal (map frame) for a while: being there did not help. Every time for longer.

        ``hindered``: the robot was kept from getting there.
        """
        known = self._aside_at(goal_m)
        if known is None:
            known = _Aside(*goal_m)
            self._aside.append(known)
        known.tries += not hindered
        known.hindrances += hindered
        wait_s = _HINDERED_S if hindered else (*_ASIDE_S, _FORGOTTEN_S)[min(known.tries, _TRIES) - 1]
        known.until_s = now_s + (_FORGOTTEN_S if known.is_given_up else wait_s)
        self.goal_m = None

    def left_over(self, frontiers: Sequence[Frontier], now_s: float) -> tuple[str, bool]:
        """Say in words that there is nothing to go to now but these, and whether one is tried again later."""
        edges = "1 edge" if len(frontiers) == 1 else f"{len(frontiers)} edges"
        asides = [aside for f in frontiers if (aside := self._aside_at(f.goal_m)) is not None]
        left = [aside.until_s - now_s for aside in asides if not aside.is_given_up]
        if left:
            again_s = max(0.0, min(left))
            return (
                f"{edges} of the unknown could not be seen beyond yet; trying again in {again_s:.0f} s",
                True,
            )
        if frontiers:
            is_ = "is" if len(frontiers) == 1 else "are"
            return f"{edges} of the unknown {is_} left that I could not see beyond", False
        return "no edge of the unknown is left that I can reach", False

    def edges(self, ground: Ground, min_frontier_m: float, now_s: float) -> tuple[Frontier, ...]:
        """Return the frontiers that can be reached, nearest first."""
        self._aside = [a for a in self._aside if not a.is_given_up or a.until_s > now_s]
        return find_frontiers(ground.grid, ground.costs, min_frontier_m)

    def worth_going(self, frontiers: Sequence[Frontier], now_s: float) -> tuple[Frontier, ...]:
        """Return those that are not put aside now."""
        return tuple(
            f for f in frontiers if (aside := self._aside_at(f.goal_m)) is None or aside.until_s <= now_s
        )

    def untried(self, frontiers: Sequence[Frontier]) -> tuple[Frontier, ...]:
        """Return those that were never put aside."""
        return tuple(f for f in frontiers if self._aside_at(f.goal_m) is None)

    def look_at(self, frontiers: Sequence[Frontier], now_s: float, why: str) -> Choice | None:
        """Return the first of some places to look at that is not put aside, and ``why`` it is gone to."""
        for frontier in self.worth_going(frontiers, now_s):
            return Choice(frontier, why)
        return None

    def choose(self, view: ExplorationView) -> Choice | None:
        """Return the frontier to go to in view of the robots that are heard, None where there is none.

        The old goal is kept while its frontier is still there and nothing much better has come up; by a
        strategy that keeps its goals until the robot is there.
        """
        kept = self._kept(view)
        if kept is not None:
            return kept
        trail, ways = self._communication.mates_trail(), self._communication.mates_ways(view.now_s)
        aside = tuple((aside.x, aside.y) for aside in self._aside if aside.until_s > view.now_s)
        view = replace(view, mates_trail=trail, mates_ways=ways, goal_m=self.goal_m, aside_m=aside)
        view = self._with_candidates(view)
        self.view = view if isinstance(self.strategy, AnswersTags) else None
        if not view.frontiers:
            return None
        goal_m = None if isinstance(self.strategy, KeepsGoals) else self.goal_m
        team = self._communication.team(view, self.strategy, goal_m)
        best = self.coordination.choose(team)
        chosen = view.frontiers[best]
        if self._draws_back(chosen.goal_m):
            self.put_aside(chosen.goal_m, view.now_s, hindered=True)
            return self.choose(replace(view, frontiers=self.worth_going(view.frontiers, view.now_s)))
        self._planned += self._ways_planned(team, chosen)
        self.reports = _reports(view.frontiers, [float(worth) for worth in team.own], best)
        self._why = self.strategy.reason(view, best)
        if team.own[best] < team.own.max():
            self._why += f", {self.coordination.why}"
        return Choice(chosen, self._why)

    def _draws_back(self, goal_m: Place) -> bool:
        """Say whether a goal was taken in place of another too often: an edge that comes and goes."""
        if self.goal_m is None or _apart(goal_m, self.goal_m) < SAME_GOAL_M:
            return False
        self._chosen.append(goal_m)
        if sum(_apart(goal_m, place) < _ASIDE_M for place in self._chosen) <= _TIMES_CHOSEN:
            return False
        self._chosen = [place for place in self._chosen if _apart(place, goal_m) >= _ASIDE_M]
        return True

    def take_planned(self) -> int:
        """Return how many ways were planned to choose goals since this was last asked (Amigoni 2013, 3.3)."""
        planned, self._planned = self._planned, 0
        return planned

    def _ways_planned(self, team: Team, chosen: Frontier) -> int:
        if isinstance(self.strategy, KeepsGoals):
            return ways_planned_alone(team) if isinstance(self.coordination, Selfish) else team.planned
        if isinstance(chosen, Leg):
            return 0 if chosen.begun else team.floods
        goal = self.goal_m
        same = (
            goal is not None and hypot(goal[0] - chosen.goal_m[0], goal[1] - chosen.goal_m[1]) < SAME_GOAL_M
        )
        return 0 if same else team.floods

    def _kept(self, view: ExplorationView) -> Choice | None:
        """Return the goal that the robot is on its way to where its strategy decides on arrival alone."""
        goal, grid, costs = self.goal_m, view.grid, view.costs
        if not isinstance(self.strategy, KeepsGoals) or goal is None or grid is None or costs is None:
            return None
        cell = grid.cell_of(*goal)
        arrived = hypot(goal[0] - view.pose.x, goal[1] - view.pose.y) < _ARRIVED_M
        if arrived or not grid.holds(*cell) or costs[cell] == UNREACHED:
            return None
        cost_m = float(costs[cell]) / 5.0 * grid.cell_m
        return Choice(Frontier(cell, goal, 0.0, cost_m), self._why)

    def _with_candidates(self, view: ExplorationView) -> ExplorationView:
        """Return the view with the strategy's own candidates, where it has any."""
        if not isinstance(self.strategy, OwnCandidates):
            return view
        own = self.worth_going(self.strategy.candidates(view), view.now_s)
        return replace(view, frontiers=own or view.frontiers[:1])

    def _aside_at(self, goal_m: tuple[float, float]) -> _Aside | None:
        near = [a for a in self._aside if hypot(goal_m[0] - a.x, goal_m[1] - a.y) < _ASIDE_M]
        return max(near, key=lambda aside: aside.until_s, default=None)


def _apart(a: Place, b: Place) -> float:
    return hypot(a[0] - b[0], a[1] - b[1])


def _reports(frontiers: Sequence[Frontier], worths: list[float], chosen: int) -> tuple[FrontierReport, ...]:
    """Return the best of them, bounded, the chosen one always among them."""
    order = sorted(range(len(worths)), key=lambda k: (k != chosen, -worths[k], k))[:MAX_REPORTED]
    return tuple(
        FrontierReport(frontiers[k].goal_m, frontiers[k].length_m, worths[k], k == chosen) for k in order
    )
