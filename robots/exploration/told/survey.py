"""What is unknown round a robot, to it and to all whose word it read, on a lattice."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import sqrt

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robots.se2 import Array
from robots.tags.memory import CLOSED, TagMemory

LATTICE_M = 0.5


def fine_cells(memory: TagMemory) -> NDArray[np.uint8]:
    """Return a tag's window in cells of the lattice, of which its own are whole numbers; rows along y."""
    each = round(memory.cell_m / LATTICE_M)
    return np.repeat(np.repeat(memory.cells.T, each, axis=0), each, axis=1)


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
        sums = _square_sums(news, reach)
        shares: Array = sums / float((2 * reach + 1) ** 2)
        return shares

    def nearness(self, places_m: Array, within_m: float) -> Array:
        """Return how near, 0 to 1, each cell is to one of some places (n, 2), (r, c)."""
        near: Array = _nearness(self._cells(places_m), self.claimed.shape, within_m / LATTICE_M)
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
        low, high = (np.clip(self._cells(points_m) + side, 0, told.shape) for side in (-reach, reach + 1))
        inside = (high - low).prod(axis=1)
        return (open_ + size - inside) / size, claimed / size

    def _cells(self, points_m: Array) -> NDArray[np.int64]:
        found: Array = np.floor((points_m[:, ::-1] - np.array(self.origin[::-1])) / LATTICE_M)
        return found.astype(np.int64)


@njit(cache=True)
def _totals(values: Array) -> Array:
    """Return the sums of all above and left of each corner, (r + 1, c + 1)."""
    rows, columns = values.shape
    total = np.zeros((rows + 1, columns + 1))
    for r in range(rows):
        for c in range(columns):
            total[r + 1, c + 1] = total[r, c + 1] + values[r, c]
    for r in range(rows):
        for c in range(columns):
            total[r + 1, c + 1] += total[r + 1, c]
    return total


@njit(cache=True)
def _sums(values: Array, cells: NDArray[np.int64], reach: int) -> Array:
    """Return the sums over squares round cells (n, 2), cut off at the border."""
    rows, columns = values.shape
    total = _totals(values)
    sums = np.empty(len(cells))
    for k in range(len(cells)):
        top, left = min(max(cells[k, 0] - reach, 0), rows), min(max(cells[k, 1] - reach, 0), columns)
        bottom = min(max(cells[k, 0] + reach + 1, 0), rows)
        right = min(max(cells[k, 1] + reach + 1, 0), columns)
        sums[k] = total[bottom, right] - total[top, right] - total[bottom, left] + total[top, left]
    return sums


@njit(cache=True)
def _square_sums(values: Array, reach: int) -> Array:
    """Return the sums over the squares round all cells at least ``reach`` from the border."""
    total, side = _totals(values), 2 * reach + 1
    rows, columns = values.shape[0] - 2 * reach, values.shape[1] - 2 * reach
    sums = np.empty((rows, columns))
    for r in range(rows):
        for c in range(columns):
            sums[r, c] = total[r + side, c + side] - total[r, c + side] - total[r + side, c] + total[r, c]
    return sums


@njit(cache=True)
def _nearness(places: NDArray[np.int64], shape: tuple[int, int], within: float) -> Array:
    """Return how near, 0 to 1, each cell is to one of the places (n, 2); 0 from so many cells on."""
    rows, columns = shape
    reach = int(within) + 1
    far = rows + columns + reach
    across = np.full((rows, columns), far, np.int64)  # to the nearest place in the same row
    for k in range(len(places)):
        r, c = places[k]
        if 0 <= r < rows and 0 <= c < columns:
            across[r, c] = 0
    for r in range(rows):
        for c in range(1, columns):
            across[r, c] = min(across[r, c], across[r, c - 1] + 1)
        for c in range(columns - 2, -1, -1):
            across[r, c] = min(across[r, c], across[r, c + 1] + 1)
    near = np.zeros((rows, columns))
    for r in range(rows):
        for c in range(columns):
            squared = far * far
            for v in range(max(0, r - reach), min(rows, r + reach + 1)):
                squared = min(squared, (v - r) * (v - r) + across[v, c] * across[v, c])
            near[r, c] = max(0.0, 1.0 - sqrt(float(squared)) / within)
    return near
