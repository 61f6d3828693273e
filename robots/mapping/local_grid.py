"""A small occupancy grid that goes along with the robot and forgets what it leaves behind (Ziparo 2007, 5.1).

"Each robot continuously plans paths based on its local information of the environment, which is maintained
within an occupancy grid ... a four meter side square with forty mm resolution. The occupancy grid is shifted
based on the odometry and continuously updated based on new scans."
"""

from __future__ import annotations

from math import floor, hypot
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from robots.config import MappingConfig
from robots.mapping.fused import FusedGrid
from robots.mapping.map_keeper import FELT_RADIUS_M, SEEN_AHEAD_M
from robots.mapping.occupancy import LogOdds, cast_scan, stamp_disc
from robots.planning.following import free_ahead
from robots.se2 import Pose2
from robots.types import LaserScan

_Cell = TypeVar("_Cell", bound=np.generic)

RESOLUTION_M = 0.04
_STEP = 4  # cells by which it moves, and of the ring: coarser grids made of it keep their lattice
_LEAP_M = 0.35  # farther than a robot drives between two scans: the map has moved under it, not the ground


class LocalGrid(FusedGrid):
    """Log-odds (tenths), int32, of a square round the robot, parallel to the map frame.

    A ring of unknown cells lies round the square: the ground does not end where the grid does.
    """

    def __init__(self, side_m: float, config: MappingConfig, radius_m: float) -> None:
        super().__init__(RESOLUTION_M)
        self._side = max(1, round(side_m / RESOLUTION_M))
        self._config = config
        self._body = max(1, floor(radius_m / RESOLUTION_M))
        self._odds: LogOdds = np.zeros((self._side, self._side), np.int16)
        self._touched: NDArray[np.int32] = np.zeros((self._side, self._side), np.int32)
        self._mark = 0
        self._pose: Pose2 | None = None

    def see(self, pose: Pose2, scan: LaserScan) -> None:
        """Move along to a pose in the map frame and write a scan taken there."""
        self._go_along(pose)
        config, corner = self._config, (self._column0 + _STEP, self._row0 + _STEP)
        self._mark += 1
        cast_scan(
            self._odds, self._touched, self._mark, corner[0] * RESOLUTION_M, corner[1] * RESOLUTION_M,
            RESOLUTION_M, pose.x, pose.y, pose.theta, scan.ranges_m, scan.angle_min_rad,
            scan.angle_increment_rad, scan.range_max_m, config.max_range_m, config.hit_logodds,
            config.miss_logodds, config.limit_logodds,
        )  # fmt: skip
        self._renew()

    def add_felt(self, pose: Pose2, radius_m: float, scan: LaserScan) -> None:
        """Mark what a body at a pose felt right ahead as occupied, where the laser sees nothing."""
        if free_ahead(scan, radius_m) < SEEN_AHEAD_M:
            return
        x, y = pose.transform_point(radius_m + FELT_RADIUS_M, 0.0)
        row, column = (floor(v / RESOLUTION_M) - c - _STEP for v, c in ((y, self._row0), (x, self._column0)))
        radius = round(FELT_RADIUS_M / RESOLUTION_M)
        stamp_disc(self._odds, self._touched, row, column, radius, self._config.limit_logodds)
        self._renew()

    def _renew(self) -> None:
        self.cells = np.pad(self._odds, _STEP).astype(np.int32)
        self.changes.note(0, 0, *self.cells.shape)

    def _go_along(self, pose: Pose2) -> None:
        """Put the robot in the middle; what leaves the square is forgotten."""
        row, column = (
            floor(middle / RESOLUTION_M / _STEP) * _STEP - self._side // 2 - _STEP // 2
            for middle in (pose.y, pose.x)
        )
        last, self._pose = self._pose, pose
        if last is None:
            self._row0, self._column0 = row, column
            self._stand_free()
        elif hypot(pose.x - last.x, pose.y - last.y) > _LEAP_M:
            self._row0, self._column0 = row, column  # what is round the robot stays round it
        else:
            by = row - self._row0, column - self._column0
            self._odds, self._touched = _shifted(self._odds, *by), _shifted(self._touched, *by)
            self._row0, self._column0 = row, column

    def _stand_free(self) -> None:
        """Write that the robot's own place is free."""
        middle = slice(self._side // 2 - self._body, self._side // 2 + self._body + 1)
        self._odds[middle, middle] = -self._config.hit_logodds


def _shifted(cells: NDArray[_Cell], rows: int, columns: int) -> NDArray[_Cell]:
    """Return the square moved by so many cells over the ground, with 0 where it comes to new ground."""
    if rows == columns == 0:
        return cells
    side = len(cells)
    moved = np.zeros_like(cells)
    if abs(rows) < side and abs(columns) < side:
        moved[max(0, -rows) : side - max(0, rows), max(0, -columns) : side - max(0, columns)] = cells[
            max(0, rows) : side - max(0, -rows), max(0, columns) : side - max(0, -columns)
        ]
    return moved
