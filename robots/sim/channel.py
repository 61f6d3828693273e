"""What an antenna hears of tags: path loss, shadowing, walls on the way, cones.

The numbers are those of ``robots.estimation.radio.model``, which the estimators have too; what they cannot
know is here: the shadowing of each place, and the walls, traced through the grid for every link.
"""

from __future__ import annotations

from math import atan2, cos, floor, hypot, inf, log, log10, pi, sin, sqrt
from zlib import crc32

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robots.config import RadioConfig
from robots.estimation.radio.model import NEAREST_M, TagHardware
from robots.estimation.radio.walls import WALL_DB, count_walls
from robots.se2 import Array
from robots.sim.tags import Tag, TagField
from robots.sim.world import Cells, World

Keys = NDArray[np.uint64]

# The CC2420 hears down to -95 dBm and counts from -45 dBm (Sun 2009 [8]); a passive tag answers within reach
SENSITIVITY_DBM: dict[TagHardware, float] = {"uhf": -inf, "node": -50.0}

_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_MIX_A, _MIX_B = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)
_S30, _S27, _S31, _S11 = np.uint64(30), np.uint64(27), np.uint64(31), np.uint64(11)


@njit(cache=True)
def _mixed(value: np.uint64) -> np.uint64:
    """Return the next number of SplitMix64 (Steele 2014)."""
    value = value + _GOLDEN
    value = (value ^ (value >> _S30)) * _MIX_A
    value = (value ^ (value >> _S27)) * _MIX_B
    return np.uint64(value ^ (value >> _S31))


@njit(cache=True)
def _standard_normal(key: np.uint64, column: int, row: int) -> float:
    """Return the normal number that belongs to a tag's key and a cell (Box and Muller 1958)."""
    first = _mixed(_mixed(key ^ np.uint64(column)) ^ np.uint64(row))
    second = _mixed(first)
    u = (float(first >> _S11) + 1.0) / 9007199254740993.0
    v = float(second >> _S11) / 9007199254740992.0
    return sqrt(-2.0 * log(u)) * cos(2.0 * pi * v)


@njit(cache=True)
def _interpolated(x: float, xs: Array, ys: Array) -> float:
    """Return the value of a table, constant beyond its ends."""
    value = float(ys[-1])
    for k in range(xs.size - 1, 0, -1):
        if x <= xs[k]:
            value = float(ys[k - 1] + (ys[k] - ys[k - 1]) * (x - xs[k - 1]) / (xs[k] - xs[k - 1]))
    return value if x > xs[0] else float(ys[0])


@njit(cache=True)
def _signals(
    cells: Cells,
    origin: tuple[float, float],
    resolution: float,
    antennas: Array,
    cone: float,
    tags: Array,
    keys: Keys,
    on: NDArray[np.bool_],
    power: float,
    exponent: float,
    distances: Array,
    sds: Array,
    place: float,
    reach: float,
    wall_db: float,
    weakest: float,
    signals: Array,
) -> None:
    for a in range(antennas.shape[0]):
        x, y, heading = antennas[a]
        column, row = floor(x / place), floor(y / place)
        for m in range(tags.shape[0]):
            signals[a, m] = -inf
            dx, dy = tags[m, 0] - x, tags[m, 1] - y
            distance = hypot(dx, dy)
            if not on[m] or distance > reach:
                continue
            if cone < 2.0 * pi:
                off = atan2(dy, dx) - heading
                if abs(off - 2.0 * pi * floor((off + pi) / (2.0 * pi))) > cone / 2.0:
                    continue
            signal = power - 10.0 * exponent * log10(max(distance, NEAREST_M))
            signal += _interpolated(distance, distances, sds) * _standard_normal(keys[m], column, row)
            if signal < weakest:
                continue
            most = 1 if wall_db == inf else int(min((signal - weakest) / wall_db, 1e6)) + 1
            walls = count_walls(
                cells,
                (x - origin[0]) / resolution,
                (y - origin[1]) / resolution,
                (tags[m, 0] - origin[0]) / resolution,
                (tags[m, 1] - origin[1]) / resolution,
                most,
            )
            if walls > 0:
                signal -= walls * wall_db
            if signal >= weakest:
                signals[a, m] = signal


class Channel:
    """The air between the antennas and the tags of one world.

    Line of sight is all that a passive tag answers to; a wall takes ``WALL_DB`` from an active node.
    """

    def __init__(
        self, world: World, field: TagField, hardware: TagHardware, config: RadioConfig, seed: int
    ) -> None:
        self._world = world
        self._field = field
        self.hardware: TagHardware = hardware
        self.config = config
        self._seed = seed
        self._keys: Keys = np.zeros(0, np.uint64)
        self._version = -1  # of the field, when the keys were made

    def signals_dbm(self, antennas: Array) -> Array:
        """Return the mean signal (a, m) of each tag at each antenna; -inf where it is not heard.

        ``antennas`` (a, 3) in the world, looking along their heading. A mean a little below what can be heard
        still counts, as its readings scatter.
        """
        config = self.config
        sight_only = self.hardware == "uhf"
        table = config.table_distances_m
        field = self._field
        if self._version != field.version:
            self._keys = np.array([self._key(tag) for tag in field.tags], np.uint64)
            self._version = field.version
        signals: Array = np.empty((len(antennas), len(self._keys)))
        _signals(
            self._world.cells,
            self._world.origin_m,
            self._world.resolution_m,
            antennas,
            config.cone_rad if sight_only else 2.0 * pi,
            field.places_m,
            self._keys,
            field.on,
            config.power_at_1m_dbm,
            config.path_loss_exponent,
            np.array(table if table else (0.0,)),
            np.array(config.table_sds_db if table else (config.shadowing_sd_db,)),
            config.place_m,
            config.reach_m,
            inf if sight_only else WALL_DB,
            SENSITIVITY_DBM[self.hardware] - 3.0 * config.fading_sd_db,
            signals,
        )
        return signals

    def antennas(self, x_m: float, y_m: float, heading_rad: float) -> Array:
        """Return the antennas of a robot in the world, (a, 3): front and rear, or one over its base."""
        if self.hardware != "uhf":
            return np.array([[x_m, y_m, heading_rad]])
        c, s = cos(heading_rad), sin(heading_rad)
        front, rear = self.config.front_ahead_m, self.config.rear_ahead_m
        return np.array(
            [
                [x_m + front * c, y_m + front * s, heading_rad],
                [x_m + rear * c, y_m + rear * s, heading_rad + pi],
            ]
        )

    def _key(self, tag: Tag) -> int:
        """Return the number from which the shadowing of a tag follows: another one when it is moved."""
        column, row = floor(tag.x_m / self.config.place_m), floor(tag.y_m / self.config.place_m)
        place = f"{self._seed} {tag.tag_id} {column} {row}"
        return crc32(place.encode()) | (crc32(place[::-1].encode()) << 32)
