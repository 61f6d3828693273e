"""Errors of the tag graph's factors and the normal equations they add up to, each written once.

Every vertex is a row (x, y, theta) of ``state``; a tag has no heading, its third number is 0 and stays so.
A *link* measures vertex b in the frame of vertex a: an edge whole, a sighting only the place (the third row
and column of its information are 0). An *anchor* is a value known of one vertex alone: a prior, a heading.

    e = (R_a' (t_b - t_a) - t_ab, wrap(theta_b - theta_a - theta_ab))                     (as g2o has it)

With T = diag(R_a', 1), q = (-(y_b - y_a), x_b - x_a) and S = [I q; 0 1] the Jacobians are

    de/db = T,   de/da = -T S                                                             (J)

so that with M = T' Omega T and r = T' Omega e the blocks of the normal equations are

    H_bb = M,   H_ba = -M S,   H_aa = S' M S,   g_b = r,   g_a = -S' r                    (H)
"""

from __future__ import annotations

from math import atan2, cos, sin, sqrt
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robots.graph_report import IntArray
from robots.se2 import Array

BoolArray = NDArray[np.bool_]


class Factors(NamedTuple):
    """All that was measured. Links from ``tags_from`` on are sightings; ``robust`` ones carry the kernel."""

    pairs: IntArray  # (k, 2) vertices a and b
    measured: Array  # (k, 3)
    information: Array  # (k, 3, 3)
    robust: BoolArray  # (k,)
    tags_from: int
    anchored: IntArray  # (p,) vertices
    values: Array  # (p, 3)
    weights: Array  # (p, 3) inverse variances, 0 where a value says nothing


class Kernel(NamedTuple):
    """What a robust link costs beyond ``sd`` deviations. Up to there all kernels cost the square.

    Huber 1964 grows linearly from there and still pulls; the redescending kernel of Dynamic Covariance
    Scaling (Agarwal et al. 2013) tends to 3 sd^2 and lets go.
    """

    sd: float
    redescends: bool


class Equations(NamedTuple):
    """The normal equations H d = -g by blocks of 3.

    ``slot`` (k,) is the place of each link's block in ``beside``, -1 for a link of a vertex to itself;
    ``turned`` (k,) says that the block is kept as H_ab, else as H_ba. Blocks keep their places, zero or not.
    """

    slot: IntArray
    turned: IntArray
    diagonal: Array  # (n, 3, 3)
    beside: Array  # (b, 3, 3)
    gradient: Array  # (n, 3)


@njit(cache=True)
def link_error(a: Array, b: Array, measured: Array) -> tuple[float, float, float]:
    """Return e of vertex b seen from vertex a, each (3,)."""
    c, s = cos(a[2]), sin(a[2])
    dx, dy = b[0] - a[0], b[1] - a[1]
    turn = b[2] - a[2] - measured[2]
    return (
        c * dx + s * dy - measured[0],
        -s * dx + c * dy - measured[1],
        atan2(sin(turn), cos(turn)),
    )


@njit(cache=True)
def between_jacobian(a: Array, b: Array) -> Array:
    """Return the Jacobian (3, 6) of vertex b seen from vertex a, by a and b: [-T S, T], eq. (J)."""
    c, s = cos(a[2]), sin(a[2])
    dx, dy = b[0] - a[0], b[1] - a[1]
    J = np.zeros((3, 6))
    J[0, 3], J[0, 4], J[1, 3], J[1, 4], J[2, 5] = c, s, -s, c, 1.0
    J[:, :3] = -J[:, 3:]
    J[0, 2], J[1, 2] = -s * dx + c * dy, -c * dx - s * dy
    return J


@njit(cache=True)
def link_chi2(state: Array, pairs: IntArray, measured: Array, information: Array) -> Array:
    """Return e' Omega e of each link, (k,): their sum is g2o's chi2."""
    result = np.empty(len(pairs))
    for k in range(len(pairs)):
        o = information[k]
        e0, e1, e2 = link_error(state[pairs[k, 0]], state[pairs[k, 1]], measured[k])
        result[k] = (
            e0 * (o[0, 0] * e0 + 2.0 * (o[0, 1] * e1 + o[0, 2] * e2))
            + e1 * (o[1, 1] * e1 + 2.0 * o[1, 2] * e2)
            + e2 * e2 * o[2, 2]
        )
    return result


