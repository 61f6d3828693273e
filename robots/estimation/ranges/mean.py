"""Sightings by range from one anchor, gathered, and the rows they make in a report."""

from __future__ import annotations

from collections.abc import Mapping
from math import cos, sin, sqrt
from typing import Any

import numpy as np

from robots.estimation.tag_filter import RangeSighting
from robots.se2 import Array, GaussianPose, wrap


class RangeMean:
    """The sightings of one tag from about one place: they share their errors, so their mean counts as one.

    Those made nearer to the anchor are known better with respect to it, and weigh more.
    """

    def __init__(self) -> None:
        self._weights = 0.0
        self.pose = np.zeros(3)  # of the antenna in the anchor's frame
        self.range_m = self.variance = 0.0
        self.bearing: float | None = None
        self.bearing_variance = 0.0
        self._row: tuple[float, ...] = ()

    def add(self, sighting: RangeSighting, anchor_from_base: GaussianPose) -> None:
        """Take in a sighting made from a pose of the base in the anchor's frame, with that one's error."""
        antenna = (anchor_from_base.mean @ sighting.base_from_antenna).as_array()
        along, across = _spread_of_base(sighting, antenna[2], anchor_from_base.covariance)
        bearing_sd = sighting.bearing_sd_rad or 1.0
        range_m, range_sd_m = _measured(sighting)
        weight = 1.0 / (1.0 + along / range_sd_m**2 + across / bearing_sd**2)
        self._weights += weight
        share = weight / self._weights
        turn = wrap(antenna[2] - self.pose[2]) if share < 1.0 else antenna[2]
        self.pose += np.array([*(antenna[:2] - self.pose[:2]), turn]) * share
        self.range_m += (range_m - self.range_m) * share
        if sighting.independent:
            self.variance = (1.0 - share) ** 2 * self.variance + share**2 * range_sd_m**2 + share * along
        else:
            self.variance += (range_sd_m**2 + along - self.variance) * share
        if sighting.bearing_rad is not None:
            self.bearing_variance += (bearing_sd**2 + across - self.bearing_variance) * share
            before = sighting.bearing_rad if self.bearing is None else self.bearing
            self.bearing = before + wrap(sighting.bearing_rad - before) * share
        self._row = self._made_row()

    @property
    def row(self) -> tuple[float, ...]:
        """Antenna (3), range, its deviation, bearing and its deviation; NaN where there is none."""
        return self._row

    def _made_row(self) -> tuple[float, ...]:
        bearing = np.nan if self.bearing is None else wrap(self.bearing)
        bearing_sd = np.nan if self.bearing is None else sqrt(self.bearing_variance)
        return (*self.pose.tolist(), self.range_m, sqrt(self.variance), bearing, bearing_sd)


def _measured(sighting: RangeSighting) -> tuple[float, float]:
    """Return range and deviation; of a signal by its median, about which its logarithm is normal.

    The mean of its likelihood would be too long: the batch weighs a range by the one expected.
    """
    if sighting.median_m is None or sighting.log_sd is None:
        return sighting.range_m, sighting.range_sd_m
    return sighting.median_m, max(sighting.log_sd, 1e-3) * sighting.median_m


def _spread_of_base(sighting: RangeSighting, facing_rad: float, covariance: Array) -> tuple[float, float]:
    """Return the variances of range (m2) and bearing (rad2) that come from the pose they were made from."""
    if sighting.bearing_rad is None:
        return float(covariance[0, 0] + covariance[1, 1]) / 2.0, 0.0
    c, s = cos(facing_rad + sighting.bearing_rad), sin(facing_rad + sighting.bearing_rad)
    u = np.array([c, s, 0.0])
    v = np.array([-s, c, 0.0]) / max(sighting.range_m, sighting.range_sd_m) + [0.0, 0.0, 1.0]
    return max(float(u @ covariance @ u), 0.0), max(float(v @ covariance @ v), 0.0)


def table(means: Mapping[tuple[int, int], RangeMean]) -> dict[str, Any]:
    """Return the fields of a ``GraphReport`` that hold ranges, of means by (anchor, tag index)."""
    rows = np.array([mean.row for mean in means.values()], np.float64).reshape(-1, 7)
    return {
        "range_pairs": np.array(list(means), np.int64).reshape(-1, 2),
        "range_poses": rows[:, :3].copy(),
        "ranges_m": rows[:, 3].copy(),
        "range_sds_m": rows[:, 4].copy(),
        "bearings_rad": rows[:, 5].copy(),
        "bearing_sds_rad": rows[:, 6].copy(),
    }
