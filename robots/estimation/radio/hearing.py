"""From what a person's device hears of nodes to ranges, as ``locating.py`` takes them.

The model is the robots' (``model.py``). A phone is another receiver, of unknown gain, held otherwise by
everybody: what it hears is off by the same dB for all nodes. What robots' RSLAM has learnt (scale, offsets)
is for ranges in metres alone: by signal it holds the gain of their receiver and what walls took, which the
plan counts already.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import log, sqrt

import numpy as np

from robots.config import RadioConfig, RangingConfig
from robots.estimation.radio.locating import Heard, Radio
from robots.estimation.radio.model import NEAREST_M, NODE, RadioModel
from robots.estimation.radio.signal_mean import robust_mean
from robots.estimation.radio.walls import WALL_DB

GAIN_SD_DB = 4.0  # of phones among each other, and of how they are held
EXPONENT_SD = 0.15  # as a share: n of one building and the next (Seidel and Rappaport 1992 table II)
_LEAST_SD = 1e-3  # in ln d


@dataclass(frozen=True, slots=True)
class NodePlace:
    """A node on the plan, in metres; ``sd_m`` along each axis."""

    node_id: str
    x_m: float
    y_m: float
    sd_m: float


@dataclass(frozen=True, slots=True)
class Ears:
    """The radio of a mission's nodes, and what was learnt: measured = scale * true + a node's offset."""

    radio: RadioConfig = NODE
    ranging: RangingConfig = field(default_factory=RangingConfig)
    scale: float = 1.0
    offsets_m: Mapping[str, float] = field(default_factory=dict)

    @property
    def shared(self) -> Radio:
        """What all signals have in common, in ln d."""
        per_db = log(10.0) / (10.0 * self.radio.path_loss_exponent)
        radio = self.radio
        sds = tuple(per_db * sd_db for sd_db in radio.table_sds_db or (radio.shadowing_sd_db,))
        gain, wall, distances_m = GAIN_SD_DB * per_db, WALL_DB * per_db, radio.table_distances_m or (0.0,)
        return Radio(gain, wall, radio.reach_m, EXPONENT_SD, distances_m, sds)

    def by_signal(self, node: NodePlace, rssis_dbm: Sequence[float]) -> Heard | None:
        """Return how far off a node sounds by signals heard at one place; None where they do not agree.

        Raises:
            ValueError: a signal is not finite.
        """
        model, value, count = RadioModel(self.radio), float(rssis_dbm[0]), 1
        if len(rssis_dbm) > 1:
            mean = robust_mean(np.array(rssis_dbm), self.radio.fading_sd_db)
            if mean is None:
                return None
            value, count = mean.rssi_dbm, mean.readings
        range_m = model.distance_m(value)
        fading = log(10.0) / (10.0 * self.radio.path_loss_exponent) * self.radio.fading_sd_db / sqrt(count)
        return Heard(node.node_id, node.x_m, node.y_m, node.sd_m, range_m, max(fading, _LEAST_SD))

    def by_range(self, node: NodePlace, ranges_m: Sequence[float]) -> Heard:
        """Return how far off a node is by ranges measured at one place: their median.

        Raises:
            ValueError: a range is not finite.
        """
        measured = float(np.median(np.array(ranges_m)))
        if not np.isfinite(measured):
            raise ValueError("a range has to be a finite number of metres")
        sd_m = self.ranging.range_sd_m + self.ranging.range_sd_per_m * measured
        range_m = self._true(node.node_id, measured)
        return Heard(node.node_id, node.x_m, node.y_m, node.sd_m, range_m, 0.0, sd_m)

    def _true(self, node_id: str, measured_m: float) -> float:
        return max((measured_m - self.offsets_m.get(node_id, 0.0)) / self.scale, NEAREST_M)
