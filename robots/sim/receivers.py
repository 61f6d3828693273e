"""When a robot's radio reads which tag, and what each reading says."""

from __future__ import annotations

from math import floor, inf

import numpy as np
from numpy.typing import NDArray

from robots.estimation.radio.model import Antenna
from robots.se2 import Array, Pose2
from robots.sim.channel import SENSITIVITY_DBM, Channel
from robots.sim.node_life import NodeLife
from robots.sim.tags import TagField
from robots.types import TagSighting

UHF_TAGS_PER_S = 50.0  # Ziparo 2007 section 2
_NODES, _RATES_HZ = (1.0, 4.0, 8.0), (28.6, 27.5, 16.5)  # Sun 2009 section 3
_MOVED_M, _TURNED_RAD = 0.05, 0.1  # so far everything sounds as before
_STATUS_EVERY_S = 1.0  # memory and sensors come with a reading so often, and after every write
_SPIKE_DB = (10.0, 30.0)


def read_rate_hz(nodes: int) -> float:
    """Return how often each of so many nodes in reach gets through (random broadcast with back-off).

    Sun 2009 gives 1, 4 and 8 nodes. With more than 8 the air is full: they share what 8 get.
    """
    if nodes > _NODES[-1]:
        return _RATES_HZ[-1] * _NODES[-1] / nodes
    return float(np.interp(nodes, _NODES, _RATES_HZ))


class Receiver:
    """The radio of one robot, for passive tags or active nodes."""

    def __init__(
        self, channel: Channel, field: TagField, life: NodeLife, spike_share: float, rng: np.random.Generator
    ) -> None:
        self._channel = channel
        self._field = field
        self._life = life
        self._weakest_dbm = SENSITIVITY_DBM[channel.hardware]
        self._spike_share = spike_share
        self._rng = rng
        self._signals_dbm: Array = np.zeros((0, 0))  # (a, m) as heard at ``_at``
        self._at: tuple[Pose2, int] | None = None
        self._due_s: Array = np.zeros(0)  # (m,) when each node is heard next, inf where it is not,
        self._every_s = inf  # and then again about so often
        self._tuned = False  # to the signals as they are now
        self._status_s: dict[int, float] = {}
        self._memories: dict[int, bytes] = {}  # as last told, by tag
        self._credit = 0.0  # readings a reader of passive tags has time for

    def reaches(self, index: int) -> bool:
        """Return whether the tag of this index was within reach at the latest look."""
        return index < self._signals_dbm.shape[1] and bool(self._signals_dbm[:, index].max() > -inf)

    def sightings(self, pose: Pose2, clock_s: float, dt_s: float) -> tuple[TagSighting, ...]:
        """Return the readings of the last ``dt_s`` in the order in which they were made."""
        self._look(pose)
        passive = self._channel.hardware == "uhf"
        read = self._inventory(dt_s) if passive else self._broadcasts(clock_s)
        if not read:
            return ()
        antennas: tuple[Antenna | None, ...] = ("front", "rear") if passive else (None,)
        errors = self._channel.config.fading_sd_db * self._rng.standard_normal(len(read))
        if self._spike_share:
            spiked = self._rng.random(len(read)) < self._spike_share
            errors += spiked * self._rng.uniform(*_SPIKE_DB, len(read)) * self._rng.choice((-1, 1), len(read))
        sightings = []
        for k, (antenna, index) in enumerate(read):
            signal = float(self._signals_dbm[antenna, index] + errors[k])
            if signal >= self._weakest_dbm:
                rssi_dbm = round(min(max(signal, -150.0), 50.0), 1)
                sightings.append(self._sighting(index, rssi_dbm, antennas[antenna], clock_s))
        return tuple(sightings)

    def _look(self, pose: Pose2) -> None:
        if self._at is not None and self._at[1] == self._field.version:
            moved = self._at[0].between(pose)
            if abs(moved.x) + abs(moved.y) < _MOVED_M and abs(moved.theta) < _TURNED_RAD:
                return
        self._at = (pose, self._field.version)
        antennas = self._channel.antennas(pose.x, pose.y, pose.theta)
        self._signals_dbm = self._channel.signals_dbm(antennas)
        self._tuned = False

    def _inventory(self, dt_s: float) -> list[tuple[int, int]]:
        """Return what a reader with anti-collision reads: all within reach in turn, so many a second."""
        self._credit += UHF_TAGS_PER_S * dt_s
        count, self._credit = floor(self._credit), self._credit % 1.0
        pairs = np.argwhere(self._signals_dbm > -inf)
        if len(pairs) == 0 or count == 0:
            return []
        chosen = np.resize(self._rng.permutation(len(pairs)), count)
        return [(int(antenna), int(index)) for antenna, index in pairs[chosen]]

    def _broadcasts(self, clock_s: float) -> list[tuple[int, int]]:
        """Return the nodes that got through: each sends again after a random while."""
        due = self._due_s
        if not self._tuned:
            self._tuned = True
            heard: NDArray[np.bool_] = self._signals_dbm.max(axis=0) > -inf
            self._every_s = 1.0 / read_rate_hz(max(1, int(heard.sum())))
            self._due_s = np.full(len(heard), inf)
            self._due_s[: len(due)] = due
            due = self._due_s
            due[~heard] = inf
            fresh = heard & np.isinf(due)
            due[fresh] = clock_s + self._every_s * self._rng.random(int(fresh.sum()))
        sent: list[tuple[float, int]] = []
        while (ready := (due <= clock_s).nonzero()[0]).size:
            sent.extend(zip(due[ready].tolist(), ready.tolist(), strict=True))
            due[ready] += self._every_s * self._rng.uniform(0.5, 1.5, ready.size)
        return [(0, index) for _, index in sorted(sent)]

    def _sighting(self, index: int, rssi_dbm: float, antenna: Antenna | None, clock_s: float) -> TagSighting:
        tag = self._field.tag(index)
        told = clock_s - self._status_s.get(index, -inf) < _STATUS_EVERY_S - 1e-9
        if told and self._memories[index] == tag.memory:
            return TagSighting(tag.tag_id, rssi_dbm=rssi_dbm, antenna=antenna)
        self._status_s[index], self._memories[index] = clock_s, tag.memory
        active = self._channel.hardware == "node"
        sensors = self._life.sensors(tag, clock_s, self._rng) if active else None
        return TagSighting(tag.tag_id, tag.memory, rssi_dbm=rssi_dbm, antenna=antenna, sensors=sensors)
