"""At how many places the sightings of one tag put it."""

from __future__ import annotations

from dataclasses import dataclass
from math import log

import numpy as np

from robots.graph_report import IntArray
from robots.se2 import Array

_APART = 1e-3  # a sighting that lies at a known place lies this far off by chance so often


@dataclass(frozen=True, slots=True, eq=False)
class TagSightings:
    """Where each sighting by itself puts the tag, in the order of time.

    ``rows`` (k,) indices of the sightings, ``places_m`` (k, 2), ``covariance`` (2 k, 2 k) of all of them
    together.
    """

    rows: IntArray
    places_m: Array
    covariance: Array


def places_of(sightings: TagSightings, scale: float, least_m: float) -> IntArray:
    """Return which place each sighting is of, (k,), places numbered in the order they appear.

    Those that agree best become one place first, as long as any agree: within chance, all variances being
    ``scale`` times what they claim, or within ``least_m``.
    """
    groups = {k: [k] for k in range(len(sightings.rows))}
    limit = -2.0 * log(_APART) * scale
    gaps = {(a, b): _gap(sightings, [a], [b]) for b in groups for a in range(b)}
    while gaps:
        (a, b), (chi2, far_m) = min(gaps.items(), key=lambda item: (item[1][1] >= least_m, item[1][0]))
        if chi2 >= limit and far_m >= least_m:
            break
        groups[a] = sorted(groups[a] + groups.pop(b))
        gaps = {pair: gap for pair, gap in gaps.items() if b not in pair and a not in pair}
        gaps |= {(min(a, c), max(a, c)): _gap(sightings, groups[a], groups[c]) for c in groups if c != a}
    labels = np.zeros(len(sightings.rows), np.int64)
    for label, group in enumerate(sorted(groups.values())):
        labels[group] = label
    return labels


def contradiction(sightings: TagSightings, labels: IntArray) -> float:
    """Return the largest chi-square between two of the places."""
    groups = [np.flatnonzero(labels == label).tolist() for label in range(int(labels.max()) + 1)]
    return max((_gap(sightings, a, b)[0] for k, a in enumerate(groups) for b in groups[:k]), default=0.0)


def _gap(sightings: TagSightings, first: list[int], second: list[int]) -> tuple[float, float]:
    """Return chi-square (2 degrees of freedom) and distance of the best places of two groups."""
    weights = np.zeros((2, 2 * len(sightings.rows)))
    for sign, group in ((1.0, first), (-1.0, second)):
        at = np.ravel([(2 * k, 2 * k + 1) for k in group])
        design = np.tile(np.eye(2), (len(group), 1))
        covariance = sightings.covariance[np.ix_(at, at)] + 1e-9 * np.eye(len(at))
        inverse = np.linalg.solve(covariance, design)
        weights[:, at] = sign * np.linalg.solve(design.T @ inverse, inverse.T)
    gap = weights @ sightings.places_m.ravel()
    spread = weights @ sightings.covariance @ weights.T + 1e-9 * np.eye(2)
    return float(gap @ np.linalg.solve(spread, gap)), float(np.hypot(*gap))
