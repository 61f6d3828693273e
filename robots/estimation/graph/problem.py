"""What a tag graph is given as, and the check of it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numba import njit

from robots.estimation.graph.factors import BoolArray, Factors
from robots.graph_report import IntArray
from robots.se2 import Array

LOOSE = "the graph has a part that no measurement or prior holds in place"
_SINGULAR = 1e-12  # of the products of its diagonal: a determinant below it is none


class GraphError(ValueError):
    """The graph cannot be solved as given; the message says which part is at fault."""


@dataclass(frozen=True, slots=True, eq=False)
class GraphProblem:
    """Arrays of a tag graph in one frame; information matrices are inverse covariances.

    ``poses`` (n, 3), ``tags`` (m, 2) initial values; ``edge_pairs`` (k, 2), ``edge_poses`` (k, 3),
    ``edge_covariances`` (k, 3, 3); ``sighting_pairs`` (s, 2) pose and tag, ``sighting_offsets`` (s, 2),
    ``sighting_covariances`` (s, 2, 2) in the base frame; ``heading_index`` (h,), ``heading_rad`` (h,),
    ``heading_sd_rad`` (h,); ``prior_index`` (p,), ``prior_poses`` (p, 3), ``prior_sds`` (p, 3).
    ``edge_information`` (k, 3, 3), where given, stands for the edges' covariances; it may be singular.
    ``edge_robust`` (k,) says which edges carry a robust kernel, as sightings do; without it none does.
    """

    poses: Array
    tags: Array
    edge_pairs: IntArray
    edge_poses: Array
    edge_covariances: Array
    sighting_pairs: IntArray
    sighting_offsets: Array
    sighting_covariances: Array
    prior_index: IntArray
    prior_poses: Array
    prior_sds: Array
    heading_index: IntArray = field(default_factory=lambda: np.zeros(0, np.int64))
    heading_rad: Array = field(default_factory=lambda: np.zeros(0))
    heading_sd_rad: Array = field(default_factory=lambda: np.zeros(0))
    edge_information: Array | None = None
    edge_robust: BoolArray | None = None


_SHAPES: dict[str, tuple[int, ...]] = {
    "poses": (-1, 3), "tags": (-1, 2), "edge_pairs": (-1, 2), "edge_poses": (-1, 3),
    "edge_covariances": (-1, 3, 3), "sighting_pairs": (-1, 2), "sighting_offsets": (-1, 2),
    "sighting_covariances": (-1, 2, 2), "prior_index": (-1,), "prior_poses": (-1, 3), "prior_sds": (-1, 3),
    "heading_index": (-1,), "heading_rad": (-1,), "heading_sd_rad": (-1,),
}  # fmt: skip
_FIELDS = tuple(_SHAPES)
_INDICES = frozenset({"edge_pairs", "sighting_pairs", "prior_index", "heading_index"})
_NOT_FINITE, _NO_VERTEX, _NOT_POSITIVE, _NO_SD, _NOT_HELD = 1, 2, 3, 4, 5


def assemble(problem: GraphProblem) -> tuple[Array, Factors]:
    """Return the initial state (n + m, 3), poses before tags, and all factors.

    Raises:
        GraphError: a value is not finite, a covariance is not positive definite, an index does not exist, or
            a part is held by nothing.
    """
    if not len(problem.prior_index):
        raise GraphError("a graph needs at least one prior to hold it in place")
    arrays = {
        name: np.ascontiguousarray(
            getattr(problem, name), np.int64 if name in _INDICES else np.float64
        ).reshape(shape)
        for name, shape in _SHAPES.items()
    }
    given = problem.edge_information
    if given is not None:
        arrays["edge_covariances"] = np.ascontiguousarray(given, np.float64)
    count = len(arrays["edge_pairs"])
    flags = np.zeros(count, np.bool_) if problem.edge_robust is None else np.asarray(problem.edge_robust)
    if flags.shape != (count,) or flags.dtype != np.bool_:
        raise GraphError(f"edge_robust has to say true or false of each of {count} edges")
    fault, where, at, state, found = _assemble(*arrays.values(), given is not None, flags)
    if fault:
        name = "edge_information" if given is not None and where == 4 else _FIELDS[where]
        raise GraphError(
            {
                _NOT_FINITE: f"{name} holds a value that is not finite",
                _NO_VERTEX: f"{name} names a vertex that does not exist",
                _NOT_POSITIVE: f"{name}[{at}] is not positive "
                + ("semidefinite" if name == "edge_information" else "definite"),
                _NO_SD: f"{name} has to be greater than 0",
                _NOT_HELD: LOOSE,
            }[fault]
        )
    return state, Factors(*found)


def information_of(covariance: Array | None, information: Array | None) -> Array:
    """Return the information matrix (3, 3) of an edge given by one of the two.

    Raises:
        GraphError: it is not finite, not symmetric, or not positive (semi)definite.
    """
    if (covariance is None) == (information is None):
        raise GraphError("an edge has either a covariance or an information matrix")
    kind = "covariance" if information is None else "information"
    given = np.array(covariance if information is None else information, np.float64)
    if given.shape != (3, 3) or not np.isfinite(given).all():
        raise GraphError(f"the {kind} has to be 3 x 3 finite numbers")
    found = np.zeros((3, 3)) if information is None else given
    if not (_invert(given, found) if information is None else _semidefinite(given)):
        raise GraphError(
            f"the {kind} is not positive {'definite' if information is None else 'semidefinite'}"
        )
    return found


@njit(cache=True)
def _assemble(
    poses: Array,
    tags: Array,
    edge_pairs: IntArray,
    edge_poses: Array,
    edge_spreads: Array,
    sighting_pairs: IntArray,
    sighting_offsets: Array,
    sighting_covariances: Array,
    prior_index: IntArray,
    prior_poses: Array,
    prior_sds: Array,
    heading_index: IntArray,
    heading_rad: Array,
    heading_sd_rad: Array,
    informed: bool,
    edge_robust: BoolArray,
) -> tuple[int, int, int, Array, Any]:  # fault, field, row, state and the fields of Factors
    n, m, e, s = len(poses), len(tags), len(edge_pairs), len(sighting_pairs)
    p, h = len(prior_index), len(heading_index)
    state = np.zeros((n + m, 3))
    pairs, measured, information = (
        np.empty((e + s, 2), np.int64),
        np.zeros((e + s, 3)),
        np.zeros((e + s, 3, 3)),
    )
    anchored, values, weights = np.empty(p + h, np.int64), np.zeros((p + h, 3)), np.zeros((p + h, 3))
    robust = np.ones(e + s, np.bool_)
    robust[:e] = edge_robust
    found = (pairs, measured, information, robust, e, anchored, values, weights)
    floats = (
        (0, poses.ravel()), (1, tags.ravel()), (3, edge_poses.ravel()), (4, edge_spreads.ravel()),
        (6, sighting_offsets.ravel()), (7, sighting_covariances.ravel()), (9, prior_poses.ravel()),
        (10, prior_sds.ravel()), (12, heading_rad), (13, heading_sd_rad),
    )  # fmt: skip
    for where, numbers in floats:
        for value in numbers:
            if not np.isfinite(value):
                return _NOT_FINITE, where, 0, state, found
    limits = ((2, edge_pairs.ravel(), n), (8, prior_index, n), (11, heading_index, n))
    for where, indices, limit in limits:
        for index in indices:
            if index < 0 or index >= limit:
                return _NO_VERTEX, where, 0, state, found
    for k in range(s):
        i, j = sighting_pairs[k]
        if i < 0 or i >= n or j < 0 or j >= m:
            return _NO_VERTEX, 5, 0, state, found
    for where, sds in ((10, prior_sds.ravel()), (13, heading_sd_rad)):
        for sd in sds:
            if sd <= 0.0:
                return _NO_SD, where, 0, state, found
    state[:n] = poses
    state[n:, :2] = tags
    pairs[:e] = edge_pairs
    measured[:e] = edge_poses
    measured[e:, :2] = sighting_offsets
    for k in range(e):
        if not (_semidefinite(edge_spreads[k]) if informed else True):
            return _NOT_POSITIVE, 4, k, state, found
        if informed:
            information[k] = edge_spreads[k]
        elif not _invert(edge_spreads[k], information[k]):
            return _NOT_POSITIVE, 4, k, state, found
    for k in range(s):
        pairs[e + k, 0], pairs[e + k, 1] = sighting_pairs[k, 0], n + sighting_pairs[k, 1]
        a, b, d = sighting_covariances[k, 0, 0], sighting_covariances[k, 0, 1], sighting_covariances[k, 1, 1]
        determinant = a * d - b * b
        if a <= 0.0 or not determinant > _SINGULAR * a * d:
            return _NOT_POSITIVE, 7, k, state, found
        information[e + k, 0, 0], information[e + k, 1, 1] = d / determinant, a / determinant
        information[e + k, 0, 1] = information[e + k, 1, 0] = -b / determinant
    anchored[:p], anchored[p:] = prior_index, heading_index
    values[:p] = prior_poses
    values[p:, 2] = heading_rad
    weights[:p] = 1.0 / prior_sds**2
    weights[p:, 2] = 1.0 / heading_sd_rad**2
    piece = pieces(n + m, pairs, information)
    held = np.zeros(n + m, np.bool_)
    for k in range(p):
        held[piece[prior_index[k]]] = True
    for k in range(n + m):
        if not held[piece[k]]:
            return _NOT_HELD, 0, k, state, found
    return 0, 0, 0, state, found


@njit(cache=True)
def pieces(count: int, pairs: IntArray, information: Array) -> IntArray:
    """Return the first vertex of each vertex's piece, (count,); a link without information joins nothing."""
    root = np.arange(count)
    for k in range(len(pairs)):
        if information[k, 0, 0] + information[k, 1, 1] + information[k, 2, 2] <= 0.0:
            continue
        i, j = pairs[k, 0], pairs[k, 1]
        while root[i] != i:
            root[i] = root[root[i]]
            i = root[i]
        while root[j] != j:
            root[j] = root[root[j]]
            j = root[j]
        root[max(i, j)] = min(i, j)
    for k in range(count):  # a root stands before what hangs on it
        root[k] = root[root[k]]
    return root


