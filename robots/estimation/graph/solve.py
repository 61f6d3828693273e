"""The tag graph: globally consistent poses and tags from relative measurements.

Lu and Milios 1997; Kleiner 2006 eq. (5). Vertices are sighting poses (SE(2)) and tag points (2D). Factors:
*edges*, the measured pose of vertex j in the frame of i; *sightings*, a tag under the antenna of pose i;
*headings* from the inertial unit; *priors* that hold a vertex in place. ``solve`` minimises

    W = sum e' Sigma^-1 e                                                                            (eq. 5)

by Gauss-Newton on a sparse factorisation, or linearly with the headings held fixed, as the paper does with
its compass.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numba import njit

from robots.estimation.graph.cholesky import factorise, solve_factored
from robots.estimation.graph.covariances import diagonal_blocks
from robots.estimation.graph.descent import Descent, descend, relaxed
from robots.estimation.graph.factors import (
    BoolArray,
    Equations,
    Factors,
    Kernel,
    between_jacobian,
    beyond,
    largest_turn,
    linearise,
    link_chi2,
)
from robots.estimation.graph.order import Order, order
from robots.estimation.graph.problem import LOOSE, GraphError, GraphProblem, assemble
from robots.estimation.graph.robust import believed, only
from robots.estimation.graph.tree import along_tree
from robots.graph_report import IntArray
from robots.se2 import Array, wrap_array

__all__ = ["GraphError", "GraphProblem", "GraphSolution", "Marginals", "solve"]

# Gauss-Newton goes wrong where headings are: places are linear once those are right. They may be wrong with
# no two neighbours contradicting each other much, as in a long chain; then the places contradict them.
_HUBER_STEPS, _MORE_STEPS = 8, 12  # Huber shows what nothing agrees with, and converges slowly
_AGREEMENTS = 8
_BY_CHANCE = 0.02  # of all sightings may be beyond three deviations with nothing wrong
_DOUBTFUL_RAD, _DOUBTFUL_SD, _TWISTED_RAD = 0.4, 10.0, 1.0


@dataclass(frozen=True, slots=True, eq=False)
class GraphSolution:
    """Solved poses (n, 3) and tags (m, 2), and W before and after.

    ``edge_residuals`` (k,) and ``sighting_residuals`` (s,) are Mahalanobis distances of what was measured
    from the solution, in deviations: what is far beyond ``kernel_sd`` was not believed. ``notes`` say what
    was odd about the graph and survived. ``marginals`` gives the covariances.
    """

    poses: Array
    tags: Array
    chi2_initial: float
    chi2: float
    iterations: int
    edge_residuals: Array
    sighting_residuals: Array
    marginals: Marginals
    notes: tuple[str, ...] = ()

    def pose_covariance(self, index: int) -> Array:
        """Return the marginal covariance (3, 3) of a pose vertex."""
        return self.marginals.of(index)

    def tag_covariance(self, index: int) -> Array:
        """Return the marginal covariance (2, 2) of a tag."""
        return self.marginals.of(len(self.poses) + index)[:2, :2]


class Marginals:
    """Covariances of vertices at a solution. The matrix is factorised when the first is asked for."""

    def __init__(self, state: Array, factors: Factors, kernel: Kernel, linear: bool, damping: float) -> None:
        self._state, self._factors, self._kernel = state, factors, kernel
        self._linear, self._damping = linear, damping
        self._solved: tuple[Order, Array] | None = None

    def of(self, vertex: int) -> Array:
        """Return the covariance (3, 3) of a vertex, tags counted after the poses."""
        return self.joint(np.array([vertex]))

    def relative(self, first: int, second: int) -> Array:
        """Return the covariance (3, 3) of vertex ``second`` in the frame of pose vertex ``first``.

        Tags are counted after the poses; of a tag only the upper left (2, 2) says anything.
        """
        J = between_jacobian(self._state[first], self._state[second])
        covariance: Array = J @ self.joint(np.array([first, second])) @ J.T
        return (covariance + covariance.T) / 2.0

    def joint(self, vertices: IntArray) -> Array:
        """Return the joint covariance (3 k, 3 k) of k vertices; a tag's third row and column mean nothing."""
        covariance: Array = columns_of(*self._factor(), np.asarray(vertices, np.int64))
        return (covariance + covariance.T) / 2.0

    def all(self) -> Array:
        """Return the covariances (n, 3, 3) of all vertices, tags after the poses, in one go."""
        blocks: Array = diagonal_blocks(*self._factor())
        return blocks

    def _factor(self) -> tuple[Order, Array]:
        if self._solved is None:
            frame, equations, factor = _storage(len(self._state), self._factors)
            linearise(self._state, self._factors, equations, self._kernel, self._linear)
            if not factorise(frame, equations, self._damping, factor):
                raise GraphError(LOOSE)
            self._solved = frame, factor
        return self._solved


