"""Where a node may be, by votes of its ranges on a grid (Sun 2009 section 5.1, after Olson 2004)."""

from __future__ import annotations

from dataclasses import dataclass
from math import exp, hypot, log, sqrt

import numpy as np
from numba import njit

from robots.se2 import Array

_CELLS = 64  # a side
_NEAR = 0.25  # of the distance: within it, the range is straight enough for a Kalman filter
_SHARE = 0.95  # of the votes that one or two places have to gather
_LEAST = 0.02  # a place with less is none
_BEYOND_SD = 3.0


@dataclass(frozen=True, slots=True)
class Candidate:
    """A place in metres, in the frame of the poses, and its share of the votes."""

    x_m: float
    y_m: float
    share: float


def vote(
    antennas: Array, ranges_m: Array, noises: Array, scale: tuple[float, float], offset_sd_m: float
) -> tuple[Candidate, ...]:
    """Return the one or two places that the ranges agree on; none while they leave it open.

    Args:
        antennas: (k, 2) from where each range was measured.
        ranges_m: (k,) as measured.
        noises: (k, 2) their deviations in metres, or of their logarithm.
        scale: mean and deviation of the scale that ranges have.
        offset_sd_m: deviation of the offset that ranges have.
    """
    mean, sd = scale
    sds_m = noises[:, 0] + noises[:, 1] * ranges_m
    reach = (ranges_m + _BEYOND_SD * (sds_m + offset_sd_m)) / max(mean - _BEYOND_SD * sd, 0.2)
    low = (antennas - reach[:, None]).max(axis=0)
    high = (antennas + reach[:, None]).min(axis=0)
    if (high <= low).any():
        return ()
    size = (high - low) / _CELLS
    votes, misfit = _votes(antennas, ranges_m, noises, low, size, mean, sd, offset_sd_m)
    if misfit > len(ranges_m) + 4.0 * sqrt(2.0 * len(ranges_m)):  # chi-square: they agree nowhere
        return ()
    found: list[Candidate] = []
    for _ in range(2):
        row, column = np.unravel_index(np.argmax(votes), votes.shape)
        x, y = low[0] + (column + 0.5) * size[0], low[1] + (row + 0.5) * size[1]
        distance = float(np.median(np.hypot(antennas[:, 0] - x, antennas[:, 1] - y)))
        share, x, y = _gather(votes, low, size, x, y, max(_NEAR * distance, 2.0 * float(size.max())))
        if share < _LEAST:
            break
        found.append(Candidate(x, y, share))
    total = sum(each.share for each in found)
    return tuple(found) if total >= _SHARE else ()


@njit(cache=True)
def _votes(
    antennas: Array,
    ranges: Array,
    noises: Array,
    low: Array,
    size: Array,
    scale: float,
    scale_sd: float,
    offset_sd: float,
) -> tuple[Array, float]:
    """Return the probability of each cell, whatever offset and scale are (Woodbury), and the least chi2."""
    votes = np.empty((_CELLS, _CELLS))
    top, misfit = -np.inf, np.inf
    blur = (size[0] * size[0] + size[1] * size[1]) / 12.0
    for i in range(_CELLS):
        for j in range(_CELLS):
            x, y = low[0] + (j + 0.5) * size[0], low[1] + (i + 0.5) * size[1]
            a = 1.0 / (offset_sd * offset_sd)
            c = 1.0 / (scale_sd * scale_sd)
            b = e = f = cost = det_noise = 0.0
            for k in range(len(ranges)):
                d = hypot(x - antennas[k, 0], y - antennas[k, 1])
                variance = noises[k, 0] ** 2 + blur
                v = ranges[k] - scale * d
                if noises[k, 1] > 0.0:
                    expected = max(scale * d, size[0])
                    v = expected * log(max(ranges[k], size[0]) / expected)
                    variance += (noises[k, 1] * expected) ** 2
                    det_noise += log(variance) - 2.0 * log(expected)
                w = 1.0 / variance
                cost += w * v * v
                a += w
                b += w * d
                c += w * d * d
                e += w * v
                f += w * v * d
            det = a * c - b * b
            cost -= (c * e * e - 2.0 * b * e * f + a * f * f) / det
            misfit = min(misfit, cost)
            votes[i, j] = -0.5 * (cost + log(det) + det_noise)
            top = max(top, votes[i, j])
    total = 0.0
    for i in range(_CELLS):
        for j in range(_CELLS):
            votes[i, j] = exp(votes[i, j] - top)
            total += votes[i, j]
    return votes / total, misfit


@njit(cache=True)
def _gather(
    votes: Array, low: Array, size: Array, x: float, y: float, reach: float
) -> tuple[float, float, float]:
    """Take the votes about a place out of the grid; return how many they were, and their mean."""
    share = mx = my = 0.0
    for i in range(_CELLS):
        for j in range(_CELLS):
            cx, cy = low[0] + (j + 0.5) * size[0], low[1] + (i + 0.5) * size[1]
            if hypot(cx - x, cy - y) <= reach:
                share += votes[i, j]
                mx += votes[i, j] * cx
                my += votes[i, j] * cy
                votes[i, j] = 0.0
    if share <= 0.0:
        return 0.0, x, y
    return share, mx / share, my / share
