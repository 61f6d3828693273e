"""Ranges and bearings between a pose and what was seen from it, with what is unknown of the radios.

Unknowns are vertices of three numbers, as the solver has them: a pose (x, y, theta), a tag (x, y, b) with the
offset b of its ranges, a radio (s, beta, -) with the scale of its ranges and the error of its mounting. From
a pose R, t with its antenna at arm a, facing alpha, q = t_j - t_i - R a, d = |q|:

    e_r = s d + b - r,     e_b = wrap(atan2(q) - theta_i - alpha + beta - bearing)                       (R)

A range with a bearing comes from an instrument that measures lengths (a camera, a laser): s = 1, b = 0 there;
without one it comes from a radio, whose lengths are not known.
"""

from __future__ import annotations

from math import atan2, cos, isnan, log1p, sin, sqrt
from typing import NamedTuple

import numpy as np
from numba import njit

from robots.estimation.graph.factors import Equations
from robots.graph_report import IntArray
from robots.se2 import Array

_NEAREST_M = 1e-6  # nearer than this a direction means nothing
_TAIL = 4.0  # degrees of freedom of Student's t: about what real ranges scatter like


class Ranges(NamedTuple):
    """What was seen from afar, row by row (q,), and what is known beforehand of the instruments.

    ``shares``: as how much of an independent measurement range and bearing count, (q, 2).
    """

    poses: IntArray  # (q,) vertices seen from,
    seen: IntArray  # (q,) vertices seen: tags, or poses of robots
    radios: IntArray  # (q,) vertices of the instruments
    links: IntArray  # (q, 3) where the equations keep pose-seen, pose-radio, seen-radio
    arms: Array  # (q, 3) antenna in the pose's frame
    ranges: Array  # (q,)
    sds: Array  # (q,) at the expected range
    bearings: Array  # (q,) NaN where there is none
    bearing_sds: Array  # (q,)
    shares: Array  # (q, 2)
    priors: IntArray  # (p,) vertices of tags and radios of which something is known beforehand
    means: Array  # (p, 3)
    weights: Array  # (p, 3) inverse variances


@njit(cache=True)
def range_errors(state: Array, ranges: Ranges, k: int, J: Array) -> tuple[float, float, float]:
    """Return e_r, e_b (0 without a bearing) and d of row k; write their Jacobian (2, 9), eq. (R).

    Its columns are those of pose, seen and radio.
    """
    i, j, c = ranges.poses[k], ranges.seen[k], ranges.radios[k]
    cosine, sine = cos(state[i, 2]), sin(state[i, 2])
    ax = cosine * ranges.arms[k, 0] - sine * ranges.arms[k, 1]
    ay = sine * ranges.arms[k, 0] + cosine * ranges.arms[k, 1]
    x, y = state[j, 0] - state[i, 0] - ax, state[j, 1] - state[i, 1] - ay
    d = max(sqrt(x * x + y * y), _NEAREST_M)
    ux, uy = x / d, y / d
    J[:] = 0.0
    directed = not isnan(ranges.bearings[k])
    s = 1.0 if directed else state[c, 0]
    J[0, 0], J[0, 1], J[0, 2] = -s * ux, -s * uy, s * (ux * ay - uy * ax)
    J[0, 3], J[0, 4] = s * ux, s * uy
    if not directed:
        J[0, 5], J[0, 6] = 1.0, d
        return s * d + state[j, 2] - ranges.ranges[k], 0.0, d
    turn = atan2(y, x) - state[i, 2] - ranges.arms[k, 2] + state[c, 1] - ranges.bearings[k]
    vx, vy = -uy / d, ux / d
    J[1, 0], J[1, 1], J[1, 2] = -vx, -vy, vx * ay - vy * ax - 1.0
    J[1, 3], J[1, 4], J[1, 7] = vx, vy, 1.0
    return d - ranges.ranges[k], atan2(sin(turn), cos(turn)), d


@njit(cache=True)
def weigh(chi2: float, kernel_sd: float) -> tuple[float, float]:
    """Return weight and cost of a squared error: Student's t, or Huber's where ``kernel_sd`` is above 0."""
    if kernel_sd <= 0.0:
        return (_TAIL + 1.0) / (_TAIL + chi2), (_TAIL + 1.0) * log1p(chi2 / _TAIL)
    limit = kernel_sd * kernel_sd
    if chi2 <= limit:
        return 1.0, chi2
    return kernel_sd / sqrt(chi2), 2.0 * kernel_sd * sqrt(chi2) - limit


@njit(cache=True)
def add_ranges(state: Array, ranges: Ranges, equations: Equations, kernel_sd: float) -> float:
    """Add ranges, bearings and priors to the normal equations and return what they cost."""
    J = np.empty((2, 9))
    vertices = np.empty(3, np.int64)
    total = 0.0
    for k in range(len(ranges.ranges)):
        along, turn, _ = range_errors(state, ranges, k, J)
        vertices[0], vertices[1], vertices[2] = ranges.poses[k], ranges.seen[k], ranges.radios[k]
        for row in range(1 if isnan(ranges.bearings[k]) else 2):
            error = along if row == 0 else turn
            sd = ranges.sds[k] if row == 0 else ranges.bearing_sds[k]
            weight, cost = weigh((error / sd) ** 2, kernel_sd)
            share = ranges.shares[k, row]
            total += share * cost
            weight *= share / (sd * sd)
            for a in range(3):
                for p in range(3):
                    left = weight * J[row, 3 * a + p]
                    equations.gradient[vertices[a], p] += left * error
                    for q in range(3):
                        equations.diagonal[vertices[a], p, q] += left * J[row, 3 * a + q]
            for link in range(3):
                a, b = (0, 1) if link == 0 else (link - 1, 2)
                at = ranges.links[k, link]
                block = equations.beside[equations.slot[at]]
                if not equations.turned[at]:
                    a, b = b, a  # the block is kept as H_ba
                for p in range(3):
                    for q in range(3):
                        block[p, q] += weight * J[row, 3 * a + p] * J[row, 3 * b + q]
    for k in range(len(ranges.priors)):
        i = ranges.priors[k]
        for p in range(3):
            error = state[i, p] - ranges.means[k, p]
            total += ranges.weights[k, p] * error * error
            equations.diagonal[i, p, p] += ranges.weights[k, p]
            equations.gradient[i, p] += ranges.weights[k, p] * error
    return total


@njit(cache=True)
def expected_ranges(state: Array, ranges: Ranges) -> tuple[Array, Array]:
    """Return each range as it ought to have been measured (q,), and the errors (q, 2) against that."""
    expected, errors = np.empty(len(ranges.ranges)), np.empty((len(ranges.ranges), 2))
    J = np.empty((2, 9))
    for k in range(len(ranges.ranges)):
        errors[k, 0], errors[k, 1], _ = range_errors(state, ranges, k, J)
        expected[k] = ranges.ranges[k] + errors[k, 0]
    return expected, errors
