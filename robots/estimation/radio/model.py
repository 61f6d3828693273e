"""How signal strength and distance belong together: one model for the simulator and the estimators.

Log-distance path loss after Seidel and Rappaport 1992, as in Ziparo 2007 eq. (1) and Sun 2009 eq. (1):
    P(d) = p(d0) - 10 n log10(d / d0) + X_sigma,    d0 = 1 m
X_sigma belongs to the place (shadowing); every reading fades on top of it. The inversion is exponential: a
normal error of the signal makes the distance log-normal, and ln d has the deviation
    s = ln(10) / (10 n) * sd_db
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import exp, isfinite, log, log10, pi, sqrt
from typing import Literal

import numpy as np
from scipy.special import log_ndtr

from robots.config import RadioConfig
from robots.se2 import Array, Pose2

TagHardware = Literal["near", "uhf", "node"]
Antenna = Literal["front", "rear"]

NEAREST_M = 0.05  # the model has no meaning closer than this

# n and sigma (dB) of buildings, Seidel and Rappaport 1992 table II; "open" is free space
ENVIRONMENTS: dict[str, tuple[float, float]] = {
    "grocery": (1.81, 5.2),
    "retail": (2.18, 8.7),
    "office1": (3.27, 11.2),
    "office2": (3.25, 5.2),
    "open": (2.0, 4.0),
}

# Sun 2009 figure 2 (a) is a plot without numbers: a table of the size and growth it shows
_SUN_DISTANCES_M = (1.0, 5.0, 10.0, 20.0, 35.0)
_SUN_SDS_DB = (1.5, 2.0, 2.5, 3.5, 4.5)

UHF = RadioConfig(power_at_1m_dbm=-31.7, reach_m=4.0)  # Ziparo 2007 sections 2 and 3
NODE = RadioConfig(  # Sun 2009 sections 3 and 4
    power_at_1m_dbm=-12.0,
    path_loss_exponent=2.0,
    table_distances_m=_SUN_DISTANCES_M,
    table_sds_db=_SUN_SDS_DB,
)


@dataclass(frozen=True, slots=True)
class RangeEstimate:
    """What one signal says of the distance.

    ``range_m`` and ``sd_m``: mean and deviation of the likelihood of the distance, see
    ``RadioModel.range_of``. ``median_m`` is the plain inversion and ``log_sd`` the deviation of its
    logarithm: for whoever works with ln d, in which the error is normal.
    """

    range_m: float
    sd_m: float
    median_m: float
    log_sd: float


@dataclass(frozen=True, slots=True)
class Direction:
    """What an antenna tells of the direction: where it sits, and the bearing from there (None: nothing)."""

    base_from_antenna: Pose2
    bearing_rad: float | None
    bearing_sd_rad: float | None


@dataclass(frozen=True, slots=True)
class RadioModel:
    """The model with the numbers of one radio in one building."""

    config: RadioConfig

    def signal_dbm(self, distance_m: float) -> float:
        """Return the mean signal at a distance, eq. (1) without X_sigma."""
        d = max(distance_m, NEAREST_M)
        return self.config.power_at_1m_dbm - 10.0 * self.config.path_loss_exponent * log10(d)

    def shadowing_sd_db(self, distance_m: float) -> float:
        """Return the deviation of X_sigma at a distance."""
        config = self.config
        if not config.table_distances_m:
            return config.shadowing_sd_db
        return float(np.interp(distance_m, config.table_distances_m, config.table_sds_db))

    def distance_m(self, rssi_dbm: float) -> float:
        """Return the distance at which a signal is the mean one: the inverse of ``signal_dbm``.

        Raises:
            ValueError: the signal is not finite.
        """
        if not isfinite(rssi_dbm):
            raise ValueError("a signal has to be a finite number of dBm")
        decades = (self.config.power_at_1m_dbm - rssi_dbm) / (10.0 * self.config.path_loss_exponent)
        return float(max(10.0 ** min(decades, 6.0), NEAREST_M))

    def log_sd(self, distance_m: float, readings: int = 1) -> float:
        """Return the deviation s of ln d that the mean of so many readings at one place leaves."""
        variance = self.shadowing_sd_db(distance_m) ** 2 + self.config.fading_sd_db**2 / max(readings, 1)
        return log(10.0) / (10.0 * self.config.path_loss_exponent) * sqrt(variance)

    def range_of(self, rssi_dbm: float, readings: int = 1) -> RangeEstimate:
        """Return the distance that the mean of so many readings tells, and how well.

        The likelihood of d after the inversion d^ is that ln d^ ~ N(ln d, s^2). Taken over all distances up
        to the radio's reach alike, its mean is d^ exp(3/2 s^2), less what the reach cuts off, and its
        deviation that times sqrt(exp(s^2) - 1). Weighted by these deviations such ranges average to the true
        distance; the inversion itself would come out exp(-3/2 s^2) too short, because a range that is too
        short claims to be sure. A signal weaker than at the reach (walls) counts as one from there: it
        contradicts the model and is no sign of precision.

        Raises:
            ValueError: the signal is not finite.
        """
        median_m = self.distance_m(rssi_dbm)
        within_m = min(median_m, self.config.reach_m)
        s = self.log_sd(within_m, readings)
        if s < 1e-6:
            return RangeEstimate(within_m, 1e-6 * within_m, median_m, s)
        mean, square = _moments_below(log(within_m) + s * s, s, log(self.config.reach_m))
        return RangeEstimate(mean, sqrt(max(square - mean * mean, (1e-6 * mean) ** 2)), median_m, s)

    def direction(self, antenna: Antenna | None) -> Direction:
        """Return what is known of the direction of a tag that this antenna heard.

        A directional one says no more than its cone, over which the tag lies uniformly.
        """
        if antenna is None:
            return Direction(Pose2(), None, None)
        front = antenna == "front"
        ahead_m = self.config.front_ahead_m if front else self.config.rear_ahead_m
        pose = Pose2(ahead_m, 0.0, 0.0 if front else pi)
        return Direction(pose, 0.0, self.config.cone_rad / sqrt(12.0))


def radio_for(hardware: TagHardware, environment: str = "open") -> RadioConfig:
    """Return the radio of a kind of tag in a building; a tag of the near field has none, and gets the node's.

    In the open a node's shadowing is Sun's table, in a building n and sigma are those of the building.

    Raises:
        ValueError: the environment is unknown.
    """
    if environment not in ENVIRONMENTS:
        raise ValueError(f"environment {environment!r} is unknown; known are {', '.join(ENVIRONMENTS)}")
    radio = UHF if hardware == "uhf" else NODE
    if environment == "open" and hardware != "uhf":
        return radio
    exponent, sd_db = ENVIRONMENTS[environment]
    return replace(
        radio, path_loss_exponent=exponent, shadowing_sd_db=sd_db, table_distances_m=(), table_sds_db=()
    )


def _moments_below(mean_log: float, s: float, limit_log: float) -> tuple[float, float]:
    """Return E[d] and E[d^2] where ln d ~ N(mean_log, s^2), given that ln d is below a limit."""
    z = (limit_log - mean_log) / s
    below: Array = log_ndtr(np.array([z, z - s, z - 2.0 * s]))
    first = exp(mean_log + s * s / 2.0 + float(below[1] - below[0]))
    second = exp(2.0 * mean_log + 2.0 * s * s + float(below[2] - below[0]))
    return first, second
