"""A submap's surfaces as points with normals, as laser matching takes them."""

from __future__ import annotations

from math import hypot, sqrt

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robots.se2 import Array
from robots.types import SubmapReport

_REACH = 3  # cells to each side that may share a cell's surface
_OCCUPIED, _FREE = 7, -4  # log-odds in tenths
_FLAT = 0.35  # a surface scatters across itself by no more than this share of its scatter along itself


def surface_points(report: SubmapReport, cells: NDArray[np.int8]) -> tuple[Array, Array]:
    """Return points and normals, each (n, 2), of a submap's occupied cells in its anchor's frame.

    ``cells`` (h, w) as ``unpack`` gives them. Points are drawn onto the line through their neighbours;
    normals are unit, towards the free side, zero where there is no clear one.
    """
    points, normals = _surfaces(np.ascontiguousarray(cells))
    turned = report.anchor_from_grid
    c, s = np.cos(turned.theta), np.sin(turned.theta)
    return (
        turned.transform((points + 0.5) * report.resolution_m),
        normals @ np.array([[c, s], [-s, c]]),
    )


@njit(cache=True)
def _surfaces(cells: NDArray[np.int8]) -> tuple[Array, Array]:
    """Return points in cells (column, row) and their normals."""
    height, width = cells.shape
    count = 0
    for row in range(height):
        for column in range(width):
            count += cells[row, column] >= _OCCUPIED
    points, normals = np.empty((count, 2)), np.zeros((count, 2))
    k = 0
    for row in range(height):
        for column in range(width):
            if cells[row, column] < _OCCUPIED:
                continue
            points[k, 0], points[k, 1] = column, row
            m, mx, my, sxx, sxy, syy, fx, fy = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
            for y in range(max(0, row - _REACH), min(height, row + _REACH + 1)):
                for x in range(max(0, column - _REACH), min(width, column + _REACH + 1)):
                    dx, dy = float(x - column), float(y - row)
                    value = float(cells[y, x])
                    if value >= _OCCUPIED:
                        m += value
                        mx, my = mx + value * dx, my + value * dy
                        sxx, sxy, syy = sxx + value * dx * dx, sxy + value * dx * dy, syy + value * dy * dy
                    elif value <= _FREE:
                        fx, fy = fx + dx, fy + dy
            mx, my = mx / m, my / m
            cxx, cxy, cyy = sxx / m - mx * mx, sxy / m - mx * my, syy / m - my * my
            mean, diff = (cxx + cyy) / 2.0, (cxx - cyy) / 2.0
            root = sqrt(diff * diff + cxy * cxy)
            small, large = max(0.0, mean - root), mean + root
            if large > 0.5 and small < _FLAT * large:
                nx, ny = cxy, small - cxx  # eigenvector of the small eigenvalue
                if abs(nx) + abs(ny) < 1e-9:
                    nx, ny = (1.0, 0.0) if cxx < cyy else (0.0, 1.0)
                size = hypot(nx, ny)
                nx, ny = nx / size, ny / size
                towards = nx * fx + ny * fy
                if towards < 0.0:
                    nx, ny = -nx, -ny
                if abs(towards) > 1.0:
                    normals[k, 0], normals[k, 1] = nx, ny
                beside = nx * mx + ny * my  # onto the line
                points[k, 0] += nx * beside
                points[k, 1] += ny * beside
            k += 1
    return points, normals
