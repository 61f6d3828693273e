"""Which edge of the unknown to go to, and which were put aside to be tried again later."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import hypot

import numpy as np

from robots.config import ConfigError
from robots.exploration.frontiers import Frontier, find_frontiers, find_shut_off
from robots.exploration.ground import Ground
from robots.exploration.strategies import STRATEGIES
from robots.exploration.strategy import ExplorationView, OwnCandidates, Strategy
from robots.types import FrontierReport

MAX_REPORTED = 48
_SAME_GOAL_M = 1.2  # a frontier this near to the old goal is what the old goal has become
_KEEP_UNLESS = 0.4  # the old goal is kept unless another is worth more by this share of the way to it
_ASIDE_M = 0.7
_ASIDE_S = (20.0, 60.0)  # a goal that came to nothing is tried again after so long, and then again
_SWITCHES = 3  # an edge that comes and goes draws a robot back so often, then it is put aside
_TRIES = 1 + len(_ASIDE_S)
_FORGOTTEN_S = 600.0  # and once more after so long: what stood in the way may have gone


@dataclass(slots=True)
class _Aside:
    x: float
    y: float
    until_s: float
    tries: int


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

    def __init__(self, strategy: Strategy) -> None:
        self.strategy = strategy
        self.goal_m: tuple[float, float] | None = None
        self.reports: tuple[FrontierReport, ...] = ()
        self._chosen: list[tuple[float, float]] = []  # every goal that another was left for
        self._aside: list[_Aside] = []

    def put_aside(self, goal_m: tuple[float, float], now_s: float) -> None:
        """Leave a goal (map frame) for a while: being there did not help. Every time for longer."""
        known = self._aside_at(goal_m)
        if known is None:
            known = _Aside(*goal_m, until_s=0.0, tries=0)
            self._aside.append(known)
        known.tries += 1
        known.until_s = now_s + (*_ASIDE_S, _FORGOTTEN_S)[known.tries - 1]
        self.goal_m = None

    def waiting(self, frontiers: Sequence[Frontier], now_s: float) -> float | None:
        """Return in how many seconds one of these is tried again; None where all were tried often enough."""
        asides = [aside for f in frontiers if (aside := self._aside_at(f.goal_m)) is not None]
        left = [aside.until_s - now_s for aside in asides if aside.tries < _TRIES]
        return max(0.0, min(left)) if left else None

    def edges(self, ground: Ground, min_frontier_m: float, now_s: float) -> tuple[Frontier, ...]:
        """Return the frontiers that can be reached, nearest first."""
        self._aside = [a for a in self._aside if a.tries < _TRIES or a.until_s > now_s]
        return find_frontiers(ground.grid, ground.costs, min_frontier_m)

    def shut_off(self, ground: Ground, min_frontier_m: float) -> tuple[Frontier, ...]:
        """Return the frontiers that cannot be reached, nearest first."""
        return find_shut_off(ground.grid, ground.costs, min_frontier_m)

    def worth_going(self, frontiers: Sequence[Frontier], now_s: float) -> tuple[Frontier, ...]:
        """Return those that are not put aside now."""
        return tuple(
            f for f in frontiers if (aside := self._aside_at(f.goal_m)) is None or aside.until_s <= now_s
        )

    def choose(self, view: ExplorationView) -> Choice | None:
        """Return the frontier that is worth most, None where there is none.

        The old goal is kept while its frontier is still there and nothing much better has come up.
        """
        if not view.frontiers:
            return None
        view = self._with_candidates(view)
        worths = self.strategy.worths(view)
        best = int(np.argmax(worths))
        if self.goal_m is not None:
            x, y = self.goal_m
            far = [hypot(f.goal_m[0] - x, f.goal_m[1] - y) for f in view.frontiers]
            same = int(np.argmin(far))
            gained = worths[best] - worths[same]
            if far[same] < _SAME_GOAL_M and gained <= _KEEP_UNLESS * view.frontiers[same].cost_m:
                best = same
        chosen = view.frontiers[best]
        if self._is_anew(chosen.goal_m) and self._times(chosen.goal_m) > _SWITCHES:
            self.put_aside(chosen.goal_m, view.now_s)
            self._chosen = [place for place in self._chosen if _apart(place, chosen.goal_m) >= _ASIDE_M]
            left = (*view.frontiers[:best], *view.frontiers[best + 1 :])
            return self.choose(replace(view, frontiers=self.worth_going(left, view.now_s)))
        self.reports = _reports(view.frontiers, [float(worth) for worth in worths], best)
        return Choice(chosen, self.strategy.reason(view, best))

    def _is_anew(self, goal_m: tuple[float, float]) -> bool:
        """Say whether another goal was driven to before; note that this one is from now on."""
        if self.goal_m is not None and _apart(goal_m, self.goal_m) < _SAME_GOAL_M:
            return False
        self._chosen.append(goal_m)
        return True

    def _times(self, goal_m: tuple[float, float]) -> int:
        return sum(_apart(goal_m, place) < _ASIDE_M for place in self._chosen)

    def _with_candidates(self, view: ExplorationView) -> ExplorationView:
        """Return the view with the strategy's own candidates, where it has any."""
        if not isinstance(self.strategy, OwnCandidates):
            return view
        own = self.worth_going(self.strategy.candidates(view), view.now_s)
        return replace(view, frontiers=own or view.frontiers[:1])

    def _aside_at(self, goal_m: tuple[float, float]) -> _Aside | None:
        near = [a for a in self._aside if hypot(goal_m[0] - a.x, goal_m[1] - a.y) < _ASIDE_M]
        return max(near, key=lambda aside: aside.until_s, default=None)


def _apart(a: tuple[float, float], b: tuple[float, float]) -> float:
    return hypot(a[0] - b[0], a[1] - b[1])


def _reports(frontiers: Sequence[Frontier], worths: list[float], chosen: int) -> tuple[FrontierReport, ...]:
    """Return the best of them, bounded, the chosen one always among them."""
    order = sorted(range(len(worths)), key=lambda k: (k != chosen, -worths[k], k))[:MAX_REPORTED]
    return tuple(
        FrontierReport(frontiers[k].goal_m, frontiers[k].length_m, worths[k], k == chosen) for k in order
    )
