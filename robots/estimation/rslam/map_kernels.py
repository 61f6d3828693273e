"""Another robot's map in every particle: how it lies in the particle's own, and what it says of a node.

The other frame lies at T = (x, y, turn) in the particle's. T is drawn in each particle from what the common
nodes say of it; given T, the other robot's places are independent measurements of the particle's nodes. So
what is not known of T stays in the spread of the particles, and no node is told more than the other robot
knew.
"""

from __future__ import annotations

from math import cos, log, sin, sqrt

import numpy as np
from numba import njit

from robots.se2 import Array

_HUBER_SD = 3.0


@njit(cache=True)
def align(
    blocks: Array,
    scales: Array,
    places: Array,
    spreads: Array,
    start: Array,
    prior: Array,
    noise: Array,
    frames: Array,
    evidence: Array,
) -> None:
    """Draw in each particle how the other frame lies, about the best fit of the common nodes.

    Args:
        blocks: (k, 12, M) filters of the common nodes.
        scales: (2, M).
        places: (k, 2) of them in the other map.
        spreads: (k, 2, 2) their covariances there.
        start: (3,) how the frame lies in the mean of all particles.
        prior: (3, 3) information on how the frame lies, about ``start``.
        noise: (3, M) standard normal.
        frames: (3, M) is written.
        evidence: (M,) the log-likelihood of the other map, but for a constant, is written.
    """
    for p in range(blocks.shape[2]):
        x, y, turn = start[0], start[1], start[2]
        for last in (False, False, True):
            c, s = cos(turn), sin(turn)
            a = prior.copy()
            off = np.array([start[0] - x, start[1] - y, start[2] - turn])
            g = prior @ off
            cost = off @ g
            for k in range(len(places)):
                mx, my = c * places[k, 0] - s * places[k, 1], s * places[k, 0] + c * places[k, 1]
                sxx, sxy, syy = _turned(spreads[k], c, s)
                bx, by, vs = blocks[k, 3, p], blocks[k, 4, p], scales[1, p]
                sxx += blocks[k, 6, p] + bx * bx * vs
                sxy += blocks[k, 7, p] + bx * by * vs
                syy += blocks[k, 8, p] + by * by * vs
                det = sxx * syy - sxy * sxy
                wxx, wxy, wyy = syy / det, -sxy / det, sxx / det
                rx = blocks[k, 0, p] + bx * scales[0, p] - x - mx
                ry = blocks[k, 1, p] + by * scales[0, p] - y - my
                ex, ey = wxx * rx + wxy * ry, wxy * rx + wyy * ry
                # by the turn the place moves by (-my, mx)
                tx, ty = -wxx * my + wxy * mx, -wxy * my + wyy * mx
                a[0, 0] += wxx
                a[0, 1] += wxy
                a[1, 1] += wyy
                a[0, 2] += tx
                a[1, 2] += ty
                a[2, 2] += -my * tx + mx * ty
                g[0] += ex
                g[1] += ey
                g[2] += -my * ex + mx * ey
                cost += rx * ex + ry * ey + log(det)
            a[1, 0], a[2, 0], a[2, 1] = a[0, 1], a[0, 2], a[1, 2]
            if not last:
                step = np.linalg.solve(a, g)
                x, y, turn = x + step[0], y + step[1], turn + step[2]
            else:
                root = np.linalg.cholesky(a)  # noise of covariance a^-1 solves root^T z = noise
                z = np.linalg.solve(root.T, noise[:, p].copy())
                frames[0, p], frames[1, p], frames[2, p] = x + z[0], y + z[1], turn + z[2]
                evidence[p] = -0.5 * cost
                evidence[p] -= log(root[0, 0]) + log(root[1, 1]) + log(root[2, 2])


@njit(cache=True)
def _turned(spread: Array, c: float, s: float) -> tuple[float, float, float]:
    xx, xy, yy = spread[0, 0], spread[0, 1], spread[1, 1]
    return (
        c * c * xx - 2.0 * c * s * xy + s * s * yy,
        c * s * (xx - yy) + (c * c - s * s) * xy,
        s * s * xx + 2.0 * c * s * xy + c * c * yy,
    )


@njit(cache=True)
def begin(block: Array, place: Array, spread: Array, frames: Array, offset_variance: float) -> None:
    """Begin a node where another robot's map has it."""
    for p in range(block.shape[1]):
        c, s = cos(frames[2, p]), sin(frames[2, p])
        block[:, p] = 0.0
        block[0, p] = frames[0, p] + c * place[0] - s * place[1]
        block[1, p] = frames[1, p] + s * place[0] + c * place[1]
        block[6, p], block[7, p], block[8, p] = _turned(spread, c, s)
        block[11, p] = offset_variance


