"""One range against one node in every particle (Sun 2009 eq. 2 to 9), with what the radio adds to ranges.

    z = s d + o + noise,    d = |b - r|
with the node's place b, its offset o and a scale s common to all nodes. Given a particle's path *and s* the
nodes are independent, so a particle keeps of each node the Gaussian of m = (b_x, b_y, o) given s,
    m | s ~ N(a + B s, P),
and a Gaussian of s beside them. That is the exact joint Gaussian of all nodes and s, at the cost of one node.

A filter of a node is a block (12, M): a_x, a_y, a_o, B_x, B_y, B_o, P_xx, P_xy, P_yy, P_xo, P_yo, P_oo.
Particles' scales are (2, M), mean and variance.
"""

from __future__ import annotations

from math import exp, hypot, log, log1p, pi, sqrt

import numpy as np
from numba import njit

from robots.se2 import Array

ROWS = 12
WORK_ROWS = 9
_NEAREST_M = 0.05
_HUBER_SD = 3.0
_LOG_2PI = log(2.0 * pi)


@njit(cache=True)
def age_offset(block: Array, kept: float, gained: float) -> None:
    """Let the part of the offset that lasts only for a while fade: o <- kept * o + N(0, gained)."""
    for p in range(block.shape[1]):
        block[2, p] *= kept
        block[5, p] *= kept
        block[9, p] *= kept
        block[10, p] *= kept
        block[11, p] = kept * kept * block[11, p] + gained


@njit(cache=True)
def innovations(
    block: Array,
    scales: Array,
    antennas: Array,
    range_m: float,
    noise: tuple[float, float],
    outliers: tuple[float, float],
    work: Array,
) -> None:
    """Write what a range says of a node in each particle into ``work`` (9, M).

    Its rows: innovation, its variance, log-likelihood, how probably the range is no outlier; and for
    ``correct`` h_x, h_y, the derivative by the scale, the variance given the scale, and what the range's
    curvature adds to that. ``antennas`` (2, M): from where it was measured. ``outliers``: share of ranges
    that follow no model, and over how many metres they spread. ``noise``: deviation in metres or, where the
    error grows with the distance, of ln z: then it is taken at the distance expected, not the one measured.
    """
    far = log(outliers[0] / outliers[1])
    near = log(1.0 - outliers[0]) - 0.5 * _LOG_2PI
    for p in range(block.shape[1]):
        scale = scales[0, p]
        dx = block[0, p] + block[3, p] * scale - antennas[0, p]
        dy = block[1, p] + block[4, p] * scale - antennas[1, p]
        d = sqrt(dx * dx + dy * dy + _NEAREST_M * _NEAREST_M)
        ux, uy = dx / d, dy / d
        hx, hy = scale * ux, scale * uy  # (5)
        xx, xy, yy = block[6, p], block[7, p], block[8, p]
        xo, yo, oo = block[9, p], block[10, p], block[11, p]
        # the range is a curved function of the place: mean and variance to second order
        bent = 0.5 * scale * (uy * uy * xx - 2.0 * ux * uy * xy + ux * ux * yy) / d
        by_scale = d + hx * block[3, p] + hy * block[4, p] + block[5, p]
        expected = scale * d + block[2, p] + block[5, p] * scale + bent  # (2)
        variance = noise[0] * noise[0]
        work[0, p] = range_m - expected  # (3)
        if noise[1] > 0.0:
            expected = max(expected, _NEAREST_M)
            variance = (noise[1] * expected) ** 2
            work[0, p] = expected * log(range_m / expected)
        given_scale = hx * (hx * xx + 2.0 * (hy * xy + xo)) + hy * (hy * yy + 2.0 * yo) + oo + variance
        work[3, p] = expected
        work[1, p] = given_scale + 2.0 * bent * bent + by_scale * by_scale * scales[1, p]  # (4)
        work[4, p], work[5, p], work[6, p] = hx, hy, by_scale
        work[7, p], work[8, p] = given_scale, 2.0 * bent * bent
    for p in range(block.shape[1]):
        spread = work[1, p]
        fits = near - 0.5 * (work[0, p] * work[0, p] / spread + log(spread))  # (9), with its normaliser
        if noise[1] > 0.0:
            fits += log(work[3, p] / range_m)  # of z, not of ln z
        lesser = exp(-abs(far - fits))
        work[2, p] = max(far, fits) + log1p(lesser)
        work[3, p] = (1.0 if fits > far else lesser) / (1.0 + lesser)


@njit(cache=True)
def correct(block: Array, scales: Array, work: Array, teach_scale: bool) -> None:
    """Correct a node, and the scale where ``teach_scale``, by the innovations in ``work``, eq. (6) to (8).

    An innovation beyond three deviations counts as a noisier range (Huber).
    """
    for p in range(block.shape[1]):
        scale, v, spread = scales[0, p], work[0, p], work[1, p]
        hx, hy, by_scale = work[4, p], work[5, p], work[6, p]
        px = block[6, p] * hx + block[7, p] * hy + block[9, p]
        py = block[7, p] * hx + block[8, p] * hy + block[10, p]
        po = block[9, p] * hx + block[10, p] * hy + block[11, p]
        excess = max(sqrt(v * v / spread) / _HUBER_SD - 1.0, 0.0)
        given_scale = work[7, p] + work[8, p] + spread * excess
        kx, ky, ko = px / given_scale, py / given_scale, po / given_scale  # (6)
        # given another scale s', the innovation is v - by_scale (s' - s)
        at_zero = v + by_scale * scale
        block[0, p] += kx * at_zero  # (7)
        block[1, p] += ky * at_zero
        block[2, p] += ko * at_zero
        block[3, p] -= kx * by_scale
        block[4, p] -= ky * by_scale
        block[5, p] -= ko * by_scale
        block[6, p] -= kx * px  # (8)
        block[7, p] -= kx * py
        block[8, p] -= ky * py
        block[9, p] -= kx * po
        block[10, p] -= ky * po
        block[11, p] -= ko * po
        if teach_scale:
            gain = by_scale * scales[1, p] / (given_scale + by_scale * by_scale * scales[1, p])
            scales[0, p] = scale + gain * v
            scales[1, p] -= gain * by_scale * scales[1, p]


