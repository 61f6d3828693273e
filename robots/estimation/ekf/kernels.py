"""Kernels of the EKF over pose and tags: prediction and correction with an invariant error.

The state of the near tags is ``mean`` (n,) = heading, x, y, turned, x_1, y_1, x_2, y_2, ... in the map frame.
Its error is the right-invariant one of SE_{1+n}(2) (Barrau and Bonnabel 2015, An EKF-SLAM algorithm with
consistency properties): with a = heading error and J the quarter turn

    true = exp(a) point + V(a) error,    so to first order    point error = a J point + error.

A robot's own motion and what it sees of tags do not depend on where the map lies and how it is turned, and
in these coordinates neither do the Jacobians: the filter gains no knowledge of the map's frame from where
it happened to linearise, which is what makes EKF-SLAM overconfident. ``turned`` is the sum of the heading's
noise since the far tags were put aside (see ``ekf_state``).

``cov`` (n, n) or larger is symmetric to the bit. ``kept`` (n, m), ``told`` (m, m) and ``moved`` (m,)
gather what corrections mean for the far tags: cross-covariance kept @ cross, covariance less
cross.T @ told @ cross, and a shift of cross.T @ moved, with ``cross`` (m, far) as it was; m = 0 without any.
"""

from __future__ import annotations

from math import atan2, cos, hypot, log, pi, sin, sqrt

import numpy as np
from numba import njit

from robots.se2 import Array

HEAD = 4  # heading, x, y, turned
_SMALL = 1e-6


@njit(cache=True)
def move(mean: Array, cov: Array, n: int, step: Array, noise: Array, has_far: bool) -> None:
    """Move by ``step`` (dx, dy, turn) with covariance ``noise`` (3, 3), both in the frame of the old base.

    Ziparo 2007 eq. (4) with exact composition. The transition of the error is the identity; the heading's
    noise reaches every tag, since errors turn with the heading.
    """
    c, s = cos(mean[0]), sin(mean[0])
    mean[1] += c * step[0] - s * step[1]
    mean[2] += s * step[0] + c * step[1]
    mean[0] = _wrapped(mean[0] + step[2])
    a = sqrt(max(noise[2, 2], 0.0))
    along, across = (noise[0, 2] / a, noise[1, 2] / a) if a > 0.0 else (0.0, 0.0)
    column = np.empty(n)
    column[0] = a
    column[1] = a * mean[2] + c * along - s * across
    column[2] = -a * mean[1] + s * along + c * across
    column[3] = a if has_far else 0.0
    for i in range(HEAD, n, 2):
        column[i] = a * mean[i + 1]
        column[i + 1] = -a * mean[i]
    for i in range(n):
        for j in range(n):
            cov[i, j] += column[i] * column[j]
    xx, yy = noise[0, 0] - along * along, noise[1, 1] - across * across
    xy = noise[0, 1] - along * across
    cov[1, 1] += c * c * xx - 2.0 * c * s * xy + s * s * yy
    cov[2, 2] += s * s * xx + 2.0 * c * s * xy + c * c * yy
    turned = c * s * (xx - yy) + (c * c - s * s) * xy
    cov[1, 2] += turned
    cov[2, 1] += turned


@njit(cache=True)
def expected(mean: Array, tag: int, antenna: Array) -> tuple[float, float, float, float]:
    """Return range, bearing, and the unit vector to the tag at index ``tag``, Ziparo 2007 eq. (5).

    ``antenna``: its pose (x, y, turn) in the base frame. With atan2 and wrapped, as DESIGN has it.
    """
    c, s = cos(mean[0]), sin(mean[0])
    dx = mean[tag] - mean[1] - c * antenna[0] + s * antenna[1]
    dy = mean[tag + 1] - mean[2] - s * antenna[0] - c * antenna[1]
    r = max(hypot(dx, dy), 1e-3)
    return r, _wrapped(atan2(dy, dx) - mean[0] - antenna[2]), dx / r, dy / r


@njit(cache=True)
def expected_spread(mean: Array, cov: Array, tag: int, antenna: Array) -> tuple[float, float, float, float]:
    """Return range and bearing, as ``expected`` does, and their variances."""
    r, bearing, ex, ey = expected(mean, tag, antenna)
    xx = cov[1, 1] + cov[tag, tag] - 2.0 * cov[1, tag]
    yy = cov[2, 2] + cov[tag + 1, tag + 1] - 2.0 * cov[2, tag + 1]
    xy = cov[1, 2] + cov[tag, tag + 1] - cov[1, tag + 1] - cov[2, tag]
    along = ex * ex * xx + 2.0 * ex * ey * xy + ey * ey * yy
    across = ey * ey * xx - 2.0 * ex * ey * xy + ex * ex * yy
    return r, bearing, along, across / (r * r)