@njit(cache=True)
def _invert(a: Array, inverse: Array) -> bool:
    """Write the inverse of a symmetric matrix (3, 3); return whether it is positive definite."""
    c00 = a[1, 1] * a[2, 2] - a[1, 2] * a[1, 2]
    c01 = a[0, 2] * a[1, 2] - a[0, 1] * a[2, 2]
    c02 = a[0, 1] * a[1, 2] - a[0, 2] * a[1, 1]
    c11 = a[0, 0] * a[2, 2] - a[0, 2] * a[0, 2]
    c12 = a[0, 1] * a[0, 2] - a[0, 0] * a[1, 2]
    c22 = a[0, 0] * a[1, 1] - a[0, 1] * a[0, 1]
    determinant = a[0, 0] * c00 + a[0, 1] * c01 + a[0, 2] * c02
    if a[0, 0] <= 0.0 or c22 <= 0.0 or not determinant > _SINGULAR * abs(a[0, 0] * a[1, 1] * a[2, 2]):
        return False
    inverse[0, 0], inverse[1, 1], inverse[2, 2] = c00 / determinant, c11 / determinant, c22 / determinant
    inverse[0, 1] = inverse[1, 0] = c01 / determinant
    inverse[0, 2] = inverse[2, 0] = c02 / determinant
    inverse[1, 2] = inverse[2, 1] = c12 / determinant
    return True


@njit(cache=True)
def _semidefinite(a: Array) -> bool:
    """Return whether no principal minor of a symmetric matrix (3, 3) is negative, but for rounding."""
    x, y, z = a[0, 0], a[1, 1], a[2, 2]
    if x < 0.0 or y < 0.0 or z < 0.0:
        return False
    xy, xz, yz = x * y - a[0, 1] ** 2, x * z - a[0, 2] ** 2, y * z - a[1, 2] ** 2
    if xy < -1e-9 * x * y or xz < -1e-9 * x * z or yz < -1e-9 * y * z:
        return False
    determinant = (
        x * yz - a[0, 1] * (a[0, 1] * z - a[1, 2] * a[0, 2]) + a[0, 2] * (a[0, 1] * a[1, 2] - y * a[0, 2])
    )
    return bool(determinant >= -1e-9 * x * y * z)