@njit(cache=True)
def columns_of(frame: Order, factor: Array, vertices: IntArray) -> Array:
    """Return the blocks of the inverse that belong to the vertices (k,), shape (3 k, 3 k)."""
    count, size = len(frame.vertex), len(vertices)
    right, column = np.zeros((count, 3)), np.empty((count, 3))
    covariance = np.empty((3 * size, 3 * size))
    for j in range(size):
        for k in range(3):
            right[vertices[j], k] = 1.0
            solve_factored(frame, factor, right, column)
            right[vertices[j], k] = 0.0
            for i in range(size):
                covariance[3 * i : 3 * i + 3, 3 * j + k] = column[vertices[i]]
    return covariance


def solve(
    problem: GraphProblem,
    method: Literal["gauss-newton", "linear"] = "gauss-newton",
    max_iterations: int = 20,
    kernel_sd: float = 3.0,
    start: Literal["doubted", "relaxed"] = "doubted",
    tolerance: float = 1e-8,
    kernel: Literal["redescending", "huber"] = "redescending",
) -> GraphSolution:
    """Return the poses and tags that minimise eq. (5).

    Sightings and robust edges beyond ``kernel_sd`` deviations lose weight: first as Huber has it, then, where
    some are left out there, by the redescending kernel, which lets go of what is wrong; of several starts the
    one that ends lowest stands. The linear form keeps
    every heading as given and weighs displacements with the 2 x 2 covariance of the positions. Initial
    headings that contradict the edges are replaced by those of the chordal relaxation, and all places with
    them; ``relaxed`` does so always, with the linear form too. The descent ends when a step promises to lower
    W by less than ``tolerance`` of it.

    Raises:
        GraphError: a value is not finite, a covariance is not positive definite, an index does not exist, or
            nothing holds the graph.
    """
    state, factors = assemble(problem)
    linear = method == "linear"
    huber, last = Kernel(float(kernel_sd), False), Kernel(float(kernel_sd), kernel == "redescending")
    parts = _storage(len(state), factors)
    steps = 1 if linear else max_iterations
    edges_robust = bool(factors.robust[: factors.tags_from].any())

    def descent(begin: Array, kernel: Kernel, most: int) -> Descent:
        frame, equations, factor = parts
        return Descent(*descend(begin, factors, equations, frame, factor, kernel, linear, most, tolerance))

    def lowest(begin: Array) -> Descent:
        if linear or not last.redescends:
            return descent(begin, huber, steps)
        first = descent(begin, huber, min(steps, _HUBER_STEPS))
        some = np.isfinite(first.damping) and beyond(first.state, factors, kernel_sd)
        if not some and first.steps < _HUBER_STEPS:
            return first
        then = descent(first.state, last, max(steps - first.steps, 1) if not edges_robust else _MORE_STEPS)
        return then._replace(before=first.before, steps=first.steps + then.steps)

    initial: float | None = None
    begin = state
    if start == "relaxed" or (not linear and _doubtful(state, factors, parts[1], huber)):
        initial = linearise(state, factors, parts[1], huber, linear)
        better, there = relaxed(state, factors, parts[1], parts[0], parts[2])
        if there and (linear or linearise(better, factors, parts[1], huber, False) < initial):
            begin = better
    best = lowest(begin)
    before = best.before if initial is None else initial
    outside = beyond(best.state, factors, kernel_sd) if last.redescends and not linear else 0
    if outside and (edges_robust or outside > _BY_CHANCE * len(factors.pairs)):
        # Huber may have been drawn away by what is wrong: descend from the start itself, and from what those
        # edges say that agree with each other, as long as that leads lower.
        best = _lower(best, descent(state, last, steps))
        kept = believed(problem, kernel_sd) if edges_robust else None
        for _ in range(_AGREEMENTS):
            agreed = None if kept is None else _solution_of(problem, kept, state, kernel_sd)
            if kept is None or agreed is None:
                break
            then, chi2 = descent(agreed, last, steps), best.chi2
            kept = ~factors.robust[: len(kept)] | (_distances(then.state, factors)[: len(kept)] < kernel_sd)
            best = _lower(best, then)
            if not best.chi2 < chi2 * (1.0 - 1e-6):
                break
    if (
        initial is not None
        and not linear
        and not edges_robust
        and largest_turn(best.state, factors) > _TWISTED_RAD
    ):
        # Twisted still: some edges are wrong, or this is not the lowest of the minima. Try other starts.
        others = [along_tree(state, factors)] + ([state] if begin is not state else [])
        best = _lower(best, *(lowest(other) for other in others))
    found, damping = best.state, best.damping
    if not np.isfinite(damping) or not np.isfinite(found).all():
        raise GraphError(LOOSE)
    notes = ("a direction that nothing measures was left as it was given",) if damping else ()
    n = len(problem.poses)
    poses = found[:n].copy()
    poses[:, 2] = wrap_array(poses[:, 2])
    away = _distances(found, factors)
    return GraphSolution(
        poses=poses,
        tags=found[n:, :2].copy(),
        chi2_initial=before,
        chi2=best.chi2,
        iterations=best.steps,
        edge_residuals=away[: factors.tags_from],
        sighting_residuals=away[factors.tags_from :],
        marginals=Marginals(found, factors, last, linear, damping),
        notes=notes,
    )