@njit(cache=True)
def see(
    mean: Array,
    cov: Array,
    n: int,
    tag: int,
    antenna: Array,
    seen: Array,
    thin: float,
    gate: float,
    kept: Array,
    told: Array,
    moved: Array,
) -> tuple[float, float]:
    """Correct by a sighting of the tag at index ``tag``.

    ``seen``: range, its variance, bearing, its variance (infinite where there is none), and the deviation of
    the range's logarithm where that is what is normal, else 0: then the innovation is r ln(range / r). The
    Jacobian by the errors is e for the range and J e / r for the bearing, with opposite signs for pose and
    tag: the heading does not enter. The variances count ``thin`` times, as errors are those of the sightings
    before. Where the innovation is beyond ``gate`` (squared, in deviations, as of one sighting alone) its
    covariance is inflated by the excess: a wild sighting pulls little, and none is locked out.

    Returns that squared innovation, and the turn of the map.
    """
    r, bearing, ex, ey = expected(mean, tag, antenna)
    rows = 2 if seen[3] < np.inf else 1
    h = np.empty((2, 2))
    h[0, 0], h[0, 1] = ex, ey
    h[1, 0], h[1, 1] = -ey / r, ex / r
    white, told_h = np.empty((2, n)), np.empty((2, kept.shape[1]))
    for k in range(2):
        hx, hy = h[k, 0], h[k, 1]
        for j in range(n):
            white[k, j] = hx * (cov[tag, j] - cov[1, j]) + hy * (cov[tag + 1, j] - cov[2, j])
        for j in range(kept.shape[1]):
            told_h[k, j] = hx * (kept[tag, j] - kept[1, j]) + hy * (kept[tag + 1, j] - kept[2, j])
    spread = np.zeros((2, 2))  # of the expected sighting
    for k in range(2):
        for i in range(k + 1):
            spread[k, i] = h[i, 0] * (white[k, tag] - white[k, 1]) + h[i, 1] * (
                white[k, tag + 1] - white[k, 2]
            )
    off = np.array([seen[0] - r, _wrapped(seen[2] - bearing)])[:rows]
    variance = seen[1]
    # second order (Bar-Shalom 2001 section 10.3): a tag as near as it is uncertain tells little
    along, across = spread[0, 0], r * r * spread[1, 1]
    bent = across * across / (2.0 * r * r)
    if seen[4] > 0.0:
        off[0], variance = r * log(seen[0] / r), (r * seen[4]) ** 2
        bent += along * along / (2.0 * r * r)
    swung = along * across / r**4
    alone = off.copy()
    _whiten_innovation(alone, _root(spread, variance + bent, seen[3] + swung, rows))
    distance: float = (alone * alone).sum()
    root = _root(spread, thin * variance + bent, thin * seen[3] + swung, rows)
    if distance > gate:
        root = root * sqrt(distance / gate)
    _whiten_innovation(off, root)
    white, told_h = white[:rows], told_h[:rows]
    _whiten(white, root)
    _whiten(told_h, root)
    turn: float = correct(mean, cov, n, white, told_h, off, kept, told, moved)
    return distance, turn


@njit(cache=True)
def see_heading(
    mean: Array, cov: Array, n: int, off: float, variance: float, kept: Array, told: Array, moved: Array
) -> float:
    """Correct by a compass that is ``off`` from the heading; returns the turn of the map that it brought."""
    deviation = sqrt(cov[0, 0] + variance)
    white = cov[:1, :n] / deviation
    innovation = np.array([off / deviation])
    turn: float = correct(mean, cov, n, white, kept[:1] / deviation, innovation, kept, told, moved)
    return turn


@njit(cache=True)
def correct(
    mean: Array,
    cov: Array,
    n: int,
    white: Array,
    told_h: Array,
    off: Array,
    kept: Array,
    told: Array,
    moved: Array,
) -> float:
    """Correct by whitened innovations ``off`` (k,) with gains ``white`` (k, n).

    ``told_h`` (k, m) are the whitened Jacobians by the state as it was when the far tags were put aside.
    Returns the turn of the map.
    """
    rows, m = white.shape[0], kept.shape[1]
    shift = np.zeros(n)
    for k in range(rows):
        for i in range(n):
            w = white[k, i]
            shift[i] += w * off[k]
            for j in range(n):
                cov[i, j] -= w * white[k, j]
    if m:
        for k in range(rows):
            for j in range(m):
                moved[j] += told_h[k, j] * off[k]
                for i in range(m):
                    told[j, i] += told_h[k, j] * told_h[k, i]
            for i in range(n):
                for j in range(m):
                    kept[i, j] -= white[k, i] * told_h[k, j]
    retract(mean, n, shift)
    turn: float = shift[0]
    return turn


@njit(cache=True)
def retract(mean: Array, n: int, shift: Array) -> None:
    """Move the state by an error: exp(a) point + V(a) error.

    V matters: a heading that alone was wrong must leave the tags where they are, to the last digit.
    """
    a = shift[0]
    c, s = cos(a), sin(a)
    if abs(a) < _SMALL:
        v, w = 1.0, a / 2.0
    else:
        v, w = s / a, (1.0 - c) / a
    mean[0] = _wrapped(mean[0] + a)
    mean[3] += shift[3]
    for k in range(HEAD - 2, n, 2):
        i = k if k >= HEAD else 1  # the pose, then the tags
        x, y, dx, dy = mean[i], mean[i + 1], shift[i], shift[i + 1]
        mean[i] = c * x - s * y + v * dx - w * dy
        mean[i + 1] = s * x + c * y + w * dx + v * dy


@njit(cache=True)
def _root(spread: Array, by_range: float, by_bearing: float, rows: int) -> Array:
    """Return the Cholesky factor of the innovation's covariance: (0, 0), (1, 0), (1, 1)."""
    first = sqrt(spread[0, 0] + by_range)
    if rows == 1:
        return np.array([first, 0.0, 1.0])
    between = spread[1, 0] / first
    return np.array([first, between, sqrt(spread[1, 1] + by_bearing - between * between)])


@njit(cache=True)
def _whiten(rows: Array, root: Array) -> None:
    for j in range(rows.shape[1]):
        rows[0, j] /= root[0]
        if rows.shape[0] == 2:
            rows[1, j] = (rows[1, j] - root[1] * rows[0, j]) / root[2]


@njit(cache=True)
def _whiten_innovation(off: Array, root: Array) -> None:
    off[0] /= root[0]
    if len(off) == 2:
        off[1] = (off[1] - root[1] * off[0]) / root[2]


@njit(cache=True)
def _wrapped(angle: float) -> float:
    wrapped = (angle + pi) % (2.0 * pi) - pi
    return pi if wrapped == -pi else wrapped