@njit(cache=True)
def settle(
    block: Array,
    scales: Array,
    antennas: Array,
    ranges: Array,
    noises: Array,
    start: tuple[float, float],
    offset_variance: float,
    evidence: Array,
    teach_scale: bool,
) -> None:
    """Begin a node in every particle from the ranges it has gathered, by Gauss-Newton from ``start``.

    ``antennas`` (k, 2, M): from where each of the k ranges was measured; ``noises`` (k, 2) as in
    ``innovations``. ``evidence`` (M,) gets the logarithm of how well they fit the particle (Laplace), but for
    a constant. Where the scale is taught, a correction of it beyond three deviations is no solution and left
    out.
    """
    count = len(ranges)
    longest = 0.2 * ranges.mean()
    for p in range(block.shape[1]):
        scale = scales[0, p]
        x, y, o = start[0], start[1], 0.0
        for turn in range(9):
            axx = ayy = 1e-8
            axy = axo = ayo = 0.0
            aoo = 1.0 / offset_variance
            gx = gy = 0.0
            go = -o / offset_variance
            cx = cy = co = dd = dv = cost = 0.0
            for k in range(count):
                dx, dy = x - antennas[k, 0, p], y - antennas[k, 1, p]
                d = max(hypot(dx, dy), _NEAREST_M)
                hx, hy, w = scale * dx / d, scale * dy / d, 1.0 / max(noises[k, 0] ** 2, 1e-9)
                v = ranges[k] - scale * d - o
                if noises[k, 1] > 0.0:
                    expected = max(scale * d + o, _NEAREST_M)
                    w = 1.0 / (noises[k, 1] * expected) ** 2
                    v = expected * log(ranges[k] / expected)
                axx += w * hx * hx
                axy += w * hx * hy
                ayy += w * hy * hy
                axo += w * hx
                ayo += w * hy
                aoo += w
                gx += w * hx * v
                gy += w * hy * v
                go += w * v
                cx += w * hx * d
                cy += w * hy * d
                co += w * d
                dd += w * d * d
                dv += w * d * v
                cost += w * v * v
            ixx, ixy, ixo = ayy * aoo - ayo * ayo, axo * ayo - axy * aoo, axy * ayo - ayy * axo
            iyy, iyo, ioo = axx * aoo - axo * axo, axy * axo - axx * ayo, axx * ayy - axy * axy
            det = axx * ixx + axy * ixy + axo * ixo
            ixx, ixy, ixo, iyy, iyo, ioo = ixx / det, ixy / det, ixo / det, iyy / det, iyo / det, ioo / det
            if turn < 8:
                sx, sy = ixx * gx + ixy * gy + ixo * go, ixy * gx + iyy * gy + iyo * go
                damped = min(1.0, longest / max(hypot(sx, sy), 1e-9))
                x += damped * sx
                y += damped * sy
                o += damped * (ixo * gx + iyo * gy + ioo * go)
        bx, by = -(ixx * cx + ixy * cy + ixo * co), -(ixy * cx + iyy * cy + iyo * co)
        bo = -(ixo * cx + iyo * cy + ioo * co)
        known = max(
            dd + cx * bx + cy * by + co * bo, 0.0
        )  # information on the scale: what the node leaves of it
        spread = scales[1, p] / (1.0 + scales[1, p] * known)
        evidence[p] = -0.5 * (cost + o * o / offset_variance + log(det))
        if teach_scale and dv * dv * spread * spread < _HUBER_SD**2 * scales[1, p]:
            evidence[p] += 0.5 * (dv * dv * spread + log(spread / scales[1, p]))
            scales[0, p] = scale + spread * dv
            scales[1, p] = spread
        block[0, p], block[1, p], block[2, p] = x - bx * scale, y - by * scale, o - bo * scale
        block[3, p], block[4, p], block[5, p] = bx, by, bo
        block[6, p], block[7, p], block[8, p] = ixx, ixy, iyy
        block[9, p], block[10, p], block[11, p] = ixo, iyo, ioo


@njit(cache=True)
def spread_of(block: Array, scales: Array, weights: Array) -> Array:
    """Return mean (x, y, offset) and covariance (3, 3) of a node over all particles, (4, 3)."""
    out = np.zeros((4, 3))
    mean, total = np.zeros(3), np.zeros((3, 3))
    at = np.empty(3)
    for p in range(block.shape[1]):
        for i in range(3):
            mean[i] += weights[p] * (block[i, p] + block[3 + i, p] * scales[0, p])
    for p in range(block.shape[1]):
        w, vs = weights[p], scales[1, p]
        for i in range(3):
            at[i] = block[i, p] + block[3 + i, p] * scales[0, p] - mean[i]
        for i in range(3):
            for j in range(3):
                total[i, j] += w * (at[i] * at[j] + block[3 + i, p] * block[3 + j, p] * vs)
        total[0, 0] += w * block[6, p]
        total[0, 1] += w * block[7, p]
        total[1, 0] += w * block[7, p]
        total[1, 1] += w * block[8, p]
        total[0, 2] += w * block[9, p]
        total[2, 0] += w * block[9, p]
        total[1, 2] += w * block[10, p]
        total[2, 1] += w * block[10, p]
        total[2, 2] += w * block[11, p]
    out[0], out[1:] = mean, total
    return out
