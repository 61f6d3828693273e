"""Ground that the robots of a team have seen, tile by tile, and what of it another one has not got yet.

A tile's newest version by its own robot replaces the older ones, so messages may be lost, come twice or in
any order. Of robots that disagree about a cell the more are believed, and free where they are as many.
"""

from __future__ import annotations

from functools import lru_cache
from math import ceil, cos, floor, sin

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robots.config import MappingConfig
from robots.exploration.team.team_message import LATTICE_CELL_M, MAX_TILE, TILE_CELLS, TILE_M, Patch, Tile
from robots.mapping.fused import FusedGrid
from robots.se2 import Array, Pose2

Key = tuple[int, int]  # row and column of a tile
UNKNOWN, FREE, OCCUPIED = 0, 1, 2
MOST_TILES = 4096  # of one robot: 4 hectares
MOST_IN_ALL = 16_384  # of all the others
_FAR_TILES = 32  # from a robot's start: ground farther away is passed on, not planned over
_SHIFTS = np.array([0, 2, 4, 6], np.uint8)
_OF_STATE = np.array([0, 1, 256, 0], np.int16)  # votes for free in the low byte, for occupied in the high


class TeamGround:
    """The tiles of every robot. ``known``: per robot, the version up to which nothing is missing."""

    def __init__(self) -> None:
        self.known: dict[str, int] = {}
        self._tiles: dict[str, dict[Key, Tile]] = {}
        self._heard = 0  # tiles of others
        self._slots: dict[Key, int] = {}
        self._votes: NDArray[np.int16] = np.zeros((16, TILE_CELLS, TILE_CELLS), np.int16)

    def take(self, patch: Patch) -> bool:
        """Take in what was heard of a robot's ground; what is known already changes nothing.

        Say whether there was room for all of it.
        """
        tiles = self._tiles.setdefault(patch.origin, {})
        left_out = 0
        for tile in patch.tiles:
            key = (tile.row, tile.column)
            old = tiles.get(key)
            if old is None and (len(tiles) >= MOST_TILES or self._heard >= MOST_IN_ALL):
                left_out += 1
            elif old is None or tile.version > old.version:
                self._vote(key, tile.cells, b"" if old is None else old.cells)
                self._heard += old is None
                tiles[key] = tile
        if self.known.get(patch.origin, 0) >= patch.since:
            self.known[patch.origin] = max(self.known.get(patch.origin, 0), patch.until)
        return left_out == 0

    def note(self, robot_id: str, found: dict[Key, bytes]) -> None:
        """Note the ground of this robot itself as it is now: every tile that changed gets a new version."""
        tiles = self._tiles.setdefault(robot_id, {})
        version = self.known.get(robot_id, 0)
        for key, cells in found.items():
            old = tiles.get(key)
            if (any(cells) if old is None else cells != old.cells) and (old or len(tiles) < MOST_TILES):
                version += 1
                tiles[key] = Tile(*key, version, cells)
        self.known[robot_id] = version

    def news(self, robot_id: str, since: int, until: int, room: int) -> Patch | None:
        """Return what changed of a robot's ground after ``since``, at most ``room`` tiles, oldest first.

        None where nothing did.
        """
        until = min(until, self.known.get(robot_id, 0))
        found = [t for t in self._tiles.get(robot_id, {}).values() if since < t.version <= until]
        found.sort(key=lambda tile: tile.version)
        if len(found) > room:
            found = found[:room]
            until = found[-1].version
        return Patch(robot_id, since, until, tuple(found)) if found and room > 0 else None

    def cells(self) -> tuple[NDArray[np.uint8], tuple[float, float]]:
        """Return what the team but for this robot itself knows near the mission frame's origin.

        uint8 (h, w) of UNKNOWN, FREE, OCCUPIED by LATTICE_CELL_M, and its lower left corner in metres.
        """
        index, row, column = self._index((0, 0))
        drawn = np.zeros((index.shape[0], TILE_CELLS, index.shape[1], TILE_CELLS), np.uint8)
        for r, c in np.argwhere(index >= 0):
            votes = self._votes[index[r, c]]
            occupied, free = votes >> 8, votes & 255
            drawn[r, :, c, :] = np.where(occupied > free, OCCUPIED, np.where(free > 0, FREE, UNKNOWN))
        cells = drawn.reshape(index.shape[0] * TILE_CELLS, index.shape[1] * TILE_CELLS)
        return cells, (column * TILE_M, row * TILE_M)

    def overlaid(
        self, fused: FusedGrid, factor: int, mission_from_map: Pose2, config: MappingConfig
    ) -> FusedGrid:
        """Return the map with what others have seen in the cells where it knows nothing itself.

        It grows by whole squares of ``factor`` x ``factor`` cells, the cells of the plan.
        """
        start = (floor(mission_from_map.y / TILE_M), floor(mission_from_map.x / TILE_M))
        index, row, column = self._index(start)
        if index.size == 0:
            return fused
        low = np.array([column, row]) * TILE_M
        high = low + np.array(index.shape[::-1]) * TILE_M
        corners = np.array([low, high, [low[0], high[1]], [high[0], low[1]]])
        in_map = mission_from_map.inverse().transform(corners)
        drawn = fused.covering(in_map.min(axis=0), in_map.max(axis=0), factor)
        _overlay(
            drawn.cells,
            drawn.resolution_m,
            *drawn.origin,
            mission_from_map.x - column * TILE_M,
            mission_from_map.y - row * TILE_M,
            cos(mission_from_map.theta),
            sin(mission_from_map.theta),
            index,
            self._votes,
            config.occupied_logodds,
            config.miss_logodds,
        )
        return drawn

    def _vote(self, key: Key, cells: bytes, before: bytes) -> None:
        slot = self._slots.setdefault(key, len(self._slots))
        if slot == len(self._votes):
            self._votes = np.concatenate([self._votes, np.zeros_like(self._votes)])
        self._votes[slot] += _votes_of(cells)
        if before:
            self._votes[slot] -= _votes_of(before)

    def _index(self, start: Key) -> tuple[NDArray[np.int32], int, int]:
        """Return which slot holds which tile, (h, w), -1 for none, and the row and column of the first."""
        near = [
            (key, slot)
            for key, slot in self._slots.items()
            if max(abs(key[0] - start[0]), abs(key[1] - start[1])) <= _FAR_TILES
        ]
        if not near:
            return np.full((0, 0), -1, np.int32), 0, 0
        keys = np.array([key for key, _ in near])
        corner, end = keys.min(axis=0), keys.max(axis=0) + 1
        index = np.full(end - corner, -1, np.int32)
        index[tuple((keys - corner).T)] = [slot for _, slot in near]
        return index, int(corner[0]), int(corner[1])


