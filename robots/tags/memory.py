"""What a tag's memory says, as a value that merges: greatest state, newest map, all notes.

Round the tag lies the ground others have covered, cells that only grow: unseen < covered with an open
frontier < covered and closed; open cells are the frontiers that are known there. Beside it may stand cells of
0.4 m that robots drove through, victims, notes, who passed, and maps of tags. Frame: the writer's compass,
centred on the tag, rows north (x), columns west (y). Merging is commutative, associative and idempotent, so
no order of visits and no clock changes the outcome.

What a chip has no room for is let go by a fixed order: each kind has a share of the room that depends on the
chip alone, coverage has all that the others leave, and loses its outer rings first. How far a window was cut
is part of the value (``reach``, ``visited_reach``, ``Notes.gone``). What a memory takes only grows with what
it knows, so fitting before or after a merge comes to the same.

The cells of coverage lie on a lattice that need not be centred on the tag: ``phase`` says where in its cell
the tag lies, sixteenths of a cell in x (low 4 bits) and y, and above that how large cells are. Robots keep
the lattice that they find, so cells go from tag to tag without being drawn anew. Of windows on two lattices
the greater phase counts.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from robots.se2 import Array
from robots.tags.map_memory import WriterMap, fit_maps, least_room, merge_maps
from robots.tags.marks import (
    Notes,
    Pass,
    VictimMark,
    merged_marks,
    pack_passes,
    pack_victims,
    passes_in,
    victims_in,
)
from robots.tags.window import cost, fitting_reach, joined, no_cells, resized, trimmed, within

CELLS_M = (1.0, 0.5, 2.0)  # of coverage, by the two bits above a phase
VISITED_M = 0.4
UNSEEN, OPEN, CLOSED = 0, 1, 2
REACH, VISITED_REACH = 31, 10  # cells from the middle to the border
SIDE = 2 * REACH + 1
CENTRED = 0x88  # the phase of a tag in the middle of its cell of 1 m
MAX_PHASE = len(CELLS_M) << 8
WINDOWS = ("cells", "phase", "reach", "visited", "visited_reach")  # of a memory: what it says of the ground
WINDOW_HEAD = 2  # bytes: reach and phase
_HEAD = 1
_MAPS_FROM, _BESIDE_MAPS = 256, 195  # bytes of room from which maps have theirs; what the others share then
_LEAST_NOTES, _LEAST_VISITED = 16, 6


class TagMemoryError(ValueError):
    """The bytes are no memory of this version, or they are damaged."""


@dataclass(frozen=True, slots=True, eq=False)
class TagMemory:
    """What is known round a tag.

    ``cells`` uint8 (s, s) of UNSEEN, OPEN, CLOSED and ``visited`` uint8 (v, v), how often robots drove there:
    not, once, more often; both of an odd side. ``reach`` and ``visited_reach``: cells farther than this from
    the middle were let go.
    """

    cells: NDArray[np.uint8]
    maps: tuple[WriterMap, ...] = ()
    victims: tuple[VictimMark, ...] = ()
    notes: Notes = field(default_factory=Notes)
    passes: tuple[Pass, ...] = ()
    visited: NDArray[np.uint8] = field(default_factory=no_cells)
    phase: int = CENTRED
    reach: int = REACH
    visited_reach: int = VISITED_REACH

    @classmethod
    def empty(cls) -> TagMemory:
        """Return the memory of a new tag."""
        return cls(no_cells())

    @property
    def side(self) -> int:
        """Cells along the window."""
        return len(self.cells)

    @property
    def has_coverage(self) -> bool:
        """Whether somebody told of covered ground, even where it had no room."""
        return self.reach < REACH or bool(self.cells.any())

    @property
    def has_visited(self) -> bool:
        """Whether somebody told where robots drove, even where it had no room."""
        return self.visited_reach < VISITED_REACH or bool(self.visited.any())

    @property
    def frontiers_m(self) -> Array:
        """Open cells, (n, 2), metres north and west of the tag."""
        found: Array = places_of(self.cells == OPEN, self.cell_m) + np.array(self.shift_m)
        return found

    @property
    def visited_m(self) -> Array:
        """Places robots drove through, (n, 2), metres north and west of the tag."""
        return places_of(self.visited > 0, VISITED_M)

    @property
    def cell_m(self) -> float:
        """Side of a cell of coverage."""
        return cell_of(self.phase)

    @property
    def shift_m(self) -> tuple[float, float]:
        """From the tag to the middle of its cell of coverage, metres north and west."""
        return shift_of(self.phase)

    def merge(self, other: TagMemory) -> TagMemory:
        """Return all that both know."""
        said = [each for each in (self, other) if each.has_coverage]
        phase = max((each.phase for each in said), default=CENTRED)
        said = [each for each in said if each.phase == phase]
        reach = min((each.reach for each in said), default=REACH)
        cells = no_cells()
        for each in said:
            cells = joined(cells, each.cells)
        visited_reach = min(self.visited_reach, other.visited_reach)
        return TagMemory(
            within(cells, max(reach, 0)) if reach >= 0 else no_cells(),
            merge_maps(self.maps, other.maps),
            merged_marks(*self.victims, *other.victims),
            self.notes.merge(other.notes),
            merged_marks(*self.passes, *other.passes),
            _kept(joined(self.visited, other.visited), visited_reach),
            phase,
            reach,
            visited_reach,
        )

    def fit(self, room_bytes: int) -> TagMemory:
        """Return as much of it as has room in so many bytes of content."""
        share = Shares.of(room_bytes)
        victims = self.victims[: max(0, victims_in(share.victims))]
        passes = self.passes[: max(0, passes_in(share.passes))]
        notes = self.notes.fit(share.notes) if share.notes >= _LEAST_NOTES else Notes()
        maps = fit_maps(self.maps, share.maps)
        small = replace(self, victims=victims, passes=passes, notes=notes, maps=maps)._fit_visited(share)
        taken = _HEAD + (share.maps if maps else 0) + notes.cost(share.notes)
        taken += len(pack_victims(victims)) if victims else 0
        taken += len(pack_passes(passes)) if passes else 0
        if small.has_visited:
            cut = small.visited_reach < VISITED_REACH
            taken += share.visited if cut else 1 + cost(small.visited, VISITED_REACH)
        if not self.has_coverage:
            return small
        reach = fitting_reach(self.cells, self.reach, room_bytes - taken - WINDOW_HEAD)
        return replace(small, cells=_kept(self.cells, reach), reach=reach)

    def uncut(self) -> TagMemory:
        """Return the same for who has room for all: merging with it lets nothing go."""
        notes = replace(self.notes, gone=None)
        return replace(self, reach=REACH, visited_reach=VISITED_REACH, notes=notes)

    def _fit_visited(self, share: Shares) -> TagMemory:
        if share.visited < _LEAST_VISITED:
            return replace(self, visited=no_cells(), visited_reach=VISITED_REACH)
        reach = fitting_reach(self.visited, self.visited_reach, share.visited - 1)
        return replace(self, visited=_kept(self.visited, reach), visited_reach=reach)

    def _key(self) -> tuple[object, ...]:
        coverage = (self.phase, self.reach, trimmed(self.cells).tobytes()) if self.has_coverage else None
        visited = (self.visited_reach, trimmed(self.visited).tobytes())
        return coverage, visited, self.maps, self.victims, self.notes, self.passes

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, TagMemory):
            return NotImplemented
        return self._key() == other._key()

    def __hash__(self) -> int:
        return hash(self._key())


@dataclass(frozen=True, slots=True)
class Shares:
    """The most bytes that each kind may take of a chip's room; coverage takes what they leave."""

    victims: int
    notes: int
    passes: int
    visited: int
    maps: int

    @classmethod
    def of(cls, room_bytes: int) -> Shares:
        """Return the shares of a room; together they leave a sixth of it to coverage."""
        base = room_bytes
        if room_bytes >= _MAPS_FROM:
            base = _BESIDE_MAPS + (room_bytes - _BESIDE_MAPS) // 8
        base = max(0, base)
        return cls(base // 5, base // 4, base // 7, base // 4, max(0, room_bytes - base))


def shift_of(phase: int) -> tuple[float, float]:
    """Return the way from a tag to the middle of its cell, metres north and west."""
    cell_m = cell_of(phase)
    return (0.5 - (phase & 15) / 16.0) * cell_m, (0.5 - (phase >> 4 & 15) / 16.0) * cell_m


def centred_phase(cell_m: float) -> int:
    """Return the phase of a tag in the middle of a cell of such a side."""
    return phase_of(0.0, 0.0, (-cell_m / 2.0, -cell_m / 2.0), cell_m)


def cell_of(phase: int) -> float:
    """Return the side of the cells of a lattice, metres."""
    return CELLS_M[phase >> 8]


def phase_of(x_m: float, y_m: float, lattice_m: tuple[float, float], cell_m: float = CELLS_M[0]) -> int:
    """Return the phase of a tag at a place on a lattice of which a corner is given, both in one frame.

    Raises:
        ValueError: there are no such cells.
    """
    x, y = (round((a - b) / cell_m % 1.0 * 16) % 16 for a, b in zip((x_m, y_m), lattice_m, strict=True))
    return x | y << 4 | CELLS_M.index(cell_m) << 8


def places_of(held: NDArray[np.bool_], cell_m: float) -> Array:
    """Return the centres of cells of a window, (n, 2), metres north and west of its middle."""
    places: Array = np.argwhere(held).astype(np.float64) - len(held) // 2
    places *= cell_m
    return places


def room_for_maps() -> int:
    """Return the bytes of content from which on a map has room beside all else."""
    return next(room for room in range(_MAPS_FROM, 4096) if Shares.of(room).maps >= least_room())


def _kept(cells: NDArray[np.uint8], reach: int) -> NDArray[np.uint8]:
    return resized(cells, 1) * np.uint8(0) if reach < 0 else within(cells, reach)
