"""A submap: the occupancy a robot saw between two anchors, in a grid that is fixed to the first of them."""

from __future__ import annotations

import zlib
from math import floor

import numpy as np
from numpy.typing import NDArray

from robots.config import MappingConfig
from robots.mapping.occupancy import LogOdds, cast_scan, stamp_disc
from robots.se2 import Pose2
from robots.types import LaserScan, SubmapReport

_CHUNK = 64  # cells by which a grid grows


class Submap:
    """Log-odds (tenths) in a grid frame whose axes are parallel to the map's at the time of creation.

    ``anchor_from_grid`` places the grid's frame in the anchor's; cell (0, 0) has its lower left corner at
    (``origin_x``, ``origin_y``).
    """

    def __init__(self, anchor: int, map_from_anchor: Pose2, config: MappingConfig) -> None:
        self.anchor = anchor
        self.version = 0
        self._config = config
        # turned back by the anchor's heading, so that drawing it into the map needs next to no resampling
        self.anchor_from_grid = Pose2(0.0, 0.0, -map_from_anchor.theta)
        self.origin_x = 0.0
        self.origin_y = 0.0
        self.cells: LogOdds = np.zeros((0, 0), np.int16)
        self.touched: NDArray[np.int32] = np.zeros((0, 0), np.int32)  # see ``cast_scan``
        self._mark = 0

    def add_scan(self, anchor_from_base: Pose2, scan: LaserScan) -> None:
        """Add a scan taken at a pose in the anchor's frame."""
        config = self._config
        base = self.anchor_from_grid.between(anchor_from_base)
        limit = config.max_range_m
        self._cover(base.x, base.y, min(limit, scan.range_max_m) + config.resolution_m)
        self._mark += 1
        self.version += 1
        cast_scan(
            self.cells, self.touched, self._mark, self.origin_x, self.origin_y, config.resolution_m,
            base.x, base.y, base.theta, scan.ranges_m, scan.angle_min_rad, scan.angle_increment_rad,
            scan.range_max_m, limit, config.hit_logodds, config.miss_logodds, config.limit_logodds,
        )  # fmt: skip

    def add_free(self, anchor_from_base: Pose2, radius_m: float) -> None:
        """Mark the ground under the robot's body as free: it stands there."""
        config = self._config
        base = self.anchor_from_grid.between(anchor_from_base)
        self._cover(base.x, base.y, radius_m + config.resolution_m)
        steps = int(radius_m / config.resolution_m)
        row = floor((base.y - self.origin_y) / config.resolution_m)
        column = floor((base.x - self.origin_x) / config.resolution_m)
        patch = self.cells[row - steps : row + steps + 1, column - steps : column + steps + 1]
        np.minimum(patch, -config.hit_logodds, out=patch)
        self.version += 1

    def add_obstacle(self, anchor_from_point: Pose2, radius_m: float) -> None:
        """Mark a disc as occupied: the robot pressed against something its laser does not see."""
        config = self._config
        point = self.anchor_from_grid.between(anchor_from_point)
        self._cover(point.x, point.y, radius_m + config.resolution_m)
        row = floor((point.y - self.origin_y) / config.resolution_m)
        column = floor((point.x - self.origin_x) / config.resolution_m)
        radius = round(radius_m / config.resolution_m)
        stamp_disc(self.cells, self.touched, row, column, radius, config.limit_logodds)
        self.version += 1

    def report(self) -> SubmapReport:
        """Return the grid as it leaves the process, cut to what is known."""
        rows, columns = np.nonzero(self.cells)
        if len(rows) == 0:
            cut, low, left = self.cells[:0, :0], 0, 0
        else:
            low, left = int(rows.min()), int(columns.min())
            cut = self.cells[low : int(rows.max()) + 1, left : int(columns.max()) + 1]
        resolution = self._config.resolution_m
        grid_from_cut = Pose2(self.origin_x + left * resolution, self.origin_y + low * resolution)
        return SubmapReport(
            anchor=self.anchor,
            version=self.version,
            anchor_from_grid=self.anchor_from_grid @ grid_from_cut,
            resolution_m=resolution,
            width=cut.shape[1],
            height=cut.shape[0],
            cells=zlib.compress(cut.astype(np.int8).tobytes(), 1),
        )

    def _cover(self, x: float, y: float, reach: float) -> None:
        """Grow the grid until it holds everything within ``reach`` metres of a point in the grid's frame."""
        resolution = self._config.resolution_m
        chunk = _CHUNK * resolution
        left = floor((x - reach) / chunk) * chunk
        low = floor((y - reach) / chunk) * chunk
        right = (floor((x + reach) / chunk) + 1) * chunk
        high = (floor((y + reach) / chunk) + 1) * chunk
        rows, columns = self.cells.shape
        if rows:
            left, low = min(left, self.origin_x), min(low, self.origin_y)
            right = max(right, self.origin_x + columns * resolution)
            high = max(high, self.origin_y + rows * resolution)
        shape = (round((high - low) / resolution), round((right - left) / resolution))
        if shape == self.cells.shape:
            return
        cells: LogOdds = np.zeros(shape, np.int16)
        touched = np.zeros(shape, np.int32)
        if rows:
            r = round((self.origin_y - low) / resolution)
            c = round((self.origin_x - left) / resolution)
            cells[r : r + rows, c : c + columns] = self.cells
            touched[r : r + rows, c : c + columns] = self.touched
        self.cells, self.touched, self.origin_x, self.origin_y = cells, touched, left, low


def unpack(report: SubmapReport) -> NDArray[np.int8]:
    """Return the cells of a report, int8 (height, width).

    Raises:
        ValueError: the bytes do not hold as many cells as the report says.
    """
    try:
        data = zlib.decompress(report.cells)
    except zlib.error as error:
        raise ValueError(f"submap {report.anchor}: damaged cells ({error})") from error
    if len(data) != report.width * report.height:
        raise ValueError(
            f"submap {report.anchor}: {len(data)} cells, expected {report.width} x {report.height}"
        )
    return np.frombuffer(data, np.int8).reshape(report.height, report.width)
