"""The tag graph solved as it grows: an estimate after every pose, for a small part of a batch solution.

Minimises eq. (5) as ``graph.solve`` does, with the redescending kernel. See ``graph_panels`` for how.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robots.estimation.graph_checks import SETTLED, believable, bent, doubt_worst, weigh_again
from robots.estimation.graph_factors import between_jacobian, link_chi2
from robots.estimation.graph_fronts import eliminate, joint_covariance, substitute
from robots.estimation.graph_panels import (
    NAMES,
    NUMBERS,
    PANELS,
    Anchors,
    Links,
    Panels,
    Vertices,
    heights,
    move,
    no_panels,
    place,
    shortage,
    take_off,
)
from robots.estimation.graph_problem import LOOSE, GraphError, information_of
from robots.se2 import Array, wrap, wrap_array
from robots.types import IntArray

_FEW = 64
_URGENT_SD = 1.0
_ROUNDS = 4
_BY_PANEL = Panels._fields[:8]


class IncrementalGraph:
    """A tag graph that grows by ``add_...``; ``update`` moves the estimate to the minimum for all added.

    Poses and tags are numbered from 0, each on their own. Links are linearised anew where that is off by more
    than ``bend_sd`` deviations: at the next update, or at once where it is off by ``_URGENT_SD``. Changes
    below ``pass_sd`` deviations are not passed on. What is refused, with GraphError, leaves the graph as it
    was.
    """

    def __init__(self, kernel_sd: float = 3.0, bend_sd: float = 0.01, pass_sd: float = 0.02) -> None:
        self._kernel_sd, self._bend_sd, self._pass_sd = kernel_sd, bend_sd, pass_sd
        self._vertices = Vertices(
            np.zeros((_FEW, 3)), np.zeros((_FEW, 3)), np.zeros((_FEW, 3)), np.zeros((_FEW, 3)),
            np.zeros(_FEW, np.bool_), np.full(_FEW, -1), np.full(_FEW, -1), np.full(_FEW, -1),
        )  # fmt: skip
        self._links = Links(
            np.zeros((_FEW, 2), np.int64), np.zeros((_FEW, 3)), np.zeros((_FEW, 3, 3)),
            np.zeros(_FEW, np.bool_), np.ones(_FEW), np.full((_FEW, 2), -1),
        )  # fmt: skip
        self._anchors = Anchors(np.zeros((_FEW, 3)), np.zeros((_FEW, 3)), np.full(_FEW, -1))
        self._panels = no_panels(_FEW)
        self._count, self._link_count, self._anchor_count = 0, 0, 0
        self._solved = 0
        self._unheard: list[int] = []  # robust links since the last update
        self._refused: list[int] = []
        self._touched: list[int] = []
        self._bent: list[int] = []
        self._pose_vertex: list[int] = []
        self._tag_vertex: list[int] = []
        self._edges: list[int] = []  # links
        self._sightings: list[int] = []
        self._root: list[int] = []  # of the piece a vertex belongs to
        self._held: list[bool] = []

    def add_pose(self, initial: Sequence[float] | Array) -> int:
        """Add a pose vertex at (x, y, theta) and return its index."""
        x, y, theta = _finite(initial, 3, "the pose")
        self._pose_vertex.append(self._add_vertex(x, y, wrap(theta), False))
        return len(self._pose_vertex) - 1

    def add_tag(self, initial: Sequence[float] | Array) -> int:
        """Add a tag at (x, y) and return its index."""
        x, y = _finite(initial, 2, "the tag")
        self._tag_vertex.append(self._add_vertex(x, y, 0.0, True))
        return len(self._tag_vertex) - 1

    def add_edge(
        self,
        i: int,
        j: int,
        mean: Sequence[float] | Array,
        covariance: Array | None = None,
        information: Array | None = None,
        robust: bool = False,
    ) -> None:
        """Add the measured pose (3,) of pose j in the frame of pose i, by covariance or information."""
        a, b = _named(self._pose_vertex, i, "pose"), _named(self._pose_vertex, j, "pose")
        measured = _finite(mean, 3, "the edge")
        self._add_link(a, b, measured, information_of(covariance, information), robust)
        self._edges.append(self._link_count - 1)

    def add_sighting(self, i: int, k: int, offset: Sequence[float] | Array, covariance: Array) -> None:
        """Add the place (2,) of tag k in the frame of pose i, with its covariance (2, 2)."""
        a, b = _named(self._pose_vertex, i, "pose"), _named(self._tag_vertex, k, "tag")
        x, y = _finite(offset, 2, "the sighting")
        spread = np.eye(3)
        if np.shape(covariance) != (2, 2):
            raise GraphError("the covariance of a sighting has to be 2 x 2")
        spread[:2, :2] = covariance
        information = information_of(spread, None)
        information[2, 2] = 0.0
        self._add_link(a, b, (x, y, 0.0), information, True)
        self._sightings.append(self._link_count - 1)

    def add_prior(self, i: int, pose: Sequence[float] | Array, sds: Sequence[float] | Array) -> None:
        """Hold pose i at ``pose`` (3,) with deviations ``sds`` (3,)."""
        v = _named(self._pose_vertex, i, "pose")
        values, weights = _finite(pose, 3, "the prior"), _weights(_finite(sds, 3, "the prior's deviation"))
        self._add_anchor(v, values, weights)
        self._held[self._root_of(v)] = True

    def add_heading(self, i: int, heading_rad: float, sd_rad: float) -> None:
        """Add the measured heading of pose i."""
        v = _named(self._pose_vertex, i, "pose")
        (heading,) = _finite([heading_rad], 1, "the heading")
        (weight,) = _weights(_finite([sd_rad], 1, "the heading's deviation"))
        self._add_anchor(v, (0.0, 0.0, heading), (0.0, 0.0, weight))

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

    def pose(self, i: int) -> Array:
        """Return the estimate (3,) of one pose."""
        v = _named(self._pose_vertex, i, "pose")
        return np.asarray(self._vertices.state[v] + self._vertices.step[v])

    @property
    def edge_weights(self) -> Array:
        """How much each edge (k,) is believed, 0 to 1, as added."""
        return self._links.weight[np.array(self._edges, np.int64)]

    @property
    def poses(self) -> Array:
        """Estimated poses (n, 3)."""
        found = self._estimates(self._pose_vertex)
        found[:, 2] = wrap_array(found[:, 2])
        return found

    @property
    def tags(self) -> Array:
        """Estimated tags (m, 2)."""
        return self._estimates(self._tag_vertex)[:, :2]

    @property
    def chi2(self) -> float:
        """Sum of squares of all links at the estimate, without kernel."""
        return float(np.sum(self._squares()))

    def pose_covariance(self, i: int) -> Array:
        """Return the covariance (3, 3) of a pose at the last update."""
        return self._covariance(_named(self._pose_vertex, i, "pose"))

    def tag_covariance(self, k: int) -> Array:
        """Return the covariance (2, 2) of a tag at the last update."""
        return self._covariance(_named(self._tag_vertex, k, "tag"))[:2, :2]

    def relative_covariance(self, i: int, j: int) -> Array:
        """Return the covariance (3, 3) of pose j in the frame of pose i at the last update."""
        a, b = _named(self._pose_vertex, i, "pose"), _named(self._pose_vertex, j, "pose")
        joint = self._joint(a, b)
        J: Array = between_jacobian(*(self._vertices.state[v] + self._vertices.step[v] for v in (a, b)))
        covariance: Array = J @ joint @ J.T
        return covariance

    @property
    def edge_residuals(self) -> Array:
        """Mahalanobis distances (k,) of the edges from the estimate, in deviations, as added."""
        return np.sqrt(self._squares()[np.array(self._edges, np.int64)])

    @property
    def sighting_residuals(self) -> Array:
        """Mahalanobis distances (s,) of the sightings from the estimate, in deviations, as added."""
        return np.sqrt(self._squares()[np.array(self._sightings, np.int64)])

    def _covariance(self, v: int) -> Array:
        found: Array = self._joint(v, v)[:3, :3]
        return found

    def _joint(self, a: int, b: int) -> Array:
        if max(a, b) >= self._solved:
            raise GraphError("what was added since the last update has no covariance yet")
        return np.asarray(joint_covariance(self._vertices, self._panels, a, b))

    def _squares(self) -> Array:
        n, k = self._count, self._link_count
        estimate = self._vertices.state[:n] + self._vertices.step[:n]
        links = self._links
        squares = link_chi2(estimate, links.pairs[:k], links.measured[:k], links.information[:k])
        return np.asarray(np.maximum(squares, 0.0))

    def _estimates(self, names: list[int]) -> Array:
        index = np.array(names, np.int64)
        return self._vertices.state[index] + self._vertices.step[index]

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
            held = held._replace(free=free, free_count=_longer(held.free_count, 2 * tallest))
        count, names, numbers = shortage(held, height)
        count, names = count + int(held.counts[PANELS]), names + int(held.counts[NAMES])
        numbers += int(held.counts[NUMBERS])
        if count > len(held.start):
            grown = {name: _longer(getattr(held, name), 2 * count) for name in _BY_PANEL}
            held = held._replace(**grown)
        if names > len(held.names):
            held = held._replace(names=_longer(held.names, 2 * names))
        if numbers > len(held.numbers):
            held = held._replace(numbers=_longer(held.numbers, 2 * numbers))
        self._panels = held

    def _add_vertex(self, x: float, y: float, theta: float, is_tag: bool) -> int:
        v = self._count
        if v == len(self._vertices.state):
            self._vertices = Vertices(*(_longer(a, 2 * v) for a in self._vertices))
        vertices = self._vertices
        vertices.state[v] = x, y, theta
        vertices.is_tag[v] = is_tag
        vertices.link[v] = vertices.anchor[v] = vertices.panel[v] = -1
        self._root.append(v)
        self._held.append(False)
        self._count += 1
        return v

    def _add_link(self, a: int, b: int, measured: Sequence[float], information: Array, robust: bool) -> None:
        k = self._link_count
        if k == len(self._links.robust):
            self._links = Links(*(_longer(array, 2 * k) for array in self._links))
        links = self._links
        links.pairs[k] = a, b
        links.measured[k], links.information[k], links.robust[k] = measured, information, robust
        links.weight[k] = 1.0
        self._link_count += 1
        if a == b:
            return  # the error is what it is, nothing moves it
        if robust and self._root_of(a) == self._root_of(b):
            self._unheard.append(k)  # it must not bend others before it is held against them
        else:
            self._join(k)
            if information.any():
                a, b = self._root_of(a), self._root_of(b)
                self._root[max(a, b)] = min(a, b)
                self._held[min(a, b)] = self._held[a] or self._held[b]

    def _join(self, k: int) -> None:
        """Make a link part of the graph."""
        links, heads = self._links, self._vertices.link
        a, b = links.pairs[k].tolist()
        links.following[k] = heads[a], heads[b]
        heads[a] = heads[b] = k
        self._touch(a)
        self._touch(b)

    def _add_anchor(self, v: int, values: Sequence[float], weights: Sequence[float]) -> None:
        k = self._anchor_count
        if k == len(self._anchors.following):
            self._anchors = Anchors(*(_longer(array, 2 * k) for array in self._anchors))
        anchors = self._anchors
        anchors.values[k], anchors.weights[k], anchors.following[k] = (
            values,
            weights,
            self._vertices.anchor[v],
        )
        self._vertices.anchor[v] = k
        self._anchor_count += 1
        self._touch(v)

    def _touch(self, v: int) -> None:
        if v < self._solved:
            self._touched.append(v)

    def _root_of(self, v: int) -> int:
        root = self._root
        while root[v] != v:
            root[v] = root[root[v]]
            v = root[v]
        return v


def _longer(array: np.ndarray, size: int) -> np.ndarray:
    more = np.empty((size, *array.shape[1:]), array.dtype)
    more[: len(array)] = array
    more[len(array) :] = 0
    return more


def _named(names: list[int], index: int, kind: str) -> int:
    if not 0 <= index < len(names):
        raise GraphError(f"there is no {kind} {index}")
    return names[index]


def _finite(values: Sequence[float] | Array, count: int, what: str) -> list[float]:
    found = [float(value) for value in values]
    if len(found) != count or not all(np.isfinite(found)):
        raise GraphError(f"{what} has to be {count} finite numbers")
    return found


def _weights(sds: list[float]) -> list[float]:
    if min(sds) <= 0.0:
        raise GraphError("a deviation has to be greater than 0")
    return [1.0 / sd**2 for sd in sds]
