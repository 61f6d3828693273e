"""Correlative search (Olson 2009): every distinct pose in a window at which two clouds lie on each other.

The target is drawn as a field of likelihood, one layer for each direction its surfaces face, so that a wall
answers only to walls that face the same way. A field of maxima over blocks bounds what a whole block of
translations can reach; only promising blocks are looked into.
"""

from __future__ import annotations

from math import atan2, ceil, cos, exp, floor, hypot, pi, sin

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robots.estimation.scans.cloud_alignment import Surface
from robots.se2 import Array

Field = NDArray[np.float32]  # (layers, rows, columns)
Whole = NDArray[np.int32]

_CELL_M = 0.1
_BLOCK = 4  # cells to a side
_LAYERS = 8
_SPREAD_M = 0.1
_POINTS = 300  # of the source, for the search
_APART_M, _APART_RAD = 0.35, 0.17  # peaks nearer than this are one
_PROMISING = 0.6  # blocks whose bound is below this share of the best score are not looked into


def peaks(
    target: Surface, source: Surface, guess: Array, reach_m: float, turn_rad: float, count: int
) -> list[Array]:
    """Return up to ``count`` poses, each (3,), ``target_from_source``, best first."""
    reach = max(1, ceil(reach_m / _CELL_M))
    margin = (2 * reach + _BLOCK + 4) * _CELL_M
    low = target.points.min(axis=0) - margin
    size = np.ceil((target.points.max(axis=0) + margin - low) / _CELL_M).astype(int)
    field = np.zeros((_LAYERS, size[1], size[0]), np.float32)
    _draw(target.points, target.normals, low, field)
    coarse = _maxima(field)
    points, layers = _sample(source.points, source.normals)
    if not len(points):
        return []
    extent = float(np.percentile(np.hypot(points[:, 0], points[:, 1]), 80))
    step = 1.5 * _CELL_M / max(extent, 1.0)
    turns = ceil(min(turn_rad, pi) / step)
    scored = _search(
        field, coarse, low, points, layers, guess, reach, turns, min(turn_rad, pi) / max(turns, 1)
    )
    order = np.argsort(-scored[:, 3], kind="stable")
    found: list[Array] = []
    for row in scored[order]:
        if row[3] <= 0.0 or len(found) == count:
            break
        if all(
            hypot(row[0] - other[0], row[1] - other[1]) > _APART_M
            or abs((row[2] - other[2] + pi) % (2.0 * pi) - pi) > _APART_RAD
            for other in found
        ):
            found.append(row[:3].copy())
    return found


