"""What tags told of ground that others have covered, in this robot's map frame.

Kept by tag and drawn where the tags are believed now, so it moves with the graph. What a robot sees itself
overrules it: claims only speak of ground that is unknown in its own map.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import ceil

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy import ndimage

from robots.exploration.told.shade import shaded
from robots.exploration.told.survey import LATTICE_M, Survey
from robots.planning.plan_grid import UNKNOWN, PlanGrid
from robots.se2 import Array
from robots.tags.memory import CELL_M, CLOSED, TagMemory

FROM_AFAR_M = 1.5  # a tag read from so far was read before the robot drove where its writer did
_SURE_SD = 2.0  # deviations of a tag's place that what it says has to hold for, to be believed
_PER_CELL = round(CELL_M / LATTICE_M)
_SAME_VICTIM_M = 1.0  # a first heat reading is off by so much
PlaceOf = Callable[[str], tuple[float, float] | None]  # of a tag in the map frame, None where unknown


@dataclass(frozen=True, slots=True, eq=False)
class KnownTag:
    """A tag of the mission that was read: where it is believed, what it said, when it was read last."""

    tag_id: str
    place_m: tuple[float, float]
    memory: TagMemory
    read_s: float


@dataclass(frozen=True, slots=True)
class ToldVictim:
    """A victim that a robot is sure of, in the map frame; what is warm ``within_m`` of it is that victim."""

    x: float
    y: float
    within_m: float


def driven(tags: Sequence[KnownTag]) -> Array:
    """Return where robots drove, as tags tell it, (n, 2) in the map frame: there are tags to be read."""
    found = [tag.memory.visited_m + np.array(tag.place_m) for tag in tags]
    return np.concatenate([np.zeros((0, 2)), *found])


class Claims:
    """The memories read so far, by tag."""

    def __init__(self) -> None:
        self.own: int | None = None  # the key by which tags know this robot: its own goals are no news
        self.reach_m = 0.0  # the farthest off that a tag was read
        self._memories: dict[str, TagMemory] = {}
        self._heard: dict[str, TagMemory] = {}  # as read last: the same again says nothing new
        self._read_s: dict[str, float] = {}
        self._sds_m: dict[str, float] = {}  # of the places where tags are believed

    def hear(self, tag_id: str, memory: TagMemory, now_s: float = 0.0, sd_m: float = 0.0) -> None:
        """Take in what a tag of the mission says; ``sd_m`` of the place where it is believed."""
        if self._heard.get(tag_id) is not memory:
            self._heard[tag_id] = memory
            self._memories[tag_id] = self._memories.get(tag_id, TagMemory.empty()).merge(memory.uncut())
        self._read_s[tag_id], self._sds_m[tag_id] = now_s, sd_m

    def tags(self, place_of: PlaceOf) -> tuple[KnownTag, ...]:
        """Return the tags that were read and have a place, by id."""
        places = ((tag_id, place_of(tag_id)) for tag_id in sorted(self._memories))
        return tuple(
            KnownTag(tag_id, place, self._memories[tag_id], self._read_s[tag_id])
            for tag_id, place in places
            if place is not None
        )

    def victims(self, place_of: PlaceOf) -> tuple[ToldVictim, ...]:
        """Return the victims that tags tell of, as the tags lie now."""
        return tuple(
            ToldVictim(tag.place_m[0] + 0.1 * mark.north_dm, tag.place_m[1] + 0.1 * mark.west_dm, within_m)
            for tag in self.tags(place_of)
            for within_m in (_SAME_VICTIM_M + _SURE_SD * self._sds_m[tag.tag_id],)
            for mark in tag.memory.victims
        )

    def survey(self, grid: PlanGrid, place_of: PlaceOf) -> Survey:
        """Return what is unknown, here and to all whose word was read, as the tags lie now."""
        unknown = _unknown_shares(grid.cells, grid.cell_m, LATTICE_M)
        claimed, whole = np.zeros(unknown.shape, np.uint8), np.zeros(unknown.shape, np.uint8)
        promised = []
        for tag in self.tags(place_of):
            fine = np.repeat(np.repeat(tag.memory.cells.T, _PER_CELL, axis=0), _PER_CELL, axis=1)
            rings = ceil(_SURE_SD * self._sds_m[tag.tag_id] / LATTICE_M - 1e-9)
            _draw(whole, fine, tag, grid.origin)
            _draw(claimed, _eroded(fine, rings), tag, grid.origin)
            promised += [
                (tag.place_m[0] + p.goal_m[0], tag.place_m[1] + p.goal_m[1])
                for p in tag.memory.passes
                if p.key != self.own and p.goal_m is not None
            ]
        doubtful = (whole == CLOSED) & (claimed != CLOSED)
        shade = shaded(whole, unknown, self.reach_m >= FROM_AFAR_M)
        return Survey(unknown, claimed, grid.origin, np.array(promised).reshape(-1, 2), doubtful, shade)


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