@njit(cache=True)
def beyond(state: Array, factors: Factors, sd: float) -> int:
    """Return how many robust links are more than ``sd`` deviations from what was measured."""
    squares = link_chi2(state, factors.pairs, factors.measured, factors.information)
    return int(np.sum(factors.robust & (squares > sd * sd)))


@njit(cache=True)
def largest_turn(state: Array, factors: Factors) -> float:
    """Return the largest heading error of the links that measure one, in radians."""
    worst = 0.0
    for k in range(len(factors.pairs)):
        if factors.information[k, 2, 2] > 0.0:
            a, b = factors.pairs[k]
            worst = max(worst, abs(link_error(state[a], state[b], factors.measured[k])[2]))
    return worst


@njit(cache=True)
def linearise(state: Array, factors: Factors, equations: Equations, kernel: Kernel, linear: bool) -> float:
    """Write the normal equations at ``state`` and return W there: errors, blocks and sum in one pass.

    ``linear`` holds the headings as they are, as Kleiner does with his compass.
    """
    clear(equations)
    total: float = add_factors(state, factors, equations, kernel, linear)
    hold_unmeasured(equations, linear)
    return total


@njit(cache=True)
def clear(equations: Equations) -> None:
    """Set all blocks to zero."""
    equations.diagonal[:] = 0.0
    equations.beside[:] = 0.0
    equations.gradient[:] = 0.0


@njit(cache=True)
def hold_unmeasured(equations: Equations, linear: bool) -> None:
    """Hold what has no equation: headings that are to stay, those that tags do not have, the unmeasured."""
    diagonal, gradient = equations.diagonal, equations.gradient
    for i in range(len(diagonal)):
        for d in range(3):
            if (linear and d == 2) or diagonal[i, d, d] == 0.0:
                diagonal[i, d, d] = 1.0
                gradient[i, d] = 0.0


@njit(cache=True)
def add_factors(state: Array, factors: Factors, equations: Equations, kernel: Kernel, linear: bool) -> float:
    """Add all factors to the normal equations and return what they cost."""
    diagonal, beside, gradient = equations.diagonal, equations.beside, equations.gradient
    total, limit = 0.0, kernel.sd * kernel.sd
    for k in range(len(factors.pairs)):
        i, j = factors.pairs[k, 0], factors.pairs[k, 1]
        o = factors.information[k]
        o00, o01, o11 = o[0, 0], o[0, 1], o[1, 1]
        o02, o12, o22 = o[0, 2], o[1, 2], o[2, 2]
        c, s = cos(state[i, 2]), sin(state[i, 2])
        dx, dy = state[j, 0] - state[i, 0], state[j, 1] - state[i, 1]
        e0 = c * dx + s * dy - factors.measured[k, 0]
        e1 = -s * dx + c * dy - factors.measured[k, 1]
        q0, q1, e2 = 0.0, 0.0, 0.0
        if linear:  # the inverse of the places' own covariance
            if o22 > 0.0:
                o00, o01, o11 = o00 - o02 * o02 / o22, o01 - o02 * o12 / o22, o11 - o12 * o12 / o22
            o02, o12, o22 = 0.0, 0.0, 0.0
        else:
            q0, q1 = -dy, dx
            if o22 > 0.0:
                turn = state[j, 2] - state[i, 2] - factors.measured[k, 2]
                e2 = atan2(sin(turn), cos(turn))
        w0 = o00 * e0 + o01 * e1 + o02 * e2
        w1 = o01 * e0 + o11 * e1 + o12 * e2
        w2 = o02 * e0 + o12 * e1 + o22 * e2
        square = w0 * e0 + w1 * e1 + w2 * e2
        weight = 1.0
        if factors.robust[k] and square > limit:
            if kernel.redescends:
                share = 2.0 * limit / (limit + square)
                weight = share * share
                square = limit * (3.0 * square - limit) / (limit + square)
            else:
                weight = kernel.sd / sqrt(square)
                square = 2.0 * kernel.sd * sqrt(square) - limit
        total += square
        if equations.slot[k] < 0:
            continue  # a vertex seen from itself: the error is what it is, nothing moves it
        # M = T' Omega T and r = T' Omega e, eq. (H)
        a00, a01 = c * o00 - s * o01, c * o01 - s * o11
        a10, a11 = s * o00 + c * o01, s * o01 + c * o11
        m00, m01, m11 = (
            weight * (a00 * c - a01 * s),
            weight * (a00 * s + a01 * c),
            weight * (a10 * s + a11 * c),
        )
        m02, m12, m22 = weight * (c * o02 - s * o12), weight * (s * o02 + c * o12), weight * o22
        r0, r1, r2 = weight * (c * w0 - s * w1), weight * (s * w0 + c * w1), weight * w2
        # the third column of M S, and the last entry of S' M S
        n02, n12, n22 = m00 * q0 + m01 * q1 + m02, m01 * q0 + m11 * q1 + m12, m02 * q0 + m12 * q1 + m22
        last = q0 * n02 + q1 * n12 + n22
        gradient[j, 0] += r0
        gradient[j, 1] += r1
        gradient[j, 2] += r2
        gradient[i, 0] -= r0
        gradient[i, 1] -= r1
        gradient[i, 2] -= q0 * r0 + q1 * r1 + r2
        _add(diagonal[j], m00, m01, m02, m01, m11, m12, m02, m12, m22)
        _add(diagonal[i], m00, m01, n02, m01, m11, n12, n02, n12, last)
        block = beside[equations.slot[k]]
        if equations.turned[k]:
            _add(block, -m00, -m01, -m02, -m01, -m11, -m12, -n02, -n12, -n22)
        else:
            _add(block, -m00, -m01, -n02, -m01, -m11, -n12, -m02, -m12, -n22)
    for k in range(len(factors.anchored)):
        i = factors.anchored[k]
        for d in range(2 if linear else 3):
            error = state[i, d] - factors.values[k, d]
            if d == 2:
                error = atan2(sin(error), cos(error))
            weight = factors.weights[k, d]
            total += weight * error * error
            diagonal[i, d, d] += weight
            gradient[i, d] += weight * error
    return total


