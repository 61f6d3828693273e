"""The tag graph: globally consistent poses and tags from relative measurements.

Lu and Milios 1997; Kleiner 2006 eq. (5). Vertices are sighting poses (SE(2)) and tag points (2D). Factors:
*edges*, the measured pose of vertex j in the frame of i; *sightings*, a tag under the antenna of pose i;
*headings* from the inertial unit; *priors* that hold a vertex in place. ``solve`` minimises

    W = sum e' Sigma^-1 e                                                                            (eq. 5)

by Gauss-Newton on a sparse factorisation, or linearly with the headings held fixed, as the paper does with
its compass.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
import qdldl
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from robots.estimation.graph_factors import (
    edge_blocks,
    edge_chi2,
    edge_errors,
    heading_errors,
    pose_prior_errors,
    sighting_blocks,
    sighting_errors,
)
from robots.se2 import Array, wrap_array
from robots.types import IntArray

_CONVERGED = 1e-6  # metres and radians
_MAX_HALVINGS = 8
_LOOSE = "the graph has a part that no measurement or prior holds in place"
_FINITE = (
    "poses", "tags", "edge_poses", "edge_covariances", "sighting_offsets", "sighting_covariances",
    "prior_poses", "prior_sds", "heading_rad", "heading_sd_rad",
)  # fmt: skip


class GraphError(ValueError):
    """The graph cannot be solved as given; the message says which part is at fault."""


def _empty(*shape: int) -> Array:
    return np.zeros(shape)


@dataclass(frozen=True, slots=True, eq=False)
class GraphProblem:
    """Arrays of a tag graph in one frame; information matrices are inverse covariances.

    ``poses`` (n, 3), ``tags`` (m, 2) initial values; ``edge_pairs`` (k, 2), ``edge_poses`` (k, 3),
    ``edge_covariances`` (k, 3, 3); ``sighting_pairs`` (s, 2) pose and tag, ``sighting_offsets`` (s, 2),
    ``sighting_covariances`` (s, 2, 2) in the base frame; ``heading_index`` (h,), ``heading_rad`` (h,),
    ``heading_sd_rad`` (h,); ``prior_index`` (p,), ``prior_poses`` (p, 3), ``prior_sds`` (p, 3).
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
    heading_rad: Array = field(default_factory=lambda: _empty(0))
    heading_sd_rad: Array = field(default_factory=lambda: _empty(0))


@dataclass(frozen=True, slots=True, eq=False)
class GraphSolution:
    """Solved poses (n, 3) and tags (m, 2), and W before and after. ``solver`` gives marginal covariances."""

    poses: Array
    tags: Array
    chi2_initial: float
    chi2: float
    iterations: int
    solver: NormalEquations

    def pose_covariance(self, index: int) -> Array:
        """Return the marginal covariance (3, 3) of a pose vertex."""
        return self.solver.marginal(3 * index, 3)

    def tag_covariance(self, index: int) -> Array:
        """Return the marginal covariance (2, 2) of a tag."""
        return self.solver.marginal(3 * len(self.poses) + 2 * index, 2)


