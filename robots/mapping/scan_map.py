"""A map for poses that are never revised: scans go straight into one grid over a place of known size."""

from __future__ import annotations

from math import ceil, floor

import numpy as np
from numpy.typing import NDArray

from robots.config import MappingConfig
from robots.mapping.fused import FusedGrid
from robots.mapping.occupancy import cast_scan, proved, stamp_disc
from robots.se2 import Array, Pose2
from robots.types import LaserScan


class ScanMap(FusedGrid):
    """Log-odds of one grid, from ``low_m`` to ``high_m`` (x, y) in the map frame."""

    def __init__(
        self, config: MappingConfig, low_m: tuple[float, float], high_m: tuple[float, float]
    ) -> None:
        super().__init__(config.resolution_m)
        r = config.resolution_m
        self._config = config
        self._column0, self._row0 = floor(low_m[0] / r), floor(low_m[1] / r)
        shape = ceil(high_m[1] / r) - self._row0, ceil(high_m[0] / r) - self._column0
        self.cells = np.zeros(shape, np.int32)
        self._touched: NDArray[np.int32] = np.zeros(shape, np.int32)
        self._mark = np.zeros(1, np.int32)
        self._frame_m = (0.0, 0.0)

    @property
    def origin(self) -> tuple[float, float]:
        """Lower left corner (x, y) of cell (0, 0) in metres."""
        x, y = super().origin
        return x - self._frame_m[0], y - self._frame_m[1]

    def unsure(self, free_logodds: int) -> NDArray[np.bool_]:
        """Return the free cells, (h, w), that no beam crossed that came back."""
        found: NDArray[np.bool_] = (self.cells <= -free_logodds) & ~proved(self._touched)
        return found

    def seen_from(self, x_m: float, y_m: float) -> ScanMap:
        """Return this map, cells and all, in a frame whose origin lies at (x, y) in this one's."""
        other = ScanMap.__new__(ScanMap)
        other.__dict__.update(self.__dict__)
        other.shared = True
        other._frame_m = self._frame_m[0] + x_m, self._frame_m[1] + y_m
        return other

    def covering(self, low_m: Array, high_m: Array, factor: int) -> FusedGrid:
        """Return a copy in the same frame that reaches over a box with corners (x, y) too."""
        other = ScanMap.__new__(ScanMap)
        larger = super().covering(low_m, high_m, factor)
        other.__dict__.update(self.__dict__ | larger.__dict__)
        below, left = self._row0 - larger._row0, self._column0 - larger._column0
        rows, columns = self.cells.shape
        other._touched = np.zeros(larger.cells.shape, np.int32)
        other._touched[below : below + rows, left : left + columns] = self._touched
        return other

    def add_scan(self, map_from_base: Pose2, scan: LaserScan) -> None:
        """Write a scan taken at a pose."""
        config = self._config
        self._mark[0] += 1
        x, y = self.origin
        cast_scan(
            self.cells, self._touched, int(self._mark[0]), x, y, config.resolution_m,
            map_from_base.x, map_from_base.y, map_from_base.theta,
            scan.ranges_m, scan.angle_min_rad, scan.angle_increment_rad, scan.range_max_m,
            config.max_range_m, config.hit_logodds, config.miss_logodds, config.limit_logodds,
        )  # fmt: skip
        self._note(map_from_base.x, map_from_base.y, min(config.max_range_m, scan.range_max_m))

    def add_free(self, map_from_base: Pose2, radius_m: float) -> None:
        """Write that the ground under a robot's body is free."""
        r = self._config.resolution_m
        x, y = self.origin
        row, column = floor((map_from_base.y - y) / r), floor((map_from_base.x - x) / r)
        steps = int(radius_m / r)
        patch = self.cells[max(0, row - steps) : row + steps + 1, max(0, column - steps) : column + steps + 1]
        np.minimum(patch, -self._config.hit_logodds, out=patch)
        self._note(map_from_base.x, map_from_base.y, radius_m)

    def add_obstacle(self, x_m: float, y_m: float, radius_m: float) -> None:
        """Write an obstacle that was felt, a disc."""
        r = self._config.resolution_m
        x, y = self.origin
        row, column = floor((y_m - y) / r), floor((x_m - x) / r)
        stamp_disc(self.cells, self._touched, row, column, round(radius_m / r), self._config.limit_logodds)
        self._note(x_m, y_m, radius_m)

    def _note(self, x_m: float, y_m: float, reach_m: float) -> None:
        r = self._config.resolution_m
        x, y = self.origin
        rows, columns = self.cells.shape
        self.changes.note(
            min(rows, max(0, floor((y_m - reach_m - y) / r) - 1)),
            min(columns, max(0, floor((x_m - reach_m - x) / r) - 1)),
            max(0, min(rows, floor((y_m + reach_m - y) / r) + 2)),
            max(0, min(columns, floor((x_m + reach_m - x) / r) + 2)),
        )
