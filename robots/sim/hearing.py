"""What a person's device hears of radio nodes in the simulator: the robots' channel, another receiver."""

from __future__ import annotations

import numpy as np

from robots.config import RadioConfig
from robots.estimation.radio.hearing import GAIN_SD_DB
from robots.sim.channel import SENSITIVITY_DBM, Channel
from robots.sim.tags import TagField
from robots.sim.world import World

_READINGS = 10  # of each node, while they stand still


class Device:
    """One device; its gain is off as those of phones are, by the same for all nodes."""

    def __init__(self, world: World, field: TagField, radio: RadioConfig, seed: int) -> None:
        self._channel = Channel(world, field, "node", radio, seed)
        self._field = field
        self._rng = np.random.default_rng([seed, 91])
        self._gain_db = GAIN_SD_DB * float(self._rng.normal())

    def heard_at(self, x_m: float, y_m: float) -> list[tuple[str, float]]:
        """Return node and signal (dBm) of each reading at a place of the world."""
        signals = self._channel.signals_dbm(self._channel.antennas(x_m, y_m, 0.0))[0]
        fading = self._channel.config.fading_sd_db * self._rng.standard_normal((len(signals), _READINGS))
        return [
            (self._field.tag(int(index)).tag_id, round(float(rssi + self._gain_db), 1))
            for index in np.flatnonzero(np.isfinite(signals))
            for rssi in signals[index] + fading[index]
            if rssi >= SENSITIVITY_DBM["node"]
        ]