def _distances(state: Array, factors: Factors) -> Array:
    """Return how many deviations each link (k,) is from what was measured."""
    squares = link_chi2(state, factors.pairs, factors.measured, factors.information)
    return np.asarray(np.sqrt(np.maximum(squares, 0.0)))


def _solution_of(problem: GraphProblem, kept: BoolArray, state: Array, kernel_sd: float) -> Array | None:
    """Return the solution (n + m, 3) for those edges alone, if they hold the graph together."""
    try:
        there = solve(only(problem, kept), kernel_sd=kernel_sd, start="relaxed", kernel="huber")
    except GraphError:
        return None
    begin = state.copy()
    begin[: len(there.poses)], begin[len(there.poses) :, :2] = there.poses, there.tags
    return begin


def _lower(best: Descent, *others: Descent) -> Descent:
    """Return the descent that ended lowest, and the steps of all."""
    steps = best.steps + sum(other.steps for other in others)
    for other in others:
        if np.isfinite(other.damping) and (other.chi2 < best.chi2 or not np.isfinite(best.damping)):
            best = other
    return best._replace(steps=steps)


def _doubtful(state: Array, factors: Factors, equations: Equations, kernel: Kernel) -> bool:
    """Say whether a start contradicts the measurements: a heading by much, or all of them together."""
    if largest_turn(state, factors) > _DOUBTFUL_RAD:
        return True
    numbers = 3 * factors.tags_from + 2 * (len(factors.pairs) - factors.tags_from)
    return bool(linearise(state, factors, equations, kernel, False) > _DOUBTFUL_SD**2 * numbers)


def _storage(count: int, factors: Factors) -> tuple[Order, Equations, Array]:
    """Return the order of elimination and the room for the equations and their factor."""
    frame, slot, turned = order(count, factors.pairs)
    equations = Equations(
        slot,
        turned,
        np.empty((count, 3, 3)),
        np.empty((len(frame.entries), 3, 3)),
        np.empty((count, 3)),
    )
    return frame, equations, np.empty(frame.panel_start[-1])
