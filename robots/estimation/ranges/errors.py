"""How long errors of range stay the same, and as how much of a measurement each sighting then counts.

The errors of one tag seen by one instrument are taken for a first-order autoregressive process, with the
correlation exp(-dt / tau) of two sightings dt apart. Weighing each sighting by the inverse of the sum of its
correlations with all others of its series keeps the estimate unbiased and its covariance honest.
"""

from __future__ import annotations

from math import exp, log

import numpy as np
from numba import njit

from robots.graph_report import IntArray
from robots.se2 import Array

_LASTING_S = np.array([0.0, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 20.0, 30.0])  # that are tried
_CLIPPED_SD = 3.0  # an outlier tells nothing of how long others last
_ENOUGH = 50  # so many pairs at least tell it


@njit(cache=True)
def error_lasts_s(errors: Array, stamps_s: Array, series: IntArray) -> float:
    """Return tau of the errors (q,), in deviations, NaN where there is none: the likeliest of those tried."""
    rows = _in_series(stamps_s, series)
    kept = np.array([k for k in rows if not np.isnan(errors[k])])
    if len(kept) < _ENOUGH:
        return 0.0
    clipped = np.minimum(np.maximum(errors, -_CLIPPED_SD), _CLIPPED_SD)
    variance = 0.0
    for k in kept:
        variance += clipped[k] ** 2 / len(kept)
    best, lasts = np.inf, 0.0
    if variance == 0.0:
        return 0.0
    for tau in _LASTING_S:
        cost, pairs = 0.0, 0
        for n in range(1, len(kept)):
            a, b = kept[n - 1], kept[n]
            if series[a] != series[b]:
                continue
            rho = min(exp(-(stamps_s[b] - stamps_s[a]) / tau), 0.999) if tau > 0.0 else 0.0
            left = variance * (1.0 - rho * rho)
            cost += (clipped[b] - rho * clipped[a]) ** 2 / left + log(left)
            pairs += 1
        if pairs < _ENOUGH:
            return 0.0
        if cost < best:
            best, lasts = cost, float(tau)
    return lasts


@njit(cache=True)
def shares(stamps_s: Array, series: IntArray, lasts_s: float) -> Array:
    """Return as how much of an independent sighting each one counts, (q,), in 0..1."""
    result = np.ones(len(stamps_s))
    if lasts_s <= 0.0:
        return result
    rows = _in_series(stamps_s, series)
    sums = np.ones(len(rows))  # of the correlations with all before and after, and itself
    for way in (1, -1):
        carried, before = 0.0, -1
        for n in range(len(rows)):
            k = rows[n] if way > 0 else rows[len(rows) - 1 - n]
            if before >= 0 and series[before] == series[k]:
                carried = (carried + 1.0) * exp(-abs(stamps_s[k] - stamps_s[before]) / lasts_s)
            else:
                carried = 0.0
            sums[k] += carried
            before = k
    for k in range(len(rows)):
        result[k] = 1.0 / sums[k]
    return result


@njit(cache=True)
def _in_series(stamps_s: Array, series: IntArray) -> IntArray:
    """Return the rows series by series, each in the order of time."""
    rows = np.argsort(stamps_s, kind="mergesort")
    return rows[np.argsort(series[rows], kind="mergesort")]
