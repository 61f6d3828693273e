"""Covariances of all vertices of a solved graph at once: the diagonal blocks of the inverse.

Takahashi, Fagan and Chin 1973, by the panels of the factor: where the factor has entries the inverse follows
from the factor and from the inverse further up, so all of it costs about as much as factorising once more.
Tested against dense algebra.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from robots.estimation.graph.order import Order
from robots.graph_report import IntArray
from robots.se2 import Array

_ANY_ORDER = {"reassoc", "contract"}  # sums may be taken in any order, so that they fit vector registers


@njit(cache=True)
def diagonal_blocks(order: Order, factor: Array) -> Array:
    """Return the blocks (n, 3, 3) of the inverse that belong to the vertices, from the factor L of L L'."""
    panels = len(order.first) - 1
    parent, start = _parents(order), np.zeros(panels + 1, np.int64)
    for s in range(panels):
        width, count = order.first[s + 1] - order.first[s], order.row_start[s + 1] - order.row_start[s]
        start[s + 1] = start[s] + 9 * (width + count) ** 2
    inverse = np.empty(start[-1])  # of each panel, at its own places and those below: dense, symmetric
    at = np.empty(len(order.vertex), np.int64)  # where each place stands in the parent's
    found = np.empty((len(order.vertex), 3, 3))
    for s in range(panels - 1, -1, -1):
        low, high = order.row_start[s], order.row_start[s + 1]
        width, rest = 3 * (order.first[s + 1] - order.first[s]), 3 * (high - low)
        size = width + rest
        mine = inverse[start[s] : start[s + 1]].reshape(size, size)
        if rest:
            _gather(order, parent[s], inverse[start[parent[s]] : start[parent[s] + 1]], at, s, mine, width)
        lower = factor[order.panel_start[s] : order.panel_start[s] + width * size].reshape(width, size)
        _invert(lower, mine, width, size)
        for p in range(order.first[s], order.first[s + 1]):
            c = 3 * (p - order.first[s])
            found[order.vertex[p]] = mine[c : c + 3, c : c + 3]
    return found


@njit(cache=True)
def _parents(order: Order) -> IntArray:
    """Return which panel each hangs on (s,): the one of its first row; -1 for a root."""
    panels = len(order.first) - 1
    panel_of = np.empty(len(order.vertex), np.int64)
    for s in range(panels):
        panel_of[order.first[s] : order.first[s + 1]] = s
    parent = np.full(panels, -1, np.int64)
    for s in range(panels):
        if order.row_start[s + 1] > order.row_start[s]:
            parent[s] = panel_of[order.rows[order.row_start[s]]]
    return parent


@njit(cache=True)
def _gather(order: Order, above: int, theirs: Array, at: IntArray, s: int, mine: Array, width: int) -> None:
    """Copy the inverse at the rows below panel s from the panel above it, where all of them are."""
    first, end = order.first[above], order.first[above + 1]
    for p in range(first, end):
        at[p] = 3 * (p - first)
    own, below = 3 * (end - first), order.row_start[above]
    for k in range(below, order.row_start[above + 1]):
        at[order.rows[k]] = own + 3 * (k - below)
    size = own + 3 * (order.row_start[above + 1] - below)
    low, count = order.row_start[s], order.row_start[s + 1] - order.row_start[s]
    for a in range(count):
        row = at[order.rows[low + a]]
        for b in range(count):
            column = at[order.rows[low + b]]
            for i in range(3):
                for j in range(3):
                    mine[width + 3 * a + i, width + 3 * b + j] = theirs[(row + i) * size + column + j]


@njit(cache=True, fastmath=_ANY_ORDER)
def _invert(lower: Array, mine: Array, width: int, size: int) -> None:
    """Fill the rest of a panel's inverse; ``lower`` (width, size) holds the factor by columns.

    Column by column from the last, with what is known already: of Z L = L^-T, whose part below the diagonal
    is zero, Z[r, c] L[c, c] = [r == c] / L[c, c] - sum over k > c of Z[r, k] L[k, c].
    """
    for c in range(width - 1, -1, -1):
        column = lower[c]
        pivot = 1.0 / column[c]
        for r in range(c + 1, size):
            total = 0.0
            row = mine[r]
            for k in range(c + 1, size):
                total += row[k] * column[k]
            mine[r, c] = -total * pivot
            mine[c, r] = mine[r, c]
        total = 0.0
        row = mine[c]
        for k in range(c + 1, size):
            total += row[k] * column[k]
        mine[c, c] = (pivot - total) * pivot
