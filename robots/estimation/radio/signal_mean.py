"""The mean of ten readings of one node, without their outliers (RANSAC, Sun 2009 section 4).

A mean starts from a sample, gathers what fits it, and is kept when it gathers most. Ten readings have 45
pairs, so all pairs are tried instead of random ones: the same readings give the same mean in any order.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import isfinite, sqrt

import numpy as np

from robots.config import RadioConfig
from robots.se2 import Array, Pose2

_FITS_SD = 2.5
_FEWEST = 3  # readings that make a mean where a robot drives past with no time for more


@dataclass(frozen=True, slots=True)
class SignalMean:
    """A mean of ``readings`` that agree; ``rejected`` were outliers.

    ``local_from_base``: where the robot was in the middle of them, in the tracker's frame.
    """

    rssi_dbm: float
    readings: int
    rejected: int
    local_from_base: Pose2 = field(default_factory=Pose2)


def robust_mean(rssis_dbm: Array, fading_sd_db: float) -> SignalMean | None:
    """Return the mean of the readings (n,) that agree; None where no two and no half of them do.

    Raises:
        ValueError: a reading is not finite.
    """
    count = len(rssis_dbm)
    if not np.isfinite(rssis_dbm).all():
        raise ValueError("a signal has to be a finite number of dBm")
    if count < 2:
        return None
    values = np.sort(np.asarray(rssis_dbm, dtype=np.float64))
    first, second = np.triu_indices(count, 1)
    starts = (values[first] + values[second]) / 2.0
    # a reading is off a mean of two of its kind by sqrt(1 + 1/2) of the fading
    close = max(_FITS_SD * sqrt(1.5) * fading_sd_db, 1e-6)
    fits = np.abs(values[None, :] - starts[:, None]) <= close  # (pairs, n)
    gathered = fits.sum(axis=1)
    off = np.where(fits, np.abs(values[None, :] - starts[:, None]), 0.0).sum(axis=1)
    best = int(np.lexsort((off, -gathered))[0])
    agree = int(gathered[best])
    if agree < 2 or 2 * agree < count:
        return None
    return SignalMean(float(values[fits[best]].mean()), agree, count - agree)


class _Window:
    """Readings of one tag at one antenna that wait to be averaged."""

    __slots__ = ("last_m", "places_m", "poses", "rssis_dbm")

    def __init__(self) -> None:
        self.rssis_dbm: list[float] = []
        self.places_m: list[float] = []
        self.poses: list[Pose2] = []
        self.last_m: float | None = None  # where the last mean was given


class SignalAverager:
    """Gathers readings of every tag and gives a mean when there is a new one to give.

    Shadowing belongs to the place: a mean taken at the same place again would repeat the same error and claim
    to know better. So a tag's next mean comes after ``place_m`` of driving, from the readings made there.
    """

    def __init__(self, config: RadioConfig) -> None:
        self._config = config
        self._windows: dict[tuple[str, str | None], _Window] = {}

    def add(
        self,
        tag_id: str,
        antenna: str | None,
        rssi_dbm: float,
        driven_m: float,
        local_from_base: Pose2 | None = None,
    ) -> SignalMean | None:
        """Take one reading, made after ``driven_m`` of way; return a mean when it completes one.

        Raises:
            ValueError: the reading is not finite.
        """
        if not isfinite(rssi_dbm):
            raise ValueError("a signal has to be a finite number of dBm")
        config = self._config
        window = self._windows.setdefault((tag_id, antenna), _Window())
        window.rssis_dbm.append(rssi_dbm)
        window.places_m.append(driven_m)
        window.poses.append(local_from_base or Pose2())
        passed = driven_m - window.places_m[0] >= config.place_m
        if len(window.rssis_dbm) < config.readings and not (passed and len(window.rssis_dbm) >= _FEWEST):
            if passed:
                self._forget(window, driven_m)
            return None
        if window.last_m is not None and driven_m - window.last_m < config.place_m:
            self._keep(window, config.readings - 1)
            return None
        mean = robust_mean(np.array(window.rssis_dbm), config.fading_sd_db)
        if mean is None:
            self._keep(window, config.readings - 1)
            return None
        window.last_m = driven_m
        middle = _middle(window.poses)
        self._keep(window, 0)
        return replace(mean, local_from_base=middle)

    def _forget(self, window: _Window, driven_m: float) -> None:
        """Drop readings of places passed, of which there are too few."""
        recent = sum(driven_m - place < self._config.place_m for place in window.places_m)
        self._keep(window, recent)

    @staticmethod
    def _keep(window: _Window, count: int) -> None:
        """Keep the newest readings."""
        first = max(0, len(window.rssis_dbm) - count)
        del window.rssis_dbm[:first], window.places_m[:first], window.poses[:first]


def _middle(poses: list[Pose2]) -> Pose2:
    x, y = np.array([(pose.x, pose.y) for pose in poses]).mean(axis=0).tolist()
    return Pose2(x, y, poses[len(poses) // 2].theta)
