"""The place a mission happens in: walls, glass, bricks, smoke, slopes and slippery floor on one grid.

Row = y up, column = x; cell (0, 0) is the lower left one, its corner at ``origin_m``. x points north (yaw 0).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

Cells = NDArray[np.uint8]
Mask = NDArray[np.bool_]
FloatGrid = NDArray[np.float32]

WALL = 1  # stops bodies and beams
GLASS = 2  # stops bodies; a laser beam that meets it comes back as a far reading
BRICK = 4  # stops bodies, lies below the laser's plane
SMOKE = 8  # stops nothing but swallows laser beams
SOLID = WALL | GLASS | BRICK

MAX_CELLS = 40_000_000


class WorldError(ValueError):
    """A map cannot be used; the message names the file or field and what to do."""


@dataclass(frozen=True, eq=False)
class World:
    """A frozen plan.

    ``cells`` uint8 (h, w): flags WALL, GLASS, BRICK, SMOKE. ``grip`` float32 (h, w): share of the commanded
    motion the floor gives, None for 1 everywhere. ``slope`` float32 (h, w, 2): gradient of the floor (dz/dx,
    dz/dy), None for flat.
    """

    cells: Cells
    origin_m: tuple[float, float]
    resolution_m: float
    grip: FloatGrid | None = None
    slope: FloatGrid | None = None

    @cached_property
    def free(self) -> Mask:
        """Cells without anything solid in them, bool (h, w)."""
        free: Mask = (self.cells & SOLID) == 0
        return free

    @cached_property
    def distance_cells(self) -> FloatGrid:
        """Distance from each cell's centre to the nearest solid cell's centre, in cells, float32 (h, w)."""
        # a rim of solid cells: what lies outside the plan is solid
        field = ndimage.distance_transform_edt(np.pad(self.free, 1))
        return np.ascontiguousarray(field[1:-1, 1:-1], dtype=np.float32)

    @cached_property
    def clearance_m(self) -> FloatGrid:
        """Distance from each cell's centre to the nearest solid cell's facing edge, metres, (h, w)."""
        clearance: FloatGrid = np.maximum(self.distance_cells - 0.5, 0.0) * self.resolution_m
        return clearance

    def reachable(self, radius_m: float) -> Mask:
        """Return the largest connected set of cells where a disc of this radius fits, bool (h, w).

        Raises:
            WorldError: it fits nowhere.
        """
        labels, count = ndimage.label(self.free & (self.clearance_m >= radius_m))
        if count == 0:
            raise WorldError(
                f"the map has no free space for a robot of radius {radius_m:g} m; use another map"
            )
        sizes = np.bincount(labels.ravel())
        sizes[0] = 0
        mask: Mask = labels == int(sizes.argmax())
        return mask

    @property
    def free_area_m2(self) -> float:
        """Area of the cells without anything solid in them."""
        return float(self.free.sum()) * self.resolution_m**2

    def centre(self, row: int, column: int) -> tuple[float, float]:
        """Return the centre of a cell in world coordinates, metres."""
        return (
            self.origin_m[0] + (column + 0.5) * self.resolution_m,
            self.origin_m[1] + (row + 0.5) * self.resolution_m,
        )

    def cell(self, x_m: float, y_m: float) -> tuple[int, int]:
        """Return (row, column) of the cell a point lies in, clipped to the plan."""
        rows, columns = self.cells.shape
        row = int(np.floor((y_m - self.origin_m[1]) / self.resolution_m))
        column = int(np.floor((x_m - self.origin_m[0]) / self.resolution_m))
        return min(max(row, 0), rows - 1), min(max(column, 0), columns - 1)


def world_of(solid: Mask, resolution_m: float, origin_m: tuple[float, float] = (0.0, 0.0)) -> World:
    """Return a world of walls where ``solid``, bool (h, w); a rim of wall one cell wide is added round it."""
    cells = np.where(np.pad(solid, 1, constant_values=True), WALL, 0).astype(np.uint8)
    resolution_m = float(resolution_m)
    return World(cells, (float(origin_m[0]) - resolution_m, float(origin_m[1]) - resolution_m), resolution_m)