@lru_cache(maxsize=512)  # everybody in reach draws the same tiles
def _votes_of(cells: bytes) -> NDArray[np.int16]:
    votes: NDArray[np.int16] = _OF_STATE[unpacked(cells)]
    return votes


def unpacked(cells: bytes) -> NDArray[np.uint8]:
    """Return the states, uint8 (TILE_CELLS, TILE_CELLS), of a tile's bytes."""
    packed = np.frombuffer(cells, np.uint8)
    states = (packed[:, None] >> _SHIFTS) & np.uint8(3)
    return states.astype(np.uint8).reshape(TILE_CELLS, TILE_CELLS)


def tiles_of(
    fused: FusedGrid, mission_from_map: Pose2, centre_m: Array, reach_m: float, config: MappingConfig
) -> dict[Key, bytes]:
    """Return the tiles of a map within reach of a point (x, y), all four in the map frame, by their place."""
    h, w = fused.cells.shape
    r = fused.resolution_m
    low = np.maximum(centre_m - reach_m, fused.origin)
    high = np.minimum(centre_m + reach_m, np.array(fused.origin) + np.array([w, h]) * r)
    if (low >= high).any():
        return {}
    corners = mission_from_map.transform(np.array([low, high, [low[0], high[1]], [high[0], low[1]]]))
    (left, bottom) = (floor(v / TILE_M) for v in corners.min(axis=0))
    (right, top) = (ceil(v / TILE_M) for v in corners.max(axis=0))
    if max(map(abs, (left, bottom, right, top))) > MAX_TILE:
        return {}
    map_from_mission = mission_from_map.inverse()
    states = _states(
        fused.cells,
        r,
        *fused.origin,
        map_from_mission.x,
        map_from_mission.y,
        cos(map_from_mission.theta),
        sin(map_from_mission.theta),
        (top - bottom, right - left),
        bottom,
        left,
        config.occupied_logodds,
        config.miss_logodds,
    )
    four = states.reshape(len(states), -1, 4)
    packed = four[..., 0] | four[..., 1] << 2 | four[..., 2] << 4 | four[..., 3] << 6
    keys = [(row, column) for row in range(bottom, top) for column in range(left, right)]
    return {key: tile.tobytes() for key, tile in zip(keys, packed, strict=True)}


