"""How what a node measures goes: up or down, by how much a minute."""

from __future__ import annotations

from collections import deque

import numpy as np

TREND_S = 300.0  # how far back a trend looks
_EVERY_S = 2.0  # readings nearer than that say the same
_LEAST_S = 30.0  # before that a trend is noise

_Reading = tuple[float, float | None, float | None]  # Unix time, degrees Celsius, hectopascal


class Trends:
    """The readings of one node in the last five minutes, and the straight line through them."""

    def __init__(self) -> None:
        self._readings: deque[_Reading] = deque()

    def add(self, unix_s: float, temperature_c: float | None, pressure_hpa: float | None) -> None:
        """Take a reading."""
        if self._readings and unix_s - self._readings[-1][0] < _EVERY_S:
            return
        self._readings.append((unix_s, temperature_c, pressure_hpa))
        while self._readings[-1][0] - self._readings[0][0] > TREND_S:
            self._readings.popleft()

    def value(self) -> dict[str, float | None]:
        """Return the slopes, None where fewer than three readings or too short a time tell of one."""
        return {
            "temperature_c_per_min": self._slope([(t, c) for t, c, _ in self._readings if c is not None]),
            "pressure_hpa_per_min": self._slope([(t, p) for t, _, p in self._readings if p is not None]),
        }

    @staticmethod
    def _slope(points: list[tuple[float, float]]) -> float | None:
        """Least squares: sum (t - mean t) (v - mean v) / sum (t - mean t)^2, by the minute."""
        if len(points) < 3 or points[-1][0] - points[0][0] < _LEAST_S:
            return None
        t, v = np.array(points).T
        t = t - t.mean()
        return round(float(60.0 * (t @ (v - v.mean())) / (t @ t)), 3)
