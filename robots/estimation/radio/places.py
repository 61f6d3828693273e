"""The places that a probability leaves: drawn finer and finer where it is, told apart where a gap is.

Only cells far below the best are left out: what walls cut off, or a narrow peak beside a wide one, keeps its
share. Pieces are two places where their ellipses of 2.5 deviations do not touch, else one wide one. The
phone has the same in ``web/static/phone/places.js``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations
from math import atan2, cos, hypot, sin, sqrt

import numpy as np
from numpy.typing import NDArray

from robots.estimation.radio.likelihood import CELLS
from robots.se2 import Array

_KEPT, _CORE = 18.4, 4.0  # -2 ln of 1e-4 of the most probable cell, and of its surroundings
_ENOUGH = 100  # cells in these are fine enough
_SHRUNK = 0.5  # of the ground: while so much falls away, it is cut and not halved
_ROUNDS, _TILES = 14, 16
_HALVINGS, _BINS = 3, 48
_APART_SD = 2.5  # nearer pieces are one: half a ring and its other half are 2.1 apart
_LEAST_SHARE = 0.03
_HOLLOW = 0.1  # of the most probable cell: a middle that is less is no place

_Outline = tuple[int, int, int, int]


@dataclass(frozen=True, slots=True)
class Place:
    """One place that fits: mean, covariance (m2) and share; ``is_hollow``: its very middle does not fit."""

    x_m: float
    y_m: float
    var_x: float
    var_xy: float
    var_y: float
    share: float
    is_hollow: bool


def drawn(costs_of: Callable[[Array], Array], box: Array) -> Array:
    """Return the cells (n, 5) that are left of a box: middle, size along x and y, cost.

    ``costs_of`` a box (lowest x and y, size of a cell along both) draws -2 ln of a density, (CELLS, CELLS).
    """
    tiles = [(box, costs_of(box))]
    for _ in range(_ROUNDS):
        least = min(float(costs.min()) for _, costs in tiles)
        if sum(int((costs < least + _CORE).sum()) for _, costs in tiles) >= _ENOUGH:
            break
        finer = [cut for tile in tiles for cut in _cuts(*tile, least, CELLS)]
        if _ground(finer) > _SHRUNK * _ground([own for own, _ in tiles]):
            finer = [cut for tile in tiles for cut in _cuts(*tile, least, CELLS // 2)]
        if len(finer) > _TILES:
            break
        tiles = [(cut, costs_of(cut)) for cut in finer]
    least = min(float(costs.min()) for _, costs in tiles)
    return np.concatenate([_cells(own, costs, least) for own, costs in tiles])


def places_of(cells: Array) -> tuple[Place, ...]:
    """Return the places of cells (n, 5) as ``drawn``, the most probable first.

    What has no real share is none.
    """
    groups = [cells]
    for _ in range(_HALVINGS):
        groups = [half for group in groups for half in _halves(group)]
    while len(groups) > 1:
        gap, i, j = min((_gap(groups[i], groups[j]), i, j) for i, j in combinations(range(len(groups)), 2))
        if gap >= 1.0:
            break
        groups[i] = np.concatenate([groups[i], groups.pop(j)])
    masses = [float(_masses(group, cells).sum()) for group in groups]
    places = [_place(group, mass / sum(masses)) for group, mass in zip(groups, masses, strict=True)]
    kept = [place for place in places if place.share >= _LEAST_SHARE]
    return tuple(sorted(kept, key=lambda place: -place.share))


def _ground(boxes: list[Array]) -> float:
    return sum(float(box[2] * box[3]) for box in boxes)


def _cuts(box: Array, costs: Array, least: float, side: int) -> list[Array]:
    """Return the boxes of what is left in each square of so many cells a side, a quarter more about it."""
    cuts = []
    for row in range(0, CELLS, side):
        for column in range(0, CELLS, side):
            kept = costs[row : row + side, column : column + side] < least + _KEPT
            if kept.any():
                top, bottom, left, right = _outline(kept)
                low_x, size_x = box[0] + (column + left) * box[2], (right - left) * box[2] / CELLS
                low_y, size_y = box[1] + (row + top) * box[3], (bottom - top) * box[3] / CELLS
                cuts.append(np.array([low_x, low_y, size_x, size_y]))
    return cuts


def _outline(kept: NDArray[np.bool_]) -> _Outline:
    """Return the first row and column of cells (n, n) that are kept, and those after the last."""
    rows, columns = np.nonzero(kept)
    top, bottom, left, right = int(rows.min()), int(rows.max()), int(columns.min()), int(columns.max())
    above, aside = 1 + (bottom - top) // 4, 1 + (right - left) // 4
    most = len(kept)
    return (
        max(0, top - above),
        min(most, bottom + above + 1),
        max(0, left - aside),
        min(most, right + aside + 1),
    )


def _cells(box: Array, costs: Array, least: float) -> Array:
    rows, columns = np.nonzero(costs < least + _KEPT)
    size = np.broadcast_to(box[2:], (len(rows), 2))
    middles = box[:2] + (np.column_stack([columns, rows]) + 0.5) * size
    return np.column_stack([middles, size, costs[rows, columns]])


def _masses(cells: Array, among: Array) -> Array:
    """Return the probability of each cell, as a share of that density of the best ``among`` them in m2."""
    masses: Array = np.exp(-0.5 * (cells[:, 4] - among[:, 4].min())) * cells[:, 2] * cells[:, 3]
    return masses


def _moments(cells: Array) -> tuple[float, float, float, float, float]:
    """Return mean and covariance (xx, xy, yy) of cells."""
    masses = _masses(cells, cells)
    masses /= masses.sum()
    x, y = float(masses @ cells[:, 0]), float(masses @ cells[:, 1])
    off_x, off_y = cells[:, 0] - x, cells[:, 1] - y
    var_x = float(masses @ (off_x**2 + cells[:, 2] ** 2 / 12.0))
    var_y = float(masses @ (off_y**2 + cells[:, 3] ** 2 / 12.0))
    return x, y, var_x, float(masses @ (off_x * off_y)), var_y


def _halves(cells: Array) -> list[Array]:
    """Return both sides of where cells fall apart best along their longest axis (Otsu 1979)."""
    x, y, var_x, var_xy, var_y = _moments(cells)
    angle = 0.5 * atan2(2.0 * var_xy, var_x - var_y)
    along = (cells[:, 0] - x) * cos(angle) + (cells[:, 1] - y) * sin(angle)
    low, high = float(along.min()), float(along.max())
    if high - low <= 0.0:
        return [cells]
    bins = np.minimum(((along - low) / (high - low) * _BINS).astype(np.int64), _BINS - 1)
    masses = _masses(cells, cells)
    mass = np.cumsum(np.bincount(bins, masses, _BINS))
    sums = np.cumsum(np.bincount(bins, masses * along, _BINS))
    left, right = mass[:-1], mass[-1] - mass[:-1]
    with np.errstate(divide="ignore", invalid="ignore"):
        apart = left * right * (sums[:-1] / left - (sums[-1] - sums[:-1]) / right) ** 2
    after = bins > int(np.nanargmax(apart))
    return [cells[~after], cells[after]]


def _gap(one: Array, other: Array) -> float:
    """Return how far apart two pieces are, as a share of what makes them two."""
    x, y, *spread = _moments(one)
    to_x, to_y, *to_spread = _moments(other)
    far = hypot(to_x - x, to_y - y)
    if far == 0.0:
        return 0.0
    u, v = (to_x - x) / far, (to_y - y) / far
    sds = [sqrt(u * u * xx + 2.0 * u * v * xy + v * v * yy) for xx, xy, yy in (spread, to_spread)]
    return far / (_APART_SD * sum(sds))


def _place(cells: Array, share: float) -> Place:
    x, y, var_x, var_xy, var_y = _moments(cells)
    off = np.abs(cells[:, :2] - (x, y)) / cells[:, 2:4]
    nearest = int(np.argmin(off.max(axis=1)))
    density = float(np.exp(-0.5 * (cells[nearest, 4] - cells[:, 4].min())))
    is_hollow = bool(off[nearest].max() > 1.0 or density < _HOLLOW)
    return Place(x, y, var_x, var_xy, var_y, share, is_hollow)
