"""How well each cell of a grid fits what is heard of nodes; see ``locating.py`` for the model."""

from __future__ import annotations

from math import hypot, log

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robots.estimation.radio.model import NEAREST_M
from robots.estimation.radio.walls import UNSEEN, count_walls
from robots.se2 import Array

CELLS = 48  # a side
_UNKNOWN, _FREE, _WALL = 0, 1, 2
_UNKNOWN_COST = 6.0  # -2 ln 0.05: of twenty who walk, one is where nobody has looked
_WALL_COST = 8.0  # -2 ln 0.02
_MOST_WALLS = 8
_NARROW = 0.1  # of the reach: so it ends
_APART_M = 0.25  # nobody fits between: two faces of one wall, or one face drawn twice
_WALL_VARIANCE = 0.25  # of what a wall takes, in squares of what it should: its matter, and miscounted ones
_HIDDEN = 0.5  # walls that the map lacks, or holds too much


@njit(cache=True)
def costs_on(
    rows: Array,
    box: Array,
    shared: tuple[float, float, float, float],
    shadows: Array,
    since: tuple[float, float, float, float],
    classes: NDArray[np.uint8],
    origin: tuple[float, float, float],
    is_whole: bool,
) -> Array:
    """Return -2 ln of the probability of the cells (48, 48) but for a constant; row 0 at the lowest y.

    ``rows`` (k, 6): place, its deviation, range, deviations of its logarithm and in metres. ``box``: lowest x
    and y, size of a cell. ``shared``: deviation of the gain and loss of a wall, in ln d; reach; deviation of
    the exponent, as a share of it. ``shadows`` (2, n): distances, and deviations of ln d there. ``since``:
    place, deviation, farthest way (negative: none). ``origin``: of the plan, and its resolution (0: none).
    Errors are widened by half a cell. Not ``is_whole``: of the first cell, what the readings alone
    cost, as chi-square.
    """
    found = np.empty((CELLS, CELLS) if is_whole else (1, 1))
    walls = (classes == _WALL) * np.uint8(1) + (classes == _UNKNOWN) * np.uint8(UNSEEN)
    half_x, half_y = box[2] / 2.0, box[3] / 2.0  # less, and thin rings fall between cells
    for i in range(found.shape[0]):
        for j in range(found.shape[1]):
            x, y = box[0] + (j + 0.5) * box[2], box[1] + (i + 0.5) * box[3]
            cost, details = _reading_cost(rows, x, y, half_x, half_y, shared, shadows, walls, origin)
            if is_whole:
                cost += details
                if origin[2] > 0.0:
                    cost += _plan_cost(classes, origin, x, y)
                if since[3] >= 0.0:
                    over = max(0.0, hypot(x - since[0], y - since[1]) - since[3])
                    cost += over * over / (since[2] * since[2] + half_x * half_x + half_y * half_y)
            found[i, j] = cost
    return found


@njit(cache=True)
def _reading_cost(
    rows: Array,
    x: float,
    y: float,
    half_x: float,
    half_y: float,
    shared: tuple[float, float, float, float],
    shadows: Array,
    walls: NDArray[np.uint8],
    origin: tuple[float, float, float],
) -> tuple[float, float]:
    """Return chi-square of the readings at a place, and what their densities add to it."""
    gain_sd, wall, reach, exponent_sd = shared
    cost = details = 0.0
    gg, gn, nn, ge, ne = 1.0, 0.0, 1.0, 0.0, 0.0  # information of gain and exponent, each in its deviations
    for k in range(rows.shape[0]):
        dx, dy = x - rows[k, 0], y - rows[k, 1]
        far = max(hypot(dx, dy), NEAREST_M)
        blur = ((dx * half_x) ** 2 + (dy * half_y) ** 2) / (far * far)
        placed = rows[k, 2] * rows[k, 2] + blur
        if rows[k, 4] > 0.0:
            error = log(rows[k, 3] / far)
            shadow = _shadow(far, shadows)
            variance = rows[k, 4] * rows[k, 4] + shadow * shadow + placed / (far * far + blur)
            if origin[2] > 0.0 and wall > 0.0:
                count = _walls_between(walls, origin, x, y, rows[k, 0], rows[k, 1])
                error -= wall * count
                variance += _WALL_VARIANCE * wall * wall * (count + _HIDDEN)
            beyond = max(0.0, far / reach - 1.0) / _NARROW
            details += beyond * beyond
            by_gain, by_exponent = gain_sd, exponent_sd * log(far)
            gg += by_gain * by_gain / variance
            gn += by_gain * by_exponent / variance
            nn += by_exponent * by_exponent / variance
            ge += by_gain * error / variance
            ne += by_exponent * error / variance
        else:
            error = rows[k, 3] - far
            variance = rows[k, 5] * rows[k, 5] + placed
        cost += error * error / variance
        details += log(variance)
    determinant = gg * nn - gn * gn
    cost -= (nn * ge * ge - 2.0 * gn * ge * ne + gg * ne * ne) / determinant
    return cost, details + log(determinant)


@njit(cache=True)
def _shadow(far: float, shadows: Array) -> float:
    """Return the deviation of the shadowing at a distance, constant beyond the ends of the table."""
    last = shadows.shape[1] - 1
    if far <= shadows[0, 0]:
        return float(shadows[1, 0])
    for k in range(1, last + 1):
        if far <= shadows[0, k]:
            share = (far - shadows[0, k - 1]) / (shadows[0, k] - shadows[0, k - 1])
            return float(shadows[1, k - 1] + share * (shadows[1, k] - shadows[1, k - 1]))
    return float(shadows[1, last])


@njit(cache=True)
def _walls_between(
    walls: NDArray[np.uint8], origin: tuple[float, float, float], x: float, y: float, to_x: float, to_y: float
) -> int:
    """Return how many walls stand between a node and who hears it."""
    count: int = count_walls(
        walls,
        (to_x - origin[0]) / origin[2],
        (to_y - origin[1]) / origin[2],
        (x - origin[0]) / origin[2],
        (y - origin[1]) / origin[2],
        _MOST_WALLS,
        _APART_M / origin[2],
    )
    return count


@njit(cache=True)
def _plan_cost(classes: NDArray[np.uint8], origin: tuple[float, float, float], x: float, y: float) -> float:
    column, row = int(np.floor((x - origin[0]) / origin[2])), int(np.floor((y - origin[1]) / origin[2]))
    if row < 0 or column < 0 or row >= classes.shape[0] or column >= classes.shape[1]:
        return _UNKNOWN_COST
    kind = classes[row, column]
    return 0.0 if kind == _FREE else _WALL_COST if kind == _WALL else _UNKNOWN_COST