@njit(cache=True, inline="always")
def _add(
    block: Array,
    b00: float,
    b01: float,
    b02: float,
    b10: float,
    b11: float,
    b12: float,
    b20: float,
    b21: float,
    b22: float,
) -> None:
    block[0, 0] += b00
    block[0, 1] += b01
    block[0, 2] += b02
    block[1, 0] += b10
    block[1, 1] += b11
    block[1, 2] += b12
    block[2, 0] += b20
    block[2, 1] += b21
    block[2, 2] += b22


@njit(cache=True)
def linearise_turns(state: Array, factors: Factors, equations: Equations) -> None:
    """Write the equations of the chordal relaxation (Carlone et al. 2015), in which no start is needed.

    Each heading is a free vector z = (cos, sin); minimised is the sum of w |z_b - R_ab z_a|^2, a linear
    problem. The blocks take the places of the graph's own.
    """
    diagonal, beside, gradient = equations.diagonal, equations.beside, equations.gradient
    diagonal[:] = 0.0
    beside[:] = 0.0
    gradient[:] = 0.0
    for k in range(len(factors.pairs)):
        weight = factors.information[k, 2, 2]
        if equations.slot[k] < 0 or weight <= 0.0:
            continue
        c, s = weight * cos(factors.measured[k, 2]), weight * sin(factors.measured[k, 2])
        block = beside[equations.slot[k]]
        across = s if equations.turned[k] else -s
        block[0, 0] -= c
        block[1, 1] -= c
        block[0, 1] -= across
        block[1, 0] += across
        for i in factors.pairs[k]:
            diagonal[i, 0, 0] += weight
            diagonal[i, 1, 1] += weight
    for k in range(len(factors.anchored)):
        i, weight = factors.anchored[k], factors.weights[k, 2]
        diagonal[i, 0, 0] += weight
        diagonal[i, 1, 1] += weight
        gradient[i, 0] -= weight * cos(factors.values[k, 2])
        gradient[i, 1] -= weight * sin(factors.values[k, 2])
    for i in range(len(state)):
        diagonal[i, 2, 2] = 1.0
        if diagonal[i, 0, 0] == 0.0:  # nobody measured its heading: it stays what it is
            diagonal[i, 0, 0] = diagonal[i, 1, 1] = 1.0
            gradient[i, 0], gradient[i, 1] = -cos(state[i, 2]), -sin(state[i, 2])