@njit(cache=True)
def _states(
    cells: NDArray[np.int32],
    resolution: float,
    origin_x: float,
    origin_y: float,
    x: float,
    y: float,
    c: float,
    s: float,
    tiles: tuple[int, int],
    first_row: int,
    first_column: int,
    occupied: int,
    free: int,
) -> NDArray[np.uint8]:
    """Look up every cell of the lattice in the map: occupied if anything in it is, else free if anything."""
    factor = max(1, round(LATTICE_CELL_M / resolution))
    states = np.zeros((tiles[0] * tiles[1], TILE_CELLS, TILE_CELLS), np.uint8)
    for k in range(states.shape[0]):
        row0 = (first_row + k // tiles[1]) * TILE_CELLS
        column0 = (first_column + k % tiles[1]) * TILE_CELLS
        for i in range(TILE_CELLS):
            for j in range(TILE_CELLS):
                mx, my = (column0 + j + 0.5) * LATTICE_CELL_M, (row0 + i + 0.5) * LATTICE_CELL_M
                u = floor((c * mx - s * my + x - origin_x) / resolution - 0.5 * factor + 0.5)
                v = floor((s * mx + c * my + y - origin_y) / resolution - 0.5 * factor + 0.5)
                state = 0
                for b in range(v, v + factor):
                    if b < 0 or b >= cells.shape[0]:
                        continue
                    for a in range(u, u + factor):
                        if a < 0 or a >= cells.shape[1]:
                            continue
                        if cells[b, a] >= occupied:
                            state = 2
                        elif cells[b, a] <= -free and state == 0:
                            state = 1
                states[k, i, j] = state
    return states


@njit(cache=True)
def _overlay(
    cells: NDArray[np.int32],
    resolution: float,
    origin_x: float,
    origin_y: float,
    x: float,
    y: float,
    c: float,
    s: float,
    index: NDArray[np.int32],
    votes: NDArray[np.int16],
    occupied: int,
    free: int,
) -> None:
    rows, columns = index.shape[0] * TILE_CELLS, index.shape[1] * TILE_CELLS
    for b in range(cells.shape[0]):
        for a in range(cells.shape[1]):
            if cells[b, a] >= occupied or cells[b, a] <= -free:
                continue
            mx, my = origin_x + (a + 0.5) * resolution, origin_y + (b + 0.5) * resolution
            u = floor((c * mx - s * my + x) / LATTICE_CELL_M)
            v = floor((s * mx + c * my + y) / LATTICE_CELL_M)
            if u < 0 or v < 0 or u >= columns or v >= rows:
                continue
            slot = index[v // TILE_CELLS, u // TILE_CELLS]
            told = 0 if slot < 0 else votes[slot, v % TILE_CELLS, u % TILE_CELLS]
            if told != 0:
                cells[b, a] = occupied if (told >> 8) > (told & 255) else -free
