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

from robots.estimation.graph_cholesky import factorise, solve_factored
from robots.estimation.graph_descent import descend, relaxed
from robots.estimation.graph_factors import (
    Equations,
    Factors,
    Kernel,
    between_jacobian,
    beyond,
    largest_turn,
    linearise,
    link_chi2,
)
from robots.estimation.graph_order import Order, order
from robots.estimation.graph_problem import LOOSE, GraphError, GraphProblem, assemble
from robots.estimation.graph_tree import along_tree
from robots.se2 import Array, wrap_array
from robots.types import IntArray

__all__ = ["GraphError", "GraphProblem", "GraphSolution", "Marginals", "solve"]

# Gauss-Newton goes wrong where headings are: places are linear once those are right. They may be wrong with
# no two neighbours contradicting each other much, as in a long chain; then the places contradict them.
_HUBER_STEPS = 8  # enough to see which links nothing agrees with; it converges slowly where there are many
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
    """Covariances of single vertices at a solution. The matrix is factorised when the first is asked for."""

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
        if self._solved is None:
            frame, equations, factor = _storage(len(self._state), self._factors)
            linearise(self._state, self._factors, equations, self._kernel, self._linear)
            if not factorise(frame, equations, self._damping, factor):
                raise GraphError(LOOSE)
            self._solved = frame, factor
        covariance: Array = columns_of(*self._solved, np.asarray(vertices, np.int64))
        return (covariance + covariance.T) / 2.0


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
    some are left out there, by the redescending kernel, which lets go of what is wrong. The linear form keeps
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

    def lowest(begin: Array) -> tuple[Array, float, float, int, float]:
        frame, equations, factor = parts
        first = steps if kernel == "huber" or linear else min(steps, _HUBER_STEPS)
        found: tuple[Array, float, float, int, float] = descend(
            begin, factors, equations, frame, factor, huber, linear, first, tolerance
        )
        state, before, _, taken, damping = found
        if last.redescends and np.isfinite(damping) and not linear and taken < steps:
            inside = not beyond(state, factors, kernel_sd)
            if inside and taken < first:
                return found
            again = descend(state, factors, equations, frame, factor, last, linear, steps - taken, tolerance)
            return again[0], before, again[2], taken + again[3], again[4]
        return found

    initial: float | None = None
    begin = state
    if start == "relaxed" or (not linear and _doubtful(state, factors, parts[1], huber)):
        initial = linearise(state, factors, parts[1], huber, linear)
        better, there = relaxed(state, factors, parts[1], parts[0], parts[2])
        if there and (linear or linearise(better, factors, parts[1], huber, False) < initial):
            begin = better
    found, before, chi2, iterations, damping = lowest(begin)
    if initial is not None and not linear and largest_turn(found, factors) > _TWISTED_RAD:
        # Twisted still: some edges are wrong, or this is not the lowest of the minima. Try other starts.
        others = [along_tree(state, factors)] + ([state] if begin is not state else [])
        for other in others:
            again = lowest(other)
            if np.isfinite(again[4]) and (again[2] < chi2 or not np.isfinite(damping)):
                found, _, chi2, iterations, damping = again
    if not np.isfinite(damping) or not np.isfinite(found).all():
        raise GraphError(LOOSE)
    notes = ("a direction that nothing measures was left as it was given",) if damping else ()
    n = len(problem.poses)
    poses = found[:n].copy()
    poses[:, 2] = wrap_array(poses[:, 2])
    away = np.sqrt(np.maximum(link_chi2(found, factors.pairs, factors.measured, factors.information), 0.0))
    return GraphSolution(
        poses=poses,
        tags=found[n:, :2].copy(),
        chi2_initial=before if initial is None else initial,
        chi2=chi2,
        iterations=iterations,
        edge_residuals=away[: factors.tags_from],
        sighting_residuals=away[factors.tags_from :],
        marginals=Marginals(found, factors, last, linear, damping),
        notes=notes,
    )


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
