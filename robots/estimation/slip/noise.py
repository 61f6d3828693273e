"""How noisy the encoders are, learnt on the way, so that noise is not taken for slippage.

Where a wheel's reading errs like a random walk (w metres per square root of a metre), its velocity over a
time T in which it rolls s metres errs by w * sqrt(s) / T. Second differences over time leave of a velocity
little but that; slippage and manoeuvres enlarge them too, but seldom, and a low quantile does not see them.
"""

from __future__ import annotations

from math import exp, sqrt

_QUANTILE, _QUANTILE_OF_NORMAL = 0.3, 0.3853  # of the absolute value of a standard normal variable
_RATE = 0.05
_START, _LEAST = 0.03, 1e-4  # metres per square root of a metre; begins cautious
_SECOND_DIFFERENCE = sqrt(6.0)  # deviation of a - 2 b + c
_ROLLING_M = 1e-3  # an observation in which less was rolled tells nothing


class WalkNoise:
    """The random walk of one velocity, from observations of it."""

    def __init__(self) -> None:
        self.walk = _START
        self._before: tuple[float, ...] = ()

    def observe(self, velocity_mps: float, rolled_m: float, since_s: float) -> None:
        """Take in a velocity measured while the wheels rolled so far (m) in so long (s)."""
        if rolled_m < _ROLLING_M:
            self._before = ()
            return
        if len(self._before) == 2:
            bend = abs(velocity_mps - 2.0 * self._before[1] + self._before[0])
            seen = bend / _SECOND_DIFFERENCE / _QUANTILE_OF_NORMAL * since_s / sqrt(rolled_m)
            self.walk *= exp(_RATE * (_QUANTILE - (seen < self.walk)))
            self.walk = min(max(self.walk, _LEAST), 1.0)
        self._before = (*self._before[-1:], velocity_mps)

    def forget(self) -> None:
        """Begin a new series of velocities; what was learnt stays."""
        self._before = ()

    def velocity_sd_mps(self, rolled_m: float, time_s: float) -> float:
        """Return the deviation of the velocity over a time in which the wheels rolled so far."""
        return self.walk * sqrt(rolled_m) / time_s
