"""The tag graph solved as it grows: an estimate after every pose, for a small part of a batch solution.

Minimises eq. (5) as ``graph.solve`` does, with the redescending kernel. See ``graph_panels`` for how.
"""

from __future__ import annotations

import numpy as np

from robots.estimation.graph.checks import SETTLED, believable, bent, doubt_worst, weigh_again
from robots.estimation.graph.factors import between_jacobian
from robots.estimation.graph.fronts import eliminate, joint_covariance, substitute
from robots.estimation.graph.growing import GrowingGraph, longer, named
from robots.estimation.graph.panels import (
    NAMES,
    NUMBERS,
    PANELS,
    Panels,
    heights,
    move,
    no_panels,
    place,
    shortage,
    take_off,
)
from robots.estimation.graph.problem import LOOSE, GraphError
from robots.graph_report import IntArray
from robots.se2 import Array

_FEW = 64
_URGENT_SD = 1.0
_ROUNDS = 4
_BY_PANEL = Panels._fields[:8]


class IncrementalGraph(GrowingGraph):
    """A tag graph that grows by ``add_...``; ``update`` moves the estimate to the minimum for all added.

    Poses and tags are numbered from 0, each on their own. Links are linearised anew where that is off by more
    than ``bend_sd`` deviations: at the next update, or at once where it is off by ``_URGENT_SD``. Changes
    below ``pass_sd`` deviations are not passed on. What is refused, with GraphError, leaves the graph as it
    was.
    """

    def __init__(self, kernel_sd: float = 3.0, bend_sd: float = 0.01, pass_sd: float = 0.02) -> None:
        self._kernel_sd, self._bend_sd, self._pass_sd = kernel_sd, bend_sd, pass_sd
        super().__init__()
        self._panels = no_panels(_FEW)

    def update(self) -> None:
        """Move the estimate to the minimum for all that was added.

        Raises:
            GraphError: a new vertex is joined to nothing that a prior holds; add what is missing.
        """
        if not all(self._held[self._root_of(v)] for v in range(self._solved, self._count)):
            raise GraphError(LOOSE)
        old = self._solved
        bent_before = np.array(self._bent, np.int64)
        touched = np.array(self._touched, np.int64)
        self._touched, self._bent, self._solved = [], [], self._count
        concerned = np.concatenate([touched, move(self._vertices, self._links, bent_before)])
        self._descend(concerned, old, self._bend_sd, self._pass_sd, _ROUNDS)

    def settle(self, rounds: int = 50) -> None:
        """Descend until nothing moves any more: the estimate is then that of a batch solution."""
        self.update()
        everything = np.arange(self._count)
        for _ in range(rounds):
            before = self._squares().sum()
            move(self._vertices, self._links, everything)
            self._descend(everything, self._count, np.inf, 0.0, 1, 0.0)
            if abs(self._squares().sum() - before) <= 1e-9 * before:
                refused, self._refused = self._refused, []
                if not self._hear(refused):
                    break
                self._touched = []  # everything is eliminated anew in any case

    def _hear(self, waiting: list[int]) -> bool:
        """Make those robust links part of the graph that all others allow; say whether there are any."""
        found = believable(self._vertices, self._links, self._panels, waiting, self._kernel_sd)
        for k in found:
            self._join(k)
        self._refused += sorted(set(waiting) - set(found))
        return len(found) > 0

    def doubt(self) -> bool:
        """Let go of the robust link that all others contradict the most; say whether there was one.

        Covers what looked right when it was added. Costs two ways along the tree a robust link: for the end
        of a mission, again and again until it says no, not for every update.
        """
        self.update()
        doubted = doubt_worst(self._vertices, self._links, self._panels, self._link_count, self._kernel_sd)
        if len(doubted):
            self._descend(doubted, self._count, self._bend_sd, self._pass_sd, _ROUNDS)
        return len(doubted) > 0

    def _descend(
        self,
        concerned: IntArray,
        old: int,
        bend_sd: float,
        pass_sd: float,
        rounds: int,
        least: float = SETTLED,
    ) -> None:
        """Eliminate anew what is concerned, then what that bends or lets be doubted, while it is urgent."""
        for k in range(rounds):
            changed = self._rebuild(concerned, old, pass_sd)
            doubted = weigh_again(self._vertices, self._links, changed, self._kernel_sd, least)
            if self._unheard:
                self._hear(self._unheard)
                doubted = np.concatenate([doubted, np.array(self._touched, np.int64)])
                self._unheard, self._touched = [], []
            crooked, worst = bent(self._vertices, self._links, changed, bend_sd)
            urgent = len(doubted) > 0 or worst > _URGENT_SD
            if k == rounds - 1 or not urgent:
                self._bent.extend(crooked.tolist())
                self._touched.extend(doubted.tolist())
                return
            concerned, old = (
                np.concatenate([doubted, move(self._vertices, self._links, crooked)]),
                self._count,
            )

    def pose_covariance(self, i: int) -> Array:
        """Return the covariance (3, 3) of a pose at the last update."""
        return self._covariance(named(self._pose_vertex, i, "pose"))

    def tag_covariance(self, k: int) -> Array:
        """Return the covariance (2, 2) of a tag at the last update."""
        return self._covariance(named(self._tag_vertex, k, "tag"))[:2, :2]

    def relative_covariance(self, i: int, j: int) -> Array:
        """Return the covariance (3, 3) of pose j in the frame of pose i at the last update."""
        a, b = named(self._pose_vertex, i, "pose"), named(self._pose_vertex, j, "pose")
        joint = self._joint(a, b)
        J: Array = between_jacobian(*(self._vertices.state[v] + self._vertices.step[v] for v in (a, b)))
        covariance: Array = J @ joint @ J.T
        return covariance

    def _covariance(self, v: int) -> Array:
        found: Array = self._joint(v, v)[:3, :3]
        return found

    def _joint(self, a: int, b: int) -> Array:
        if max(a, b) >= self._solved:
            raise GraphError("what was added since the last update has no covariance yet")
        return np.asarray(joint_covariance(self._vertices, self._panels, a, b))

    def _rebuild(self, touched: IntArray, old: int, pass_sd: float) -> IntArray:
        """Eliminate anew from ``touched`` vertices to the root, with the new ones; return what changed."""
        top = take_off(self._vertices, self._links, self._panels, touched, old, self._count)
        height = heights(top)
        self._make_room(height)
        new = place(self._vertices, self._panels, top, height)
        eliminate(self._vertices, self._links, self._anchors, self._panels, new)
        changed: IntArray = substitute(self._vertices, self._panels, new, pass_sd)
        return changed

    def _make_room(self, height: IntArray) -> None:
        held = self._panels
        tallest = int(height.max(initial=0))
        if tallest >= len(held.free):
            free = np.full(2 * tallest, -1)
            free[: len(held.free)] = held.free
            held = held._replace(free=free, free_count=longer(held.free_count, 2 * tallest))
        count, names, numbers = shortage(held, height)
        count, names = count + int(held.counts[PANELS]), names + int(held.counts[NAMES])
        numbers += int(held.counts[NUMBERS])
        if count > len(held.start):
            grown = {name: longer(getattr(held, name), 2 * count) for name in _BY_PANEL}
            held = held._replace(**grown)
        if names > len(held.names):
            held = held._replace(names=longer(held.names, 2 * names))
        if numbers > len(held.numbers):
            held = held._replace(numbers=longer(held.numbers, 2 * numbers))
        self._panels = held
