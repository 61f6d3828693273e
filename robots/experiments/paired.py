"""Statistics of methods run on the same draws: paired effects, equivalence, analysis of variance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import stats

from robots.se2 import Array


@dataclass(frozen=True, slots=True)
class Effect:
    """A mean difference, its 95 % interval and the p-value of there being none; NaN from one run."""

    mean: float
    low: float
    high: float
    p: float


def effect(first: Array, second: Array) -> Effect:
    """Return how much more the second gives, values (n,) of the same runs, by Student's paired t."""
    differences = second - first
    mean, n = float(differences.mean()), len(differences)
    if n < 2:
        return Effect(mean, np.nan, np.nan, np.nan)
    error = float(differences.std(ddof=1)) / np.sqrt(n)
    if error == 0.0:
        return Effect(mean, mean, mean, 1.0 if mean == 0.0 else 0.0)
    half = float(stats.t.ppf(0.975, n - 1)) * error
    return Effect(mean, mean - half, mean + half, float(2.0 * stats.t.sf(abs(mean / error), n - 1)))


def equivalence(first: Array, second: Array, margin: float) -> float:
    """Return the p-value of two one-sided tests (Schuirmann 1987): small where they are as good as equal.

    Values (n,) of the same runs; ``margin`` is the difference that matters. NaN from one run.
    """
    differences = second - first
    n = len(differences)
    if n < 2:
        return float("nan")
    error = float(differences.std(ddof=1)) / np.sqrt(n)
    mean = float(differences.mean())
    if error == 0.0:
        return 0.0 if abs(mean) < margin else 1.0
    return float(stats.t.sf((margin - abs(mean)) / error, n - 1))


def two_way(values: Array) -> tuple[float, float, float]:
    """Return the p-values of the first factor, the second, and both together, of values (a, b, n).

    Analysis of variance of a balanced design whose n runs are blocks. NaN from fewer than two runs.
    """
    a, b, n = values.shape
    if n < 2:
        return float("nan"), float("nan"), float("nan")
    grand = values.mean()
    rows, columns, cells = values.mean(axis=(1, 2)), values.mean(axis=(0, 2)), values.mean(axis=2)
    blocks = values.mean(axis=(0, 1))
    first = b * n * ((rows - grand) ** 2).sum()
    second = a * n * ((columns - grand) ** 2).sum()
    both = n * ((cells - rows[:, None] - columns[None] + grand) ** 2).sum()
    block = a * b * ((blocks - grand) ** 2).sum()
    residual = ((values - grand) ** 2).sum() - first - second - both - block
    degrees = (a * b - 1) * (n - 1)
    spread = max(float(residual), 1e-12) / degrees

    def p(squares: float, free: int) -> float:
        return float(stats.f.sf(squares / free / spread, free, degrees)) if free else float("nan")

    return p(first, a - 1), p(second, b - 1), p(both, (a - 1) * (b - 1))