def _sample(points: Array, normals: Array) -> tuple[Array, Array]:
    """Return about ``_POINTS`` of the points with a normal, (m, 2), and where they face, radians (m,)."""
    known = (normals[:, 0] != 0.0) | (normals[:, 1] != 0.0)
    points, normals = points[known], normals[known]
    stride = max(1, len(points) // _POINTS)
    return (
        np.ascontiguousarray(points[::stride]),
        np.arctan2(normals[::stride, 1], normals[::stride, 0]),
    )


@njit(cache=True)
def _draw(points: Array, normals: Array, low: Array, field: Field) -> None:
    """Draw each point as a bell into the two layers nearest to the direction it faces."""
    reach = 2
    for i in range(points.shape[0]):
        if normals[i, 0] == 0.0 and normals[i, 1] == 0.0:
            continue
        facing = (atan2(normals[i, 1], normals[i, 0]) + pi) / (2.0 * pi) * _LAYERS
        first = floor(facing - 0.5)
        column = floor((points[i, 0] - low[0]) / _CELL_M)
        row = floor((points[i, 1] - low[1]) / _CELL_M)
        for r in range(row - reach, row + reach + 1):
            for c in range(column - reach, column + reach + 1):
                dx = low[0] + (c + 0.5) * _CELL_M - points[i, 0]
                dy = low[1] + (r + 0.5) * _CELL_M - points[i, 1]
                value = exp(-(dx * dx + dy * dy) / (2.0 * _SPREAD_M * _SPREAD_M))
                for layer in (first, first + 1):
                    k = layer % _LAYERS
                    if value > field[k, r, c]:
                        field[k, r, c] = value


@njit(cache=True)
def _maxima(field: Field) -> Field:
    """Return the maximum over the block of cells that begins at each cell, same shape."""
    layers, rows, columns = field.shape
    across = np.zeros_like(field)
    result = np.zeros_like(field)
    for k in range(layers):
        for r in range(rows):
            for c in range(columns - _BLOCK + 1):
                value = field[k, r, c]
                for d in range(1, _BLOCK):
                    value = max(value, field[k, r, c + d])
                across[k, r, c] = value
        for r in range(rows - _BLOCK + 1):
            for c in range(columns):
                value = across[k, r, c]
                for d in range(1, _BLOCK):
                    value = max(value, across[k, r + d, c])
                result[k, r, c] = value
    return result


@njit(cache=True)
def _sum(
    field: Field, layers: Whole, columns: Whole, rows: Whole, count: int, column: int, row: int
) -> float:
    total = 0.0
    h, w = field.shape[1], field.shape[2]
    for i in range(count):
        r, c = rows[i] + row, columns[i] + column
        if 0 <= r < h and 0 <= c < w:
            total += field[layers[i], r, c]
    return total


@njit(cache=True)
def _search(
    field: Field,
    coarse: Field,
    low: Array,
    points: Array,
    facing: Array,
    guess: Array,
    reach: int,
    turns: int,
    step: float,
) -> Array:
    """Return the best translation of every promising block and heading, rows of x, y, theta, score."""
    n = points.shape[0]
    blocks = (2 * reach + 1 + _BLOCK - 1) // _BLOCK
    angles = 2 * turns + 1
    columns = np.empty((angles, n), np.int32)
    rows = np.empty((angles, n), np.int32)
    layers = np.empty((angles, n), np.int32)
    bounds = np.empty(angles * blocks * blocks)
    for a in range(angles):
        theta = guess[2] + (a - turns) * step
        c, s = cos(theta), sin(theta)
        for i in range(n):
            x = guess[0] + c * points[i, 0] - s * points[i, 1]
            y = guess[1] + s * points[i, 0] + c * points[i, 1]
            columns[a, i] = floor((x - low[0]) / _CELL_M) - reach
            rows[a, i] = floor((y - low[1]) / _CELL_M) - reach
            layers[a, i] = floor((facing[i] + theta + pi) / (2.0 * pi) * _LAYERS) % _LAYERS
        for by in range(blocks):
            for bx in range(blocks):
                bounds[(a * blocks + by) * blocks + bx] = _sum(
                    coarse, layers[a], columns[a], rows[a], n, bx * _BLOCK, by * _BLOCK
                )
    order = np.argsort(-bounds, kind="mergesort")
    result = np.zeros((order.size, 4))
    best = 0.0
    kept = 0
    for place in order:
        if bounds[place] < _PROMISING * best:
            break
        bx, by, a = place % blocks, (place // blocks) % blocks, place // (blocks * blocks)
        top, top_x, top_y = -1.0, 0, 0
        for y in range(by * _BLOCK, min((by + 1) * _BLOCK, 2 * reach + 1)):
            for x in range(bx * _BLOCK, min((bx + 1) * _BLOCK, 2 * reach + 1)):
                score = _sum(field, layers[a], columns[a], rows[a], n, x, y)
                if score > top:
                    top, top_x, top_y = score, x, y
        best = max(best, top)
        result[kept, 0] = guess[0] + (top_x - reach) * _CELL_M
        result[kept, 1] = guess[1] + (top_y - reach) * _CELL_M
        result[kept, 2] = guess[2] + (a - turns) * step
        result[kept, 3] = top
        kept += 1
    return result[:kept]
