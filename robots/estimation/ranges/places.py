"""Where else a node heard by range alone may lie: two places mirrored by a straight way fit alike."""

from __future__ import annotations

from math import sqrt

import numpy as np
from numba import njit

from robots.estimation.ranges.factors import Ranges, weigh
from robots.graph_report import IntArray
from robots.se2 import Array

_PAIRS = 24  # of circles that are cut with one another
_STEPS = 10
_APART_M = 0.5  # places nearer than this are one
_WORSE = 60.0  # a place that costs more, all else as it is, will not be the better one


def other_places(state: Array, ranges: Ranges, tag: int) -> list[Array]:
    """Return places (2,) of a tag far from its own that its ranges allow, best first."""
    rows = np.flatnonzero(ranges.seen == tag)
    here = state[tag, :2].copy()
    own = _cost(state, ranges, rows, here)
    found: list[tuple[float, Array]] = []
    for begin in _crossings(state, ranges, rows):
        place = _fitted(state, ranges, rows, begin)
        cost = _cost(state, ranges, rows, place)
        known = [here] + [other for _, other in found]
        if cost < own + _WORSE and min(float(np.hypot(*(place - k))) for k in known) > _APART_M:
            found.append((cost, place))
    return [place for _, place in sorted(found, key=lambda item: item[0])]


@njit(cache=True)
def _antenna(state: Array, ranges: Ranges, k: int) -> tuple[float, float, float]:
    """Return where row k was heard, and how far off by its calibrated range."""
    i = ranges.poses[k]
    c, s = np.cos(state[i, 2]), np.sin(state[i, 2])
    x = state[i, 0] + c * ranges.arms[k, 0] - s * ranges.arms[k, 1]
    y = state[i, 1] + s * ranges.arms[k, 0] + c * ranges.arms[k, 1]
    d = (ranges.ranges[k] - state[ranges.seen[k], 2]) / state[ranges.radios[k], 0]
    return x, y, max(d, 0.0)


@njit(cache=True)
def _crossings(state: Array, ranges: Ranges, rows: IntArray) -> Array:
    """Return where pairs of circles, taken evenly over the rows, cross or come nearest, (2 p, 2)."""
    places = np.empty((2 * _PAIRS, 2))
    count, n = 0, len(rows)
    for p in range(_PAIRS):
        k, m = rows[(p * n) // _PAIRS], rows[((p * n) // _PAIRS + n // 3) % n]
        ax, ay, r = _antenna(state, ranges, k)
        bx, by, q = _antenna(state, ranges, m)
        d = sqrt((bx - ax) ** 2 + (by - ay) ** 2)
        if d < 1e-3:
            continue
        along = (d * d + r * r - q * q) / (2.0 * d)
        across = sqrt(max(r * r - along * along, 0.0))
        ux, uy = (bx - ax) / d, (by - ay) / d
        for side in (-1.0, 1.0):
            places[count, 0] = ax + along * ux - side * across * uy
            places[count, 1] = ay + along * uy + side * across * ux
            count += 1
    return places[:count]


@njit(cache=True)
def _cost(state: Array, ranges: Ranges, rows: IntArray, place: Array) -> float:
    """Return what a tag's rows cost if it lies at a place and all else is as it is."""
    total = 0.0
    for k in rows:
        x, y, d = _antenna(state, ranges, k)
        away = sqrt((place[0] - x) ** 2 + (place[1] - y) ** 2)
        sd = ranges.sds[k] / state[ranges.radios[k], 0]
        total += ranges.shares[k, 0] * weigh(((away - d) / sd) ** 2, 0.0)[1]
    return total


@njit(cache=True)
def _fitted(state: Array, ranges: Ranges, rows: IntArray, begin: Array) -> Array:
    """Return the place a few damped Gauss-Newton steps lead to, all else as it is."""
    place = begin.copy()
    for _ in range(_STEPS):
        h00, h01, h11, g0, g1 = 1e-6, 0.0, 1e-6, 0.0, 0.0
        for k in rows:
            x, y, d = _antenna(state, ranges, k)
            dx, dy = place[0] - x, place[1] - y
            away = max(sqrt(dx * dx + dy * dy), 1e-6)
            sd = ranges.sds[k] / state[ranges.radios[k], 0]
            weight = ranges.shares[k, 0] * weigh(((away - d) / sd) ** 2, 3.0)[0] / sd**2
            ux, uy, error = dx / away, dy / away, away - d
            h00 += weight * ux * ux
            h01 += weight * ux * uy
            h11 += weight * uy * uy
            g0 += weight * ux * error
            g1 += weight * uy * error
        determinant = h00 * h11 - h01 * h01
        if determinant < 1e-9 * h00 * h11:
            break
        place[0] -= (h11 * g0 - h01 * g1) / determinant
        place[1] -= (h00 * g1 - h01 * g0) / determinant
    return place
