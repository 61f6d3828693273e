"""What is unknown round a robot, to it and to all whose word it read, on a lattice."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from robots.se2 import Array
from robots.tags.memory import CLOSED

LATTICE_M = 0.5


@dataclass(frozen=True, slots=True, eq=False)
class Survey:
    """A lattice of ``LATTICE_M``: ``unknown`` (r, c), the share of each cell; ``claimed`` (r, c), its state.

    Cell (0, 0) has its lower left corner at ``origin`` (x, y) in the map frame. Beyond it all is unknown.
    ``promised`` (n, 2): where others went, as they told tags. ``doubtful`` (r, c): what would be claimed too
    if the tags were known to lie where they are believed to. ``shade`` (r, c): what is not worth going to
    though nobody told of it (``shade.shaded``).
    """

    unknown: Array
    claimed: NDArray[np.uint8]
    origin: tuple[float, float]
    promised: Array = field(default_factory=lambda: np.zeros((0, 2)))
    doubtful: NDArray[np.bool_] | None = None
    shade: NDArray[np.bool_] | None = None
    _told: dict[tuple[bytes, float], tuple[Array, Array]] = field(default_factory=dict, repr=False)

    def left_out(self) -> NDArray[np.bool_]:
        """Return which cells are no goal: covered, perhaps covered, or in the shade of what is; (r, c)."""
        out: NDArray[np.bool_] = self.claimed == CLOSED
        for mask in (self.doubtful, self.shade):
            out = out if mask is None else out | mask
        return out

    def untold(self, within_m: float) -> Array:
        """Return how much of the square round each cell is news, (r, c); beyond the lattice all is."""
        reach = round(within_m / LATTICE_M)
        told = self.claimed == CLOSED if self.shade is None else (self.claimed == CLOSED) | self.shade
        news = np.pad(np.where(told, 0.0, self.unknown), reach, constant_values=1.0)
        rows, columns = np.indices(told.shape).reshape(2, -1) + reach
        sums = _sums(news, np.column_stack([rows, columns]), reach)
        shares: Array = sums.reshape(told.shape) / float((2 * reach + 1) ** 2)
        return shares

    def nearness(self, places_m: Array, within_m: float) -> Array:
        """Return how near, 0 to 1, each cell is to one of some places (n, 2), (r, c)."""
        away = np.ones(self.claimed.shape, bool)
        at = self._cells(places_m)
        at = at[((at >= 0) & (at < away.shape)).all(axis=1)]
        if len(at) == 0:
            return np.zeros(away.shape)
        away[at[:, 0], at[:, 1]] = False
        gaps = ndimage.distance_transform_edt(away) * LATTICE_M
        near: Array = np.maximum(0.0, 1.0 - gaps / within_m)
        return near

    def shares(self, points_m: Array, within_m: float) -> tuple[Array, Array]:
        """Return how much of the squares round points (n, 2) nobody has told of, and how much is claimed.

        Shares (n,) of squares that reach ``within_m`` to every side; both speak of ground unknown here.
        """
        asked = points_m.tobytes(), within_m  # the same for every robot that frontiers are weighed for
        if asked not in self._told:
            self._told[asked] = self._shares(points_m, within_m)
        return self._told[asked]

    def _shares(self, points_m: Array, within_m: float) -> tuple[Array, Array]:
        reach = round(within_m / LATTICE_M)
        told = self.claimed == CLOSED
        open_, claimed = (
            _sums(part, self._cells(points_m), reach) for part in (~told * self.unknown, told * self.unknown)
        )
        size = float((2 * reach + 1) ** 2)
        inside = _sums(np.ones_like(self.unknown), self._cells(points_m), reach)
        return (open_ + size - inside) / size, claimed / size

    def _cells(self, points_m: Array) -> NDArray[np.int64]:
        found: Array = np.floor((points_m[:, ::-1] - np.array(self.origin[::-1])) / LATTICE_M)
        return found.astype(np.int64)


def _sums(values: Array, cells: NDArray[np.int64], reach: int) -> Array:
    """Return the sums over squares round cells (n, 2), cut off at the border."""
    total = np.zeros((values.shape[0] + 1, values.shape[1] + 1))
    total[1:, 1:] = values.cumsum(axis=0).cumsum(axis=1)
    low = np.clip(cells - reach, 0, values.shape)
    high = np.clip(cells + reach + 1, 0, values.shape)
    sums: Array = (
        total[high[:, 0], high[:, 1]]
        - total[low[:, 0], high[:, 1]]
        - total[high[:, 0], low[:, 1]]
        + total[low[:, 0], low[:, 1]]
    )
    return sums