@njit(cache=True)
def told(block: Array, scales: Array, place: Array, spread: Array, frames: Array, fits: Array) -> None:
    """Correct a node, and the scale, by the place that another robot's map has for it.

    ``fits`` (M,): the log-likelihood of the place, but for a constant, is written.
    """
    for p in range(block.shape[1]):
        c, s = cos(frames[2, p]), sin(frames[2, p])
        mx = frames[0, p] + c * place[0] - s * place[1]
        my = frames[1, p] + s * place[0] + c * place[1]
        sxx, sxy, syy = _turned(spread, c, s)
        lxx = sqrt(sxx)  # whitened by the Cholesky factor, its coordinates are measured one after the other
        lyx = sxy / lxx
        lyy = sqrt(max(syy - lyx * lyx, 1e-12))
        fits[p] = _coordinate(block, scales, p, 1.0 / lxx, 0.0, mx / lxx)
        fits[p] += _coordinate(block, scales, p, -lyx / (lxx * lyy), 1.0 / lyy, (my - lyx * mx / lxx) / lyy)


@njit(cache=True)
def _coordinate(block: Array, scales: Array, p: int, hx: float, hy: float, measured: float) -> float:
    """Take in hx x + hy y = measured with variance 1."""
    scale = scales[0, p]
    px = block[6, p] * hx + block[7, p] * hy
    py = block[7, p] * hx + block[8, p] * hy
    po = block[9, p] * hx + block[10, p] * hy
    by_scale = hx * block[3, p] + hy * block[4, p]
    v = measured - hx * block[0, p] - hy * block[1, p] - by_scale * scale
    spread = hx * px + hy * py + 1.0 + by_scale * by_scale * scales[1, p]
    excess = max(sqrt(v * v / spread) / _HUBER_SD - 1.0, 0.0)
    given_scale = hx * px + hy * py + 1.0 + spread * excess
    kx, ky, ko = px / given_scale, py / given_scale, po / given_scale
    at_zero = v + by_scale * scale
    block[0, p] += kx * at_zero
    block[1, p] += ky * at_zero
    block[2, p] += ko * at_zero
    block[3, p] -= kx * by_scale
    block[4, p] -= ky * by_scale
    block[5, p] -= ko * by_scale
    block[6, p] -= kx * px
    block[7, p] -= kx * py
    block[8, p] -= ky * py
    block[9, p] -= kx * po
    block[10, p] -= ky * po
    block[11, p] -= ko * po
    gain = by_scale * scales[1, p] / (given_scale + by_scale * by_scale * scales[1, p])
    scales[0, p] = scale + gain * v
    scales[1, p] -= gain * by_scale * scales[1, p]
    return float(-0.5 * (v * v / spread + log(spread)))


@njit(cache=True)
def align_by_ranges(
    places: Array,
    antennas: Array,
    ranges: Array,
    noises: Array,
    placed: Array,
    scales: Array,
    start: Array,
    turn_variance: float,
    noise: Array,
    frames: Array,
    evidence: Array,
) -> None:
    """Draw in each particle how the other frame lies, by ranges to nodes of the other map.

    ``places`` (k, 2) of the nodes in the other map and ``placed`` (k,) variances of those in any direction;
    ``antennas`` (k, 2, M), ``ranges`` (k,), ``noises`` (k, 2) as in ``innovations``; the rest as in
    ``align``.
    """
    for p in range(antennas.shape[2]):
        x, y, turn = start[0], start[1], start[2]
        scale, scale_variance = scales[0, p], scales[1, p]
        for last in (False, False, False, True):
            c, s = cos(turn), sin(turn)
            a = np.zeros((3, 3))
            g = np.zeros(3)
            a[2, 2] = 1.0 / turn_variance
            g[2] = (start[2] - turn) / turn_variance
            cost = 0.0
            for k in range(len(ranges)):
                mx, my = c * places[k, 0] - s * places[k, 1], s * places[k, 0] + c * places[k, 1]
                dx, dy = x + mx - antennas[k, 0, p], y + my - antennas[k, 1, p]
                d = max(sqrt(dx * dx + dy * dy), 0.05)
                expected = scale * d
                variance = noises[k, 0] ** 2 + placed[k] + scale_variance * d * d
                v = ranges[k] - expected
                if noises[k, 1] > 0.0:
                    variance += (noises[k, 1] * expected) ** 2
                    v = expected * log(ranges[k] / expected)
                    cost -= 2.0 * log(expected)
                hx, hy = scale * dx / d, scale * dy / d
                ht = -hx * my + hy * mx
                w = 1.0 / variance
                a[0, 0] += w * hx * hx
                a[0, 1] += w * hx * hy
                a[0, 2] += w * hx * ht
                a[1, 1] += w * hy * hy
                a[1, 2] += w * hy * ht
                a[2, 2] += w * ht * ht
                g[0] += w * hx * v
                g[1] += w * hy * v
                g[2] += w * ht * v
                cost += w * v * v + log(variance)
            a[1, 0], a[2, 0], a[2, 1] = a[0, 1], a[0, 2], a[1, 2]
            if not last:
                step = np.linalg.solve(a, g)
                x, y, turn = x + step[0], y + step[1], turn + step[2]
            else:
                root = np.linalg.cholesky(a)
                z = np.linalg.solve(root.T, noise[:, p].copy())
                frames[0, p], frames[1, p], frames[2, p] = x + z[0], y + z[1], turn + z[2]
                off = turn - start[2]
                evidence[p] = -0.5 * (cost + off * off / turn_variance)
                evidence[p] -= log(root[0, 0]) + log(root[1, 1]) + log(root[2, 2])