class NormalEquations:
    """The sparse normal matrix of a graph.

    Its pattern is made once and kept, explicit zeros included: qdldl's ``update`` must see the same pattern
    each time, or it converges to a wrong solution without a word.
    """

    def __init__(self, problem: GraphProblem) -> None:
        n, m = len(problem.poses), len(problem.tags)
        self.size = 3 * n + 2 * m
        edges, sightings = problem.edge_pairs, problem.sighting_pairs
        pose_i = 3 * edges[:, :1] + np.arange(3)
        pose_j = 3 * edges[:, 1:] + np.arange(3)
        edge_variables = np.hstack([pose_i, pose_j])  # (k, 6)
        seen_variables = np.hstack(
            [3 * sightings[:, :1] + np.arange(3), 3 * n + 2 * sightings[:, 1:] + np.arange(2)]
        )  # (s, 5)
        self.edge_variables, self.seen_variables = edge_variables, seen_variables
        diagonal = np.arange(self.size)
        blocks = (edge_variables, seen_variables)
        row = np.concatenate([*(np.repeat(v, v.shape[1], axis=1).ravel() for v in blocks), diagonal])
        column = np.concatenate([*(np.tile(v, (1, v.shape[1])).ravel() for v in blocks), diagonal])
        self._upper = row <= column
        flat = column[self._upper] * np.int64(self.size) + row[self._upper]  # column-major, as CSC stores
        unique, self._place = np.unique(flat, return_inverse=True)
        self._indices = (unique % self.size).astype(np.int32)
        counts = np.bincount(unique // self.size, minlength=self.size)
        self._pointers = np.concatenate([[0], np.cumsum(counts)]).astype(np.int32)
        self._factor: qdldl.Solver | None = None

    def factorise(self, edge_hessians: Array, seen_hessians: Array, diagonal: Array) -> None:
        """Set the values, blocks (k, 6, 6) and (s, 5, 5) and a diagonal (size,), and factorise."""
        values = np.concatenate([edge_hessians.ravel(), seen_hessians.ravel(), diagonal])[self._upper]
        data = np.bincount(self._place, weights=values, minlength=len(self._indices))
        matrix = sp.csc_matrix((data, self._indices, self._pointers), shape=(self.size, self.size))
        try:
            if self._factor is None:
                self._factor = qdldl.Solver(matrix, upper=True)
            else:
                self._factor.update(matrix, upper=True)
        except RuntimeError as error:  # a pivot of zero
            raise GraphError(_LOOSE) from error

    def solve(self, right: Array) -> Array:
        """Solve for a right-hand side (size,)."""
        assert self._factor is not None
        return np.asarray(self._factor.solve(right))

    def marginal(self, start: int, count: int) -> Array:
        """Return the covariance (count, count) of consecutive variables."""
        block = np.empty((count, count))
        for k in range(count):
            unit = np.zeros(self.size)
            unit[start + k] = 1.0
            block[:, k] = self.solve(unit)[start : start + count]
        return (block + block.T) / 2.0


def solve(
    problem: GraphProblem,
    method: Literal["gauss-newton", "linear"] = "gauss-newton",
    max_iterations: int = 20,
    kernel_sd: float = 3.0,
) -> GraphSolution:
    """Return the poses and tags that minimise eq. (5).

    Sightings beyond ``kernel_sd`` deviations lose weight (Huber). The linear form keeps every heading as
    given and weighs displacements with the 2 x 2 covariance of the positions.

    Raises:
        GraphError: a value is not finite, a covariance is not positive definite, an index does not exist, or
            nothing holds the graph.
    """
    _check(problem)
    linear = method == "linear"
    edge_information = _edge_information(problem, linear)
    sighting_information = np.asarray(np.linalg.inv(problem.sighting_covariances), np.float64)
    equations = NormalEquations(problem)
    poses, tags = problem.poses.copy(), problem.tags.copy()
    chi2 = chi2_initial = _chi2(problem, poses, tags, edge_information, sighting_information, kernel_sd)
    iterations = 0
    for iterations in range(1, (1 if linear else max_iterations) + 1):  # noqa: B007 - reported
        step = _step(
            problem, poses, tags, edge_information, sighting_information, kernel_sd, linear, equations
        )
        for _ in range(_MAX_HALVINGS):
            new_poses, new_tags = _apply(poses, tags, step)
            new_chi2 = _chi2(problem, new_poses, new_tags, edge_information, sighting_information, kernel_sd)
            if linear or new_chi2 <= chi2 * (1.0 + 1e-12) + 1e-12:
                break
            step = step / 2.0
        else:
            break  # no descent left: at the minimum as far as the arithmetic can tell
        poses, tags, chi2 = new_poses, new_tags, new_chi2
        if np.abs(step).max(initial=0.0) < _CONVERGED:
            break
    return GraphSolution(poses, tags, chi2_initial, chi2, iterations, equations)


def _step(
    problem: GraphProblem,
    poses: Array,
    tags: Array,
    edge_information: Array,
    sighting_information: Array,
    kernel_sd: float,
    linear: bool,
    equations: NormalEquations,
) -> Array:
    edge_h, edge_g = edge_blocks(poses, problem.edge_pairs, problem.edge_poses, edge_information, linear)
    seen_h, seen_g = sighting_blocks(
        poses, tags, problem.sighting_pairs, problem.sighting_offsets, sighting_information, kernel_sd, linear
    )
    diagonal = np.zeros(equations.size)
    gradient = np.zeros(equations.size)
    np.add.at(gradient, equations.edge_variables, edge_g)
    np.add.at(gradient, equations.seen_variables, seen_g)
    prior_at = 3 * problem.prior_index[:, None] + np.arange(3)
    weights = problem.prior_sds**-2.0
    np.add.at(diagonal, prior_at, weights)
    np.add.at(
        gradient, prior_at, weights * pose_prior_errors(poses, problem.prior_index, problem.prior_poses)
    )
    heading_at = 3 * problem.heading_index + 2
    weight = problem.heading_sd_rad**-2.0
    np.add.at(diagonal, heading_at, weight)
    np.add.at(
        gradient, heading_at, weight * heading_errors(poses, problem.heading_index, problem.heading_rad)
    )
    if linear:  # headings are given: they neither move nor pull
        at = 3 * np.arange(len(poses)) + 2
        diagonal[at], gradient[at] = 1.0, 0.0
    equations.factorise(edge_h, seen_h, diagonal)
    step = equations.solve(-gradient)
    if not np.isfinite(step).all():
        raise GraphError(_LOOSE)
    return step


def _apply(poses: Array, tags: Array, step: Array) -> tuple[Array, Array]:
    moved = poses + step[: poses.size].reshape(-1, 3)
    moved[:, 2] = wrap_array(moved[:, 2])
    return moved, tags + step[poses.size :].reshape(-1, 2)


def _edge_information(problem: GraphProblem, linear: bool) -> Array:
    if not linear:
        return np.asarray(np.linalg.inv(problem.edge_covariances), np.float64)
    information = np.zeros_like(problem.edge_covariances)
    information[:, :2, :2] = np.linalg.inv(problem.edge_covariances[:, :2, :2])
    return information


def _chi2(
    problem: GraphProblem,
    poses: Array,
    tags: Array,
    edge_information: Array,
    sighting_information: Array,
    kernel_sd: float,
) -> float:
    total = edge_chi2(edge_errors(poses, problem.edge_pairs, problem.edge_poses), edge_information)
    errors = sighting_errors(poses, tags, problem.sighting_pairs, problem.sighting_offsets)
    squares = np.einsum("ni,nij,nj->n", errors, sighting_information, errors)
    outside = squares > kernel_sd**2
    total += float(np.where(outside, 2.0 * kernel_sd * np.sqrt(squares) - kernel_sd**2, squares).sum())
    prior = pose_prior_errors(poses, problem.prior_index, problem.prior_poses) / problem.prior_sds
    heading = heading_errors(poses, problem.heading_index, problem.heading_rad) / problem.heading_sd_rad
    return float(total + (prior**2).sum() + (heading**2).sum())


def _check(problem: GraphProblem) -> None:
    n, m = len(problem.poses), len(problem.tags)
    for name in _FINITE:
        if not np.isfinite(getattr(problem, name)).all():
            raise GraphError(f"{name} holds a value that is not finite")
    pairs: list[tuple[str, NDArray[np.int64], int]] = [
        ("edge_pairs", problem.edge_pairs, n),
        ("sighting_pairs", problem.sighting_pairs[:, :1], n),
        ("sighting_pairs", problem.sighting_pairs[:, 1:], m),
        ("prior_index", problem.prior_index, n),
        ("heading_index", problem.heading_index, n),
    ]
    for name, index, count in pairs:
        if index.size and (index.min() < 0 or index.max() >= count):
            raise GraphError(f"{name} names a vertex that does not exist")
    for name in ("edge_covariances", "sighting_covariances"):
        covariances = getattr(problem, name)
        if len(covariances) and np.linalg.eigvalsh(covariances)[:, 0].min() <= 0.0:
            worst = int(np.linalg.eigvalsh(covariances)[:, 0].argmin())
            raise GraphError(f"{name}[{worst}] is not positive definite")
    if not len(problem.prior_index):
        raise GraphError("a graph needs at least one prior to hold it in place")
    for name in ("prior_sds", "heading_sd_rad"):
        if (getattr(problem, name) <= 0.0).any():
            raise GraphError(f"{name} has to be greater than 0")
    _check_held(problem)


def _check_held(problem: GraphProblem) -> None:
    """Refuse a graph in pieces of which not each has a prior: rounding hides that from the factorisation."""
    n, count = len(problem.poses), len(problem.poses) + len(problem.tags)
    pairs = np.concatenate([problem.edge_pairs, problem.sighting_pairs + np.array([0, n])])
    joined = sp.coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    pieces, piece_of = connected_components(joined, directed=False)
    if len(np.unique(piece_of[problem.prior_index])) < pieces:
        raise GraphError(_LOOSE)
