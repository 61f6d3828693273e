"""Gauss-Newton on a tag graph, with step control and a start that needs no good guess."""

from __future__ import annotations

from math import atan2, cos, pi, sin
from typing import NamedTuple

import numpy as np
from numba import njit

from robots.estimation.graph.cholesky import factorise, solve_factored
from robots.estimation.graph.factors import Equations, Factors, Kernel, linearise, linearise_turns
from robots.estimation.graph.order import Order
from robots.se2 import Array

_FIRST_DAMPING, _MOST_DAMPING = 1e-6, 1e12
_NOTHING = 1e-16  # of W: what rounding leaves of nothing
_REUSE = 0.5  # a factor serves again while what is left to gain falls to this share of it


class Descent(NamedTuple):
    """What ``descend`` returns."""

    state: Array
    before: float
    chi2: float
    steps: int
    damping: float


@njit(cache=True)
def descend(
    state: Array,
    factors: Factors,
    equations: Equations,
    order: Order,
    factor: Array,
    kernel: Kernel,
    linear: bool,
    max_iterations: int,
    tolerance: float,
) -> tuple[Array, float, float, int, float]:
    """Return the state at the minimum, W at the start and there, the steps taken, and the damping needed.

    A step d from H d = -g promises to lower W by -g'd. The descent ends where that is less than
    ``tolerance`` of W. A step that raises W is taken back and H damped (Levenberg and Marquardt). While the
    promise falls fast the last factor is good for another step: that costs a small part of a new one.
    Damping is infinite where even the most of it gave no positive pivots.
    """
    state = state.copy()
    step, trial = np.empty_like(state), np.empty_like(state)
    chi2 = linearise(state, factors, equations, kernel, linear)
    before, damping, needed = chi2, 0.0, 0.0
    promise, fresh, steps = np.inf, False, 0
    while steps < max_iterations:
        if not fresh:
            while not factorise(order, equations, damping, factor):
                damping = max(_FIRST_DAMPING, 100.0 * damping)
                needed = max(needed, damping)
                if damping > _MOST_DAMPING:
                    return state, before, chi2, steps, np.inf
            solve_factored(order, factor, equations.gradient, step)
        steps += 1
        promise = np.sum(step * equations.gradient)
        if not np.isfinite(promise):
            return state, before, chi2, steps, np.inf
        for i in range(len(state)):
            trial[i, 0] = state[i, 0] - step[i, 0]
            trial[i, 1] = state[i, 1] - step[i, 1]
            turn = state[i, 2] - step[i, 2]
            trial[i, 2] = turn if -pi < turn <= pi else atan2(sin(turn), cos(turn))
        lowered = linearise(trial, factors, equations, kernel, linear)
        if lowered > chi2 * (1.0 + 1e-12) + _NOTHING and not linear:
            if promise <= tolerance * chi2 + _NOTHING:
                linearise(state, factors, equations, kernel, linear)
                break  # as low as the arithmetic can tell
            if not fresh:
                damping = max(1e-4, 10.0 * damping)
            if damping > _MOST_DAMPING:
                break
            linearise(state, factors, equations, kernel, linear)
            fresh = False
            continue
        state, trial, chi2 = trial, state, lowered
        if promise <= tolerance * chi2 + _NOTHING:
            break
        solve_factored(order, factor, equations.gradient, step)
        left = np.sum(step * equations.gradient)
        fresh = bool(damping == 0.0 and left < _REUSE * promise)
        if damping == 0.0 and left <= tolerance * chi2 + _NOTHING:
            break
        damping = 0.0 if damping < 1e-3 else 0.1 * damping
        damping = max(damping, needed)
    return state, before, chi2, steps, needed


@njit(cache=True)
def relaxed(
    state: Array, factors: Factors, equations: Equations, order: Order, factor: Array
) -> tuple[Array, bool]:
    """Return a start that owes nothing to ``state``, and whether there is one.

    First the headings, by the chordal relaxation, then the places, linear once the headings are known.
    """
    state = state.copy()
    step = np.empty_like(state)
    linearise_turns(state, factors, equations)
    if not factorise(order, equations, _FIRST_DAMPING, factor):
        return state, False
    solve_factored(order, factor, equations.gradient, step)
    for i in range(len(state)):
        if step[i, 0] ** 2 + step[i, 1] ** 2 > 1e-12:
            state[i, 2] = atan2(-step[i, 1], -step[i, 0])
    linearise(state, factors, equations, Kernel(np.inf, False), True)
    if not factorise(order, equations, _FIRST_DAMPING, factor):
        return state, False
    solve_factored(order, factor, equations.gradient, step)
    state[:, :2] -= step[:, :2]
    return state, bool(np.all(np.isfinite(state)))
