"""What tags told of ground that others have covered, in this robot's map frame.

Kept by tag and drawn where the tags are believed now, so it moves with the graph. What a robot sees itself
overrules it: claims only speak of ground that is unknown in its own map.
"""

from __future__ import annotations

from bisect import insort
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from math import ceil

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy import ndimage

from robots.exploration.told.shade import shaded
from robots.exploration.told.survey import LATTICE_M, Survey, fine_cells
from robots.planning.plan_grid import UNKNOWN, PlanGrid
from robots.se2 import Array
from robots.tags.memory import CLOSED, TagMemory

FROM_AFAR_M = 1.5  # a tag read from so far was read before the robot drove where its writer did
_SURE_SD = 2.0  # deviations of a tag's place that what it says has to hold for, to be believed
_SAME_VICTIM_M = 1.0  # a first heat reading is off by so much
_SURE_OF_VICTIM = 0.4 * 255  # less sure, a warm spot there is looked into all the same
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


@dataclass(frozen=True, slots=True, eq=False)
class _Drawn:
    """What a tag says made ready to be drawn: its window in cells of the lattice, rows along y, and goals."""

    tag: KnownTag
    own: int | None
    fine: NDArray[np.uint8]
    first_m: tuple[float, float]  # x, y of the window's first corner in the map frame
    promised: Array  # (n, 2) in the map frame


class Claims:
    """The memories read so far, by tag."""

    def __init__(self) -> None:
        self.own: int | None = None  # the key by which tags know this robot: its own goals are no news
        self.reach_m = 0.0  # the farthest off that a tag was read
        self._memories: dict[str, TagMemory] = {}
        self._heard: dict[str, TagMemory] = {}  # as read last: the same again says nothing new
        self._read_s: dict[str, float] = {}
        self._sds_m: dict[str, float] = {}  # of the places where tags are believed
        self._ids: list[str] = []  # in order
        self._known: dict[str, KnownTag] = {}  # as last asked for, and where it was believed then
        self._drawn: dict[str, _Drawn] = {}

    def hear(self, tag_id: str, memory: TagMemory, now_s: float = 0.0, sd_m: float = 0.0) -> None:
        """Take in what a tag of the mission says; ``sd_m`` of the place where it is believed."""
        if tag_id not in self._memories:
            insort(self._ids, tag_id)
        self._known.pop(tag_id, None)
        if self._heard.get(tag_id) is not memory:
            self._heard[tag_id] = memory
            self._memories[tag_id] = self._memories.get(tag_id, TagMemory.empty()).merge(memory.uncut())
        self._read_s[tag_id], self._sds_m[tag_id] = now_s, sd_m

    def tags(self, place_of: PlaceOf, among: Iterable[str] | None = None) -> tuple[KnownTag, ...]:
        """Return the tags that were read and have a place, by id; only ``among`` these, in their order."""
        found, known = [], self._known
        for tag_id in self._ids if among is None else among:
            place = place_of(tag_id)
            if place is None:
                continue
            tag = known.get(tag_id)
            if tag is None or tag.place_m != place:
                tag = KnownTag(tag_id, place, self._memories[tag_id], self._read_s[tag_id])
                known[tag_id] = tag
            found.append(tag)
        return tuple(found)

    def victims(self, place_of: PlaceOf) -> tuple[ToldVictim, ...]:
        """Return the victims that tags are sure of, as the tags lie now."""
        return tuple(
            ToldVictim(tag.place_m[0] + 0.1 * mark.north_dm, tag.place_m[1] + 0.1 * mark.west_dm, within_m)
            for tag in self.tags(place_of)
            for within_m in (_SAME_VICTIM_M + _SURE_SD * self._sds_m[tag.tag_id],)
            for mark in tag.memory.victims
            if mark.confidence >= _SURE_OF_VICTIM
        )

    def survey(self, grid: PlanGrid, tags: Sequence[KnownTag]) -> Survey:
        """Return what is unknown, here and to all whose word was read in tags, as ``tags`` gave them."""
        unknown = _unknown_shares(grid.cells, grid.cell_m, LATTICE_M)
        whole = np.zeros(unknown.shape, np.uint8)
        sds_m, (left, low), (rows, columns) = self._sds_m, grid.origin, whole.shape
        claimed = whole if not any(sds_m.values()) else np.zeros_like(whole)
        promised = []
        for tag in tags:
            drawn = self._made_ready(tag)
            promised.append(drawn.promised)
            side = len(drawn.fine)
            row = round((drawn.first_m[1] - low) / LATTICE_M)
            column = round((drawn.first_m[0] - left) / LATTICE_M)
            if not (-side < row < rows and -side < column < columns):
                continue
            _draw(whole, drawn.fine, row, column)
            if claimed is not whole:
                rings = ceil(_SURE_SD * sds_m[tag.tag_id] / LATTICE_M - 1e-9)
                _draw(claimed, _eroded(drawn.fine, rings), row, column)
        doubtful = (whole == CLOSED) & (claimed != CLOSED)
        cell_m = max((tag.memory.cell_m for tag in tags), default=1.0)
        shade = shaded(whole, unknown, self.reach_m >= FROM_AFAR_M, cell_m)
        goals = np.concatenate(promised) if promised else np.zeros((0, 2))
        return Survey(unknown, claimed, grid.origin, goals, doubtful, shade)

    def _made_ready(self, tag: KnownTag) -> _Drawn:
        """Return what to draw of a tag, worked out anew where it says something else or lies elsewhere."""
        drawn = self._drawn.get(tag.tag_id)
        if drawn is not None and drawn.tag is tag and drawn.own == self.own:
            return drawn
        memory = tag.memory
        fine = drawn.fine if drawn is not None and drawn.tag.memory is memory else fine_cells(memory)
        offsets = [goal for p in memory.passes if p.key != self.own and (goal := p.goal_m) is not None]
        promised = np.array(offsets).reshape(-1, 2) + np.array(tag.place_m)
        half, (north, west) = memory.side / 2.0 * memory.cell_m, memory.shift_m
        first_m = tag.place_m[0] + north - half, tag.place_m[1] + west - half
        self._drawn[tag.tag_id] = drawn = _Drawn(tag, self.own, fine, first_m, promised)
        return drawn


class LateSurvey:
    """What ``Claims.survey`` returns, worked out when it is first asked for: not every strategy does."""

    def __init__(self, claims: Claims, grid: PlanGrid, tags: Sequence[KnownTag]) -> None:
        self._asked = claims, grid, tags
        self._made: Survey | None = None

    def __call__(self) -> Survey:
        """Return the survey."""
        if self._made is None:
            claims, grid, tags = self._asked
            self._made = claims.survey(grid, tags)
        return self._made


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


@njit(cache=True)
def _draw(claimed: NDArray[np.uint8], fine: NDArray[np.uint8], row: int, column: int) -> None:
    """Draw a window whose first cell is at (row, column) of the lattice."""
    rows, columns = claimed.shape
    for r in range(max(row, 0), min(row + fine.shape[0], rows)):
        for c in range(max(column, 0), min(column + fine.shape[1], columns)):
            claimed[r, c] = max(claimed[r, c], fine[r - row, c - column])
