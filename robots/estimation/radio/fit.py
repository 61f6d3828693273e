"""Fitting the radio model to readings whose distances are known.

P(d) = p(d0) - 10 n log10(d / d0) + X is linear in p(d0) and n. Outliers are found by a robust fit (Huber
1964) and left out of a least-squares one (Rousseeuw and Leroy 1987, reweighted least squares). What is left
over is split by analysis of variance: readings on one spot share their shadowing and differ by their fading.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import floor, sqrt

import numpy as np

from robots.graph_report import IntArray
from robots.se2 import Array

_HUBER = 1.345  # 95 % efficient where the errors are normal
_OUTLIER_SD = 4.0
_ROUNDS = 50
_FEWEST = 20
_LEAST_SPREAD = 1.5  # of the farthest to the nearest distance
PLACE_M, SPOT_M = 0.5, 0.1


class FitError(ValueError):
    """The readings do not tell the model's numbers; the message says why."""


@dataclass(frozen=True, slots=True)
class Signals:
    """Readings with their distances: ``distances_m`` and ``rssis_dbm`` (k,).

    ``places`` (k,): readings of the same number were made of one tag from one place, half a metre wide, whose
    shadowing they share for the most part; ``spots`` (k,): from a tenth of a metre, so that they do wholly.
    """

    distances_m: Array
    rssis_dbm: Array
    places: IntArray
    spots: IntArray


@dataclass(frozen=True, slots=True)
class RadioFit:
    """The model's numbers with deviations, which allow for readings of one place erring together.

    ``sigma_db`` is the deviation of a reading from the model, shadowing and fading together; with the
    outliers it is ``sigma_all_db``.
    """

    power_at_1m_dbm: float
    power_sd_db: float
    path_loss_exponent: float
    exponent_sd: float
    sigma_db: float
    sigma_all_db: float
    shadowing_sd_db: float
    fading_sd_db: float
    readings: int
    outliers: int
    places: int
    nearest_m: float
    farthest_m: float

    @property
    def settings(self) -> dict[str, float]:
        """The numbers as settings of ``RadioConfig``."""
        return {
            "power_at_1m_dbm": round(self.power_at_1m_dbm, 3),
            "path_loss_exponent": round(self.path_loss_exponent, 4),
            "shadowing_sd_db": round(self.shadowing_sd_db, 3),
            "fading_sd_db": round(self.fading_sd_db, 3),
        }


def fit_radio(signals: Signals) -> RadioFit:
    """Return the model that explains the readings best.

    Raises:
        FitError: there are too few readings, their distances hardly differ, a value is not finite, or the
            signal does not fall with distance.
    """
    distances, rssis = signals.distances_m, signals.rssis_dbm
    if not (np.isfinite(distances).all() and np.isfinite(rssis).all()):
        raise FitError("a distance or a signal is not finite")
    if len(rssis) < _FEWEST:
        raise FitError(f"there are {len(rssis)} readings with a known distance; {_FEWEST} are needed")
    distances = np.maximum(distances, 0.05)
    if distances.max() < _LEAST_SPREAD * distances.min():
        raise FitError("all readings were made at nearly the same distance; more distances are needed")
    design = np.column_stack([np.ones_like(distances), -10.0 * np.log10(distances)])
    kept = _within(design, rssis)
    power, exponent = np.linalg.lstsq(design[kept], rssis[kept], rcond=None)[0]
    if exponent <= 0.0:
        raise FitError("the signal does not fall with distance; is each reading beside its own distance?")
    residuals = rssis - design @ np.array([power, exponent])
    sigma_all = float(np.sqrt(np.mean(residuals**2)))
    design, residuals, places = design[kept], residuals[kept], signals.places[kept]
    shadowing, fading = _components(residuals, signals.spots[kept])
    spread = _covariance(design, residuals, places)
    return RadioFit(
        power_at_1m_dbm=float(power),
        power_sd_db=sqrt(spread[0, 0]),
        path_loss_exponent=float(exponent),
        exponent_sd=sqrt(spread[1, 1]),
        sigma_db=float(np.sqrt(np.mean(residuals**2))),
        sigma_all_db=sigma_all,
        shadowing_sd_db=shadowing,
        fading_sd_db=fading,
        readings=len(kept),
        outliers=int((~kept).sum()),
        places=len(np.unique(places)),
        nearest_m=float(distances.min()),
        farthest_m=float(distances.max()),
    )


class Collector:
    """Gathers readings, each with the tag it was of and the place it was made from, in metres."""

    def __init__(self) -> None:
        self._rows: list[tuple[float, float, int, int]] = []
        self._numbers: dict[tuple[object, ...], int] = {}

    def add(self, tag: str, x_m: float, y_m: float, distance_m: float, rssi_dbm: float) -> None:
        """Take a reading."""
        place, spot = (
            self._numbers.setdefault((tag, size, floor(x_m / size), floor(y_m / size)), len(self._numbers))
            for size in (PLACE_M, SPOT_M)
        )
        self._rows.append((distance_m, rssi_dbm, place, spot))

    def signals(self) -> Signals:
        """Return all readings."""
        table = np.array(self._rows, np.float64).reshape(-1, 4)
        return Signals(table[:, 0], table[:, 1], table[:, 2].astype(np.int64), table[:, 3].astype(np.int64))


def _within(design: Array, rssis: Array) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Return which readings are no outliers, (k,), after Huber's fit by reweighting."""
    weights = np.ones_like(rssis)
    residuals, scale = rssis, 1.0
    for _ in range(_ROUNDS):
        root = np.sqrt(weights)
        fitted = np.linalg.lstsq(design * root[:, None], rssis * root, rcond=None)[0]
        residuals = rssis - design @ fitted
        scale = max(1.4826 * float(np.median(np.abs(residuals))), 1e-6)
        weights = np.minimum(1.0, _HUBER * scale / np.maximum(np.abs(residuals), 1e-12))
    within: np.ndarray[tuple[int], np.dtype[np.bool_]] = np.abs(residuals) <= _OUTLIER_SD * scale
    return within


def _components(residuals: Array, spots: IntArray) -> tuple[float, float]:
    """Return the deviations between spots and on one (one-way analysis of variance)."""
    _, index, counts = np.unique(spots, return_inverse=True, return_counts=True)
    k, n = len(counts), len(residuals)
    if k == n:  # one reading a spot: what is of the spot and what of the reading cannot be told apart
        return float(np.sqrt(np.mean(residuals**2))), 0.0
    means = np.bincount(index, residuals) / counts
    within = float(np.sum((residuals - means[index]) ** 2)) / (n - k)
    if k == 1:
        return 0.0, sqrt(within)
    between = float(np.sum(counts * means**2)) / (k - 1)
    size = (n - float(np.sum(counts**2)) / n) / (k - 1)
    return sqrt(max(0.0, (between - within) / size)), sqrt(within)


def _covariance(design: Array, residuals: Array, places: IntArray) -> Array:
    """Return the covariance (2, 2) of the fit; residuals of one place go together (Liang and Zeger 1986)."""
    _, index = np.unique(places, return_inverse=True)
    scores = np.column_stack([np.bincount(index, residuals * column) for column in design.T])
    bread = np.linalg.inv(design.T @ design)
    covariance: Array = bread @ (scores.T @ scores) @ bread
    return covariance
