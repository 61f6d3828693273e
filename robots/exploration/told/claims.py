"""What tags told of ground that others have covered, in this robot's map frame.

Kept by tag and drawn where the tags are believed now, so it moves with the graph. What a robot sees itself
overrules it: claims only speak of ground that is unknown in its own map.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import ceil

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy import ndimage

from robots.planning.plan_grid import UNKNOWN, PlanGrid
from robots.se2 import Array
from robots.tags.memory import CELL_M, CLOSED, TagMemory

LATTICE_M = 0.5
_PER_CELL = round(CELL_M / LATTICE_M)
PlaceOf = Callable[[str], tuple[float, float] | None]  # of a tag in the map frame, None where unknown


@dataclass(frozen=True, slots=True, eq=False)
class KnownTag:
    """A tag of the mission that was read: where it is believed, what it said, when it was read last."""

    tag_id: str
    place_m: tuple[float, float]
    memory: TagMemory
    read_s: float


def driven(tags: Sequence[KnownTag]) -> Array:
    """Return where robots drove, as tags tell it, (n, 2) in the map frame: there are tags to be read."""
    found = [tag.memory.visited_m + np.array(tag.place_m) for tag in tags]
    return np.concatenate([np.zeros((0, 2)), *found])


class Claims:
    """The memories read so far, by tag."""

    def __init__(self) -> None:
        self.own: int | None = None  # the key by which tags know this robot: its own goals are no news
        self._memories: dict[str, TagMemory] = {}
        self._read_s: dict[str, float] = {}
        self._sds_m: dict[str, float] = {}  # of the places where tags are believed

    def hear(self, tag_id: str, memory: TagMemory, now_s: float = 0.0, sd_m: float = 0.0) -> None:
        """Take in what a tag of the mission says; ``sd_m`` of the place where it is believed."""
        known = self._memories.get(tag_id, TagMemory.empty())
        self._memories[tag_id] = known.merge(memory.uncut())
        self._read_s[tag_id], self._sds_m[tag_id] = now_s, sd_m

    def tags(self, place_of: PlaceOf) -> tuple[KnownTag, ...]:
        """Return the tags that were read and have a place, by id."""
        places = ((tag_id, place_of(tag_id)) for tag_id in sorted(self._memories))
        return tuple(
            KnownTag(tag_id, place, self._memories[tag_id], self._read_s[tag_id])
            for tag_id, place in places
            if place is not None
        )

    def survey(self, grid: PlanGrid, place_of: PlaceOf) -> Survey:
        """Return what is unknown, here and to all whose word was read, as the tags lie now."""
        unknown = _unknown_shares(grid.cells, grid.cell_m, LATTICE_M)
        claimed, whole = np.zeros(unknown.shape, np.uint8), np.zeros(unknown.shape, np.uint8)
        promised = []
        for tag in self.tags(place_of):
            fine = np.repeat(np.repeat(tag.memory.cells.T, _PER_CELL, axis=0), _PER_CELL, axis=1)
            rings = ceil(self._sds_m[tag.tag_id] / LATTICE_M - 1e-9)
            _draw(whole, fine, tag, grid.origin)
            _draw(claimed, _eroded(fine, rings), tag, grid.origin)
            promised += [
                (tag.place_m[0] + p.goal_m[0], tag.place_m[1] + p.goal_m[1])
                for p in tag.memory.passes
                if p.key != self.own and p.goal_m is not None
            ]
        doubtful = (whole == CLOSED) & (claimed != CLOSED)
        return Survey(unknown, claimed, grid.origin, np.array(promised).reshape(-1, 2), doubtful)


@dataclass(frozen=True, slots=True, eq=False)
class Survey:
    """A lattice of ``LATTICE_M``: ``unknown`` (r, c), the share of each cell; ``claimed`` (r, c), its state.

    Cell (0, 0) has its lower left corner at ``origin`` (x, y) in the map frame. Beyond it all is unknown.
    ``promised`` (n, 2): where others went, as they told tags. ``doubtful`` (r, c): what would be claimed too
    if the tags were known to lie where they are believed to.
    """

    unknown: Array
    claimed: NDArray[np.uint8]
    origin: tuple[float, float]
    promised: Array = field(default_factory=lambda: np.zeros((0, 2)))
    doubtful: NDArray[np.bool_] | None = None
    _told: dict[tuple[bytes, float], tuple[Array, Array]] = field(default_factory=dict, repr=False)

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


@njit(cache=True)
def _unknown_shares(cells: NDArray[np.uint8], cell_m: float, lattice_m: float) -> Array:
    """Return how much of each cell of the lattice is unknown; what lies beyond the grid is."""
    rows, columns = cells.shape
    high = int(np.ceil(rows * cell_m / lattice_m - 1e-6))
    wide = int(np.ceil(columns * cell_m / lattice_m - 1e-6))
    known = np.zeros((high, wide))
    for r in range(rows):
        for c in range(columns):
            if cells[r, c] != UNKNOWN:
                known[int((r + 0.5) * cell_m / lattice_m), int((c + 0.5) * cell_m / lattice_m)] += 1.0
    shares = np.empty((high, wide))
    for k in range(high):
        tall = _centres_in(k, cell_m, lattice_m)
        for m in range(wide):
            total = tall * _centres_in(m, cell_m, lattice_m)
            shares[k, m] = (total - known[k, m]) / total if total > 0 else 1.0
    return shares


@njit(cache=True)
def _centres_in(k: int, cell_m: float, lattice_m: float) -> int:
    """Return how many cells in a row have their centres in cell ``k`` of the lattice."""
    first = int(np.ceil(k * lattice_m / cell_m - 0.5 - 1e-9))
    return int(np.ceil((k + 1) * lattice_m / cell_m - 0.5 - 1e-9)) - first


def _eroded(fine: NDArray[np.uint8], rings: int) -> NDArray[np.uint8]:
    """Return a window that calls closed only what is told of all round, so many cells far; else unseen."""
    if rings == 0:
        return fine
    inner = ndimage.binary_erosion(fine > 0, np.ones((2 * rings + 1,) * 2, bool))
    return np.where((fine == CLOSED) & ~inner, 0, fine).astype(np.uint8)


def _draw(
    claimed: NDArray[np.uint8], fine: NDArray[np.uint8], tag: KnownTag, origin: tuple[float, float]
) -> None:
    """Draw a tag's window, in cells of the lattice, rows along y."""
    half = tag.memory.side / 2.0 * CELL_M
    north, west = tag.memory.shift_m
    row = round((tag.place_m[1] + west - half - origin[1]) / LATTICE_M)
    column = round((tag.place_m[0] + north - half - origin[0]) / LATTICE_M)
    rows, columns = claimed.shape
    top, left = max(row, 0), max(column, 0)
    bottom, right = min(row + len(fine), rows), min(column + len(fine), columns)
    if top < bottom and left < right:
        part = claimed[top:bottom, left:right]
        np.maximum(part, fine[top - row : bottom - row, left - column : right - column], out=part)


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
