"""A batch solve of a tag graph with sightings by range, the radios' calibration among its unknowns.

Begins at the filter's own result. Errors of range stay the same for seconds: how long they do is read from
the residuals, and sightings of a tag nearer in time than that count for less. The deviation of a range is
that of the range expected, not of the one measured: else short readings count for more, and maps shrink.
A node heard without bearing may lie on the other side of the way: places it may lie at are tried, and the
lowest cost stands.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from robots.estimation.graph.cholesky import factorise, solve_factored
from robots.estimation.graph.factors import (
    Equations,
    Factors,
    Kernel,
    add_factors,
    clear,
    hold_unmeasured,
    link_chi2,
)
from robots.estimation.graph.order import Order, order
from robots.estimation.graph.problem import LOOSE, GraphError, GraphProblem, assemble
from robots.estimation.graph.solve import GraphSolution, Marginals
from robots.estimation.ranges.errors import error_lasts_s, shares
from robots.estimation.ranges.factors import Ranges, add_ranges, expected_ranges
from robots.estimation.ranges.places import other_places
from robots.estimation.ranges.views import RangeViews, tangents
from robots.graph_report import IntArray
from robots.se2 import Array, wrap_array

_MOUNT_SD_RAD = 0.02  # of an instrument that nobody calibrated
_LEAST_SD = 1e-4  # of a scale or an offset that is given as known
_ROUNDS, _STEPS = 4, 15  # deviations and shares are set anew each round
_SETTLED = 1e-6  # of the cost: less is no gain
_FIRST_DAMPING, _MOST_DAMPING = 1e-6, 1e9
_LOWER = 9.0  # by which another place of a node has to cost less: three deviations


@dataclass(frozen=True, slots=True, eq=False)
class RangeSolution:
    """The graph where it was solved, its sightings by range replaced by their tangents there.

    ``scales`` and ``mounts_rad`` (k,) of each radio, ``offsets_m`` (m,) of each tag; ``lasts_s`` (2,) how
    long errors of range and bearing last; ``solution.chi2`` is twice the negative log-likelihood up to a
    constant, and the vertices of its marginals are poses, tags with their offsets, radios.
    """

    graph: GraphProblem
    scales: Array
    mounts_rad: Array
    offsets_m: Array
    lasts_s: tuple[float, float]
    solution: GraphSolution


class _RangeMarginals(Marginals):
    """Covariances at the solution: poses first, then tags with their offsets, then radios."""

    def __init__(self, state: Array, frame: Order, factor: Array) -> None:
        self._state, self._solved = state, (frame, factor)


def smooth_ranges(graph: GraphProblem, views: RangeViews, kernel_sd: float = 3.0) -> RangeSolution:
    """Return the batch solution of a graph with sightings by range.

    ``views.links`` names the links of the graph (edges, then sightings) that stand for the ranges.

    Raises:
        GraphError: it cannot be solved; the message says why.
    """
    batch = _Batch(graph, views, kernel_sd)
    cost = batch.settle()
    for tag in batch.undirected_tags():
        for place in other_places(batch.state, batch.ranges, tag):
            cost = batch.try_place(tag, place, cost)
    return batch.solution(cost)


class _Batch:
    """State, factors and room for the equations of one batch solve."""

    def __init__(self, graph: GraphProblem, views: RangeViews, kernel_sd: float) -> None:
        self._graph, self._views, self._kernel_sd = graph, views, kernel_sd
        begin, factors = assemble(graph)
        information = factors.information.copy()
        information[views.links] = 0.0  # the ranges themselves take their place
        self._factors: Factors = factors._replace(information=information)
        self._poses, self._tags = len(graph.poses), len(graph.tags)
        radios = np.column_stack([views.scales, np.zeros((len(views.scales), 2))])
        begin[self._poses :, 2] = views.offsets_m
        self.state: Array = np.concatenate([begin, radios])
        self._steps = 0
        self.ranges = self._ranges(factors.pairs)
        self._lasts_s = (0.0, 0.0)

    def _ranges(self, pairs: IntArray) -> Ranges:
        views, count = self._views, len(self._views.links)
        poses, seen = pairs[views.links].T
        radios = self._poses + self._tags + views.radios
        every = np.concatenate([pairs, np.column_stack([poses, radios]), np.column_stack([seen, radios])])
        frame, slot, turned = order(len(self.state), every)
        self._frame, self._factor = frame, np.empty(frame.panel_start[-1])
        n = len(self.state)
        blocks = np.empty((n, 3, 3)), np.empty((len(frame.entries), 3, 3)), np.empty((n, 3))
        self._equations = Equations(slot, turned, *blocks)
        own = len(pairs) + np.arange(count)
        free = np.unique(seen[np.isnan(views.bearings_rad)])
        used = np.unique(views.radios)
        priors = np.concatenate([free, self._poses + self._tags + used])
        means = self.state[priors].copy()
        means[: len(free), 2] = 0.0
        means[len(free) :] = (1.0, 0.0, 0.0)
        weights = np.zeros((len(priors), 3))
        offset_sds = np.maximum(views.offset_sds_m[free - self._poses], _LEAST_SD)
        weights[: len(free), 2] = offset_sds**-2.0
        weights[len(free) :] = (1.0, _MOUNT_SD_RAD**-2, 1.0)
        weights[len(free) :, 0] = np.maximum(views.scale_sds[used], _LEAST_SD) ** -2.0
        return Ranges(
            poses=poses.copy(),
            seen=seen.copy(),
            radios=radios,
            links=np.column_stack([views.links, own, own + count]),
            arms=views.arms,
            ranges=views.ranges_m,
            sds=views.sds_at(views.ranges_m),
            bearings=views.bearings_rad,
            bearing_sds=views.bearing_sds_rad,
            shares=np.ones((count, 2)),
            priors=priors,
            means=means,
            weights=weights,
        )

    def undirected_tags(self) -> IntArray:
        """Return the vertices of tags that were seen without any bearing."""
        directed = np.isfinite(self._views.bearings_rad)
        tags: IntArray = np.setdiff1d(self.ranges.seen[~directed], self.ranges.seen[directed])
        return tags

    def settle(self) -> float:
        """Descend, first by Huber's kernel; return the cost."""
        if not self._steps:
            self._begin = self._likelihood(self._linearise(self.state, 0.0))
        self.descend(self._kernel_sd)
        cost = np.inf
        for _ in range(_ROUNDS):
            self._weigh()
            before, cost = cost, self.descend(0.0)
            if abs(before - cost) < 1e-3 * cost:
                break
        return self._likelihood(cost)

    def try_place(self, tag: int, place: Array, cost: float) -> float:
        """Descend from another place of a tag; keep what is lower and return its cost."""
        state, ranges = self.state.copy(), self.ranges
        self.state[tag, :2] = place
        self.descend(self._kernel_sd)
        there = self._likelihood(self.descend(0.0))
        if there < cost - _LOWER:
            return self.settle()
        self.state, self.ranges = state, ranges
        return cost

    def _weigh(self) -> None:
        """Set deviations by the ranges expected, and shares by how long errors last."""
        expected, errors = expected_ranges(self.state, self.ranges)
        sds = self._views.sds_at(expected)
        away = errors / np.column_stack([sds, self._views.bearing_sds_rad])
        stamps, series = self._views.stamps_s, self._views.series
        lasts = tuple(error_lasts_s(away[:, d], stamps, series) for d in range(2))
        self._lasts_s = lasts[0], lasts[1]
        each = np.column_stack([shares(stamps, series, last_s) for last_s in self._lasts_s])
        self.ranges = self.ranges._replace(sds=sds, shares=each)

    def _likelihood(self, cost: float) -> float:
        return cost + 2.0 * float(np.sum(self.ranges.shares[:, 0] * np.log(self.ranges.sds)))

    def _linearise(self, state: Array, kernel_sd: float) -> float:
        clear(self._equations)
        kernel = Kernel(self._kernel_sd, True)
        total = float(add_factors(state, self._factors, self._equations, kernel, False))
        total += float(add_ranges(state, self.ranges, self._equations, kernel_sd))
        hold_unmeasured(self._equations, False)
        return total

    def _factorise(self, damping: float) -> float:
        while not factorise(self._frame, self._equations, damping, self._factor):
            damping = max(_FIRST_DAMPING, 100.0 * damping)
            if damping > _MOST_DAMPING:
                raise GraphError(LOOSE)
        return damping

    def descend(self, kernel_sd: float) -> float:
        """Descend by damped Gauss-Newton steps (Levenberg and Marquardt); return the cost."""
        cost, damping = self._linearise(self.state, kernel_sd), 0.0
        step = np.empty_like(self.state)
        for _ in range(_STEPS):
            self._steps += 1
            damping = self._factorise(damping)
            solve_factored(self._frame, self._factor, self._equations.gradient, step)
            trial = self.state - step
            trial[: self._poses, 2] = wrap_array(trial[: self._poses, 2])
            there = self._linearise(trial, kernel_sd) if np.isfinite(trial).all() else np.inf
            if there <= cost:
                gained, cost, self.state = cost - there, there, trial
                damping = 0.0 if damping < 1e-4 else 0.1 * damping
                if gained < _SETTLED * cost:
                    break
                continue
            if there - cost < _SETTLED * cost or damping > _MOST_DAMPING:
                break
            self._linearise(self.state, kernel_sd)
            damping = max(1e-4, 10.0 * damping)
        return cost

    def solution(self, cost: float) -> RangeSolution:
        self._linearise(self.state, 0.0)
        self._factorise(0.0)
        n, m = self._poses, self._tags
        moved = replace(self._graph, poses=self.state[:n].copy(), tags=self.state[n : n + m, :2].copy())
        graph = tangents(moved, self._views, self.state, self.ranges)
        there, factors = assemble(graph)
        away = np.sqrt(
            np.maximum(link_chi2(there, factors.pairs, factors.measured, factors.information), 0.0)
        )
        return RangeSolution(
            graph=graph,
            scales=self.state[n + m :, 0].copy(),
            mounts_rad=self.state[n + m :, 1].copy(),
            offsets_m=self.state[n : n + m, 2].copy(),
            lasts_s=self._lasts_s,
            solution=GraphSolution(
                poses=graph.poses,
                tags=graph.tags,
                chi2_initial=self._begin,
                chi2=cost,
                iterations=self._steps,
                edge_residuals=away[: factors.tags_from],
                sighting_residuals=away[factors.tags_from :],
                marginals=_RangeMarginals(self.state, self._frame, self._factor),
            ),
        )
