"""An office floor being drawn: all solid at first, then corridors, rooms and doors are carved out."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from robots.sim.world import Mask

_WALL_M = 0.15
_DOOR_M = (0.9, 1.2)
_ROOM_M = (2.8, 6.5)


@dataclass(frozen=True, slots=True)
class _Box:
    """A rectangle in metres."""

    left: float
    bottom: float
    right: float
    top: float

    @property
    def width(self) -> float:
        return self.right - self.left

    @property
    def height(self) -> float:
        return self.top - self.bottom

    def grown(self, by: float) -> _Box:
        return _Box(self.left - by, self.bottom - by, self.right + by, self.top + by)

    def meets(self, other: _Box) -> bool:
        return (
            self.left < other.right
            and other.left < self.right
            and self.bottom < other.top
            and other.bottom < self.top
        )


class FloorPlan:
    """A floor of ``width`` x ``height`` metres; ``solid`` bool (h, w), row = y up."""

    def __init__(self, width: float, height: float, resolution_m: float, rng: np.random.Generator) -> None:
        self._width, self._height, self._resolution = width, height, resolution_m
        self._rng = rng
        self.solid: Mask = np.ones((round(height / resolution_m), round(width / resolution_m)), dtype=bool)
        self._rooms: list[_Box] = []
        self._doors: list[_Box] = []

    def carve(self, left: float, bottom: float, right: float, top: float) -> None:
        """Make a rectangle free."""
        self._fill(_Box(left, bottom, right, top), False)

    def crossings(self, corridor_m: float) -> list[tuple[float, float]]:
        """Choose where cross corridors run: (left, right) of each, one per 25 m of width."""
        count = max(1, round(self._width / 25.0))
        spots = []
        for k in range(count):
            middle = self._width * (k + float(self._rng.uniform(0.25, 0.75))) / count
            left = min(max(middle - corridor_m / 2.0, 0.0), self._width - corridor_m)
            spots.append((left, left + corridor_m))
        return spots

    def room_row(
        self, crossings: list[tuple[float, float]], bottom: float, top: float, door_at_top: bool
    ) -> None:
        """Divide a strip along a corridor into rooms with doors to it, between the cross corridors."""
        edge = 0.0
        for left, right in [*crossings, (self._width, self._width)]:
            if left - edge > 1.5:
                self._rooms_between(edge, left, bottom, top, door_at_top)
            edge = right

    def _rooms_between(self, left: float, right: float, bottom: float, top: float, door_at_top: bool) -> None:
        count = max(1, round((right - left) / float(self._rng.uniform(*_ROOM_M))))
        shares = self._rng.uniform(0.7, 1.3, count)
        edges = left + (right - left) * np.concatenate([[0.0], np.cumsum(shares) / shares.sum()])
        before: _Box | None = None
        for start, end in itertools.pairwise(edges):
            half = _WALL_M / 2.0
            room = _Box(float(start) + half, bottom + _WALL_M, float(end) - half, top - _WALL_M)
            if room.width < 1.3 or (count > 3 and self._rng.random() < 0.05):
                before = None  # a shaft or a stairwell: stays solid
                continue
            self._fill(room, False)
            self._rooms.append(room)
            self._door_to_corridor(room, bottom, top, door_at_top)
            if before is not None:
                self._towards(before, room)
            before = room

    def _door_to_corridor(self, room: _Box, bottom: float, top: float, door_at_top: bool) -> None:
        low, high = (top - _WALL_M, top) if door_at_top else (bottom, bottom + _WALL_M)
        if self._rng.random() < 0.08:  # a lobby, open to the corridor
            self._open(_Box(room.left + 0.3, low, room.right - 0.3, high))
            return
        for _ in range(2 if room.width > 5.0 else 1):
            wide = float(self._rng.uniform(*_DOOR_M))
            start = float(self._rng.uniform(room.left + 0.1, max(room.left + 0.11, room.right - wide - 0.1)))
            self._open(_Box(start, low, start + wide, high))

    def _towards(self, before: _Box, room: _Box) -> None:
        """Join two neighbours now and then: a door between them, or the wall taken out."""
        chance = float(self._rng.random())
        wide = float(self._rng.uniform(*_DOOR_M))
        start = float(self._rng.uniform(room.bottom + 0.2, max(room.bottom + 0.21, room.top - wide - 0.2)))
        if chance < 0.12:
            self._open(_Box(before.right, room.bottom + 0.2, room.left, room.top - 0.2))
        elif chance < 0.35:
            self._open(_Box(before.right, start, room.left, start + wide))

    def _open(self, box: _Box) -> None:
        self._fill(box, False)
        self._doors.append(box)

    def furnish(self) -> None:
        """Put desks, shelves and cupboards into the rooms, clear of the doors and with a way round each."""
        for room in self._rooms:
            placed: list[_Box] = []
            for _ in range(int(self._rng.poisson(room.width * room.height / 7.0))):
                piece = self._against_a_wall(room) if self._rng.random() < 0.7 else self._in_the_middle(room)
                if piece is None or any(piece.grown(0.75).meets(other) for other in placed):
                    continue
                if any(piece.meets(door.grown(0.9)) for door in self._doors):
                    continue
                self._fill(piece, True)
                placed.append(piece)

    def _against_a_wall(self, room: _Box) -> _Box | None:
        long, deep = float(self._rng.uniform(0.6, 1.8)), float(self._rng.uniform(0.35, 0.8))
        wall, along = int(self._rng.integers(4)), float(self._rng.random())
        if (
            min(room.width, room.height) < deep + 1.0
            or (room.width if wall < 2 else room.height) < long + 1.6
        ):
            return None
        if wall < 2:
            left = room.left + along * (room.width - long)
            bottom = room.bottom if wall == 0 else room.top - deep
            return self._snug(_Box(left, bottom, left + long, bottom + deep), room)
        bottom = room.bottom + along * (room.height - long)
        left = room.left if wall == 2 else room.right - deep
        return self._snug(_Box(left, bottom, left + deep, bottom + long), room)

    def _snug(self, piece: _Box, room: _Box) -> _Box:
        """Close gaps too narrow for a body between a piece and the room's corners."""
        return _Box(
            room.left if piece.left - room.left < 0.8 else piece.left,
            room.bottom if piece.bottom - room.bottom < 0.8 else piece.bottom,
            room.right if room.right - piece.right < 0.8 else piece.right,
            room.top if room.top - piece.top < 0.8 else piece.top,
        )

    def _in_the_middle(self, room: _Box) -> _Box | None:
        wide, high = float(self._rng.uniform(0.7, 1.8)), float(self._rng.uniform(0.7, 1.2))
        if room.width < wide + 2.0 or room.height < high + 2.0:
            return None
        left = float(self._rng.uniform(room.left + 0.95, room.right - wide - 0.95))
        bottom = float(self._rng.uniform(room.bottom + 0.95, room.top - high - 0.95))
        return _Box(left, bottom, left + wide, bottom + high)

    def _fill(self, box: _Box, solid: bool) -> None:
        left, bottom, right, top = (
            max(0, round(value / self._resolution)) for value in (box.left, box.bottom, box.right, box.top)
        )
        self.solid[bottom:top, left:right] = solid
