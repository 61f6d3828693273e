"""What an incremental graph holds: vertices, links and anchors in arrays that grow by doubling."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robots.estimation.graph.factors import link_chi2
from robots.estimation.graph.panels import Anchors, Links, Vertices
from robots.estimation.graph.problem import GraphError, information_of
from robots.se2 import Array, wrap, wrap_array

_FEW = 64


class GrowingGraph:
    """Poses and tags, numbered from 0 each on their own, what was measured, and the estimate."""

    def __init__(self) -> None:
        self._vertices = Vertices(
            np.zeros((_FEW, 3)), np.zeros((_FEW, 3)), np.zeros((_FEW, 3)), np.zeros((_FEW, 3)),
            np.zeros(_FEW, np.bool_), np.full(_FEW, -1), np.full(_FEW, -1), np.full(_FEW, -1),
        )  # fmt: skip
        self._links = Links(
            np.zeros((_FEW, 2), np.int64), np.zeros((_FEW, 3)), np.zeros((_FEW, 3, 3)),
            np.zeros(_FEW, np.bool_), np.ones(_FEW), np.full((_FEW, 2), -1),
        )  # fmt: skip
        self._anchors = Anchors(np.zeros((_FEW, 3)), np.zeros((_FEW, 3)), np.full(_FEW, -1))
        self._count, self._link_count, self._anchor_count = 0, 0, 0
        self._solved = 0  # so many vertices were there at the last update
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
        a, b = named(self._pose_vertex, i, "pose"), named(self._pose_vertex, j, "pose")
        measured = _finite(mean, 3, "the edge")
        self._add_link(a, b, measured, information_of(covariance, information), robust)
        self._edges.append(self._link_count - 1)

    def add_sighting(self, i: int, k: int, offset: Sequence[float] | Array, covariance: Array) -> None:
        """Add the place (2,) of tag k in the frame of pose i, with its covariance (2, 2)."""
        a, b = named(self._pose_vertex, i, "pose"), named(self._tag_vertex, k, "tag")
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
        v = named(self._pose_vertex, i, "pose")
        values, weights = _finite(pose, 3, "the prior"), _weights(_finite(sds, 3, "the prior's deviation"))
        self._add_anchor(v, values, weights)
        self._held[self._root_of(v)] = True

    def add_heading(self, i: int, heading_rad: float, sd_rad: float) -> None:
        """Add the measured heading of pose i."""
        v = named(self._pose_vertex, i, "pose")
        (heading,) = _finite([heading_rad], 1, "the heading")
        (weight,) = _weights(_finite([sd_rad], 1, "the heading's deviation"))
        self._add_anchor(v, (0.0, 0.0, heading), (0.0, 0.0, weight))

    def pose(self, i: int) -> Array:
        """Return the estimate (3,) of one pose."""
        v = named(self._pose_vertex, i, "pose")
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

    @property
    def edge_residuals(self) -> Array:
        """Mahalanobis distances (k,) of the edges from the estimate, in deviations, as added."""
        return np.sqrt(self._squares()[np.array(self._edges, np.int64)])

    @property
    def sighting_residuals(self) -> Array:
        """Mahalanobis distances (s,) of the sightings from the estimate, in deviations, as added."""
        return np.sqrt(self._squares()[np.array(self._sightings, np.int64)])

    def _squares(self) -> Array:
        n, k = self._count, self._link_count
        estimate = self._vertices.state[:n] + self._vertices.step[:n]
        links = self._links
        squares = link_chi2(estimate, links.pairs[:k], links.measured[:k], links.information[:k])
        return np.asarray(np.maximum(squares, 0.0))

    def _estimates(self, names: list[int]) -> Array:
        index = np.array(names, np.int64)
        return self._vertices.state[index] + self._vertices.step[index]

    def _add_vertex(self, x: float, y: float, theta: float, is_tag: bool) -> int:
        v = self._count
        if v == len(self._vertices.state):
            self._vertices = Vertices(*(longer(a, 2 * v) for a in self._vertices))
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
            self._links = Links(*(longer(array, 2 * k) for array in self._links))
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
            self._anchors = Anchors(*(longer(array, 2 * k) for array in self._anchors))
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


def longer(array: np.ndarray, size: int) -> np.ndarray:
    """Return the array with room for ``size`` rows; new ones are 0."""
    more = np.empty((size, *array.shape[1:]), array.dtype)
    more[: len(array)] = array
    more[len(array) :] = 0
    return more


def named(names: list[int], index: int, kind: str) -> int:
    """Return the vertex of a pose or tag; GraphError where there is none."""
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
