"""Sparse Cholesky factorisation of a graph's normal matrix, by panels of blocks (multifrontal).

Duff and Reid 1983. Each panel gathers the blocks of its own columns and what its children left over in a
small dense matrix, eliminates its columns and passes the rest on. Tested against dense algebra.
"""

from __future__ import annotations

from math import sqrt

import numpy as np
from numba import njit

from robots.estimation.graph.factors import Equations
from robots.estimation.graph.order import Order
from robots.se2 import Array

_ANY_ORDER = {"reassoc", "contract"}  # sums may be taken in any order, so that they fit vector registers
_TINY = 1e-13  # of the diagonal: what is left of a pivot that cancels


@njit(cache=True)
def factorise(order: Order, equations: Equations, damping: float, factor: Array) -> bool:
    """Write the Cholesky factor, panel after panel by columns, into ``factor`` (panel_start[-1],).

    The diagonal is scaled by 1 + ``damping`` (Levenberg and Marquardt). Return whether all pivots were
    positive.
    """
    panels = len(order.first) - 1
    front = np.empty(order.widest * order.widest)
    stack, used = np.empty(order.stack), 0
    waiting = np.empty(panels, np.int64)  # panels on the stack
    depth = 0
    at = np.empty(len(order.vertex), np.int64)  # row of each place in the dense matrix
    least = np.empty(order.widest)  # below it a pivot is nothing but rounding
    for s in range(panels):
        start, end = order.first[s], order.first[s + 1]
        low, high = order.row_start[s], order.row_start[s + 1]
        width, size = 3 * (end - start), 3 * (end - start + high - low)
        for j in range(size):
            front[j * size + j : (j + 1) * size] = 0.0
        for p in range(start, end):
            at[p] = 3 * (p - start)
        for k in range(low, high):
            at[order.rows[k]] = width + 3 * (k - low)
        for p in range(start, end):
            column = at[p]
            block = equations.diagonal[order.vertex[p]]
            for c in range(3):
                front[(column + c) * size + column + c] = block[c, c] * (1.0 + damping)
                least[column + c] = block[c, c] * _TINY
                for r in range(c + 1, 3):
                    front[(column + c) * size + column + r] = block[r, c]
            for k in range(order.entry_start[p], order.entry_start[p + 1]):
                block, row = equations.beside[order.entries[k]], at[order.entry_row[k]]
                for c in range(3):
                    for r in range(3):
                        front[(column + c) * size + row + r] = block[r, c]
        for _ in range(order.children[s]):
            depth -= 1
            t = waiting[depth]
            used -= _take(order, t, stack, used, front, size, at)
        if not eliminate_columns(front, size, width, least, False):
            return False
        to = order.panel_start[s]
        factor[to : to + width * size] = front[: width * size]
        rest = size - width
        for j in range(rest):
            source, target = (width + j) * size + width, used + j * rest
            stack[target + j : target + rest] = front[source + j : source + rest]
        used += rest * rest
        waiting[depth] = s
        depth += 1
    return True


@njit(cache=True)
def _take(order: Order, child: int, stack: Array, used: int, front: Array, size: int, at: Array) -> int:
    """Add to ``front`` what a child left over; return how many numbers that took on the stack."""
    low, high = order.row_start[child], order.row_start[child + 1]
    rest = 3 * (high - low)
    begin = used - rest * rest
    for b in range(high - low):
        column = at[order.rows[low + b]]
        for c in range(3):
            source, target = begin + (3 * b + c) * rest, (column + c) * size
            for r in range(c, 3):
                front[target + column + r] += stack[source + 3 * b + r]
            for a in range(b + 1, high - low):
                row = target + at[order.rows[low + a]]
                front[row] += stack[source + 3 * a]
                front[row + 1] += stack[source + 3 * a + 1]
                front[row + 2] += stack[source + 3 * a + 2]
    return int(rest * rest)


@njit(cache=True, fastmath=_ANY_ORDER)
def eliminate_columns(front: Array, size: int, width: int, least: Array, spare: bool) -> bool:
    """Eliminate the first ``width`` columns of the dense matrix, three at a time.

    A pivot that is not above ``least`` ends it and gives False; if ``spare``, its direction, which nothing
    measures, is left as it is instead.
    """
    for k in range(0, width, 3):
        for c in range(k, k + 3):
            column = front[c * size : (c + 1) * size]
            for d in range(k, c):
                left = front[d * size : (d + 1) * size]
                factor = left[c]
                for r in range(c, size):
                    column[r] -= factor * left[r]
            if not column[c] > least[c]:
                if not spare:
                    return False
                column[c:size] = 0.0
                column[c] = 1.0
            root = 1.0 / sqrt(column[c])
            for r in range(c, size):
                column[r] *= root
        first = front[k * size : (k + 1) * size]
        second = front[(k + 1) * size : (k + 2) * size]
        third = front[(k + 2) * size : (k + 3) * size]
        for c in range(k + 3, size - 1, 2):  # two columns at a time: what is loaded serves twice
            column, beside = front[c * size : (c + 1) * size], front[(c + 1) * size : (c + 2) * size]
            u, v, w = first[c], second[c], third[c]
            x, y, z = first[c + 1], second[c + 1], third[c + 1]
            column[c] -= u * u + v * v + w * w
            for r in range(c + 1, size):
                a, b, d = first[r], second[r], third[r]
                column[r] -= u * a + v * b + w * d
                beside[r] -= x * a + y * b + z * d
        if (size - k) % 2 == 0:  # an odd one was left
            c = size - 1
            front[c * size + c] -= first[c] ** 2 + second[c] ** 2 + third[c] ** 2
    return True


@njit(cache=True, fastmath=_ANY_ORDER)
def solve_factored(order: Order, factor: Array, right: Array, x: Array) -> None:
    """Write the solution for a right-hand side (n, 3) into ``x`` (n, 3), rows by vertex."""
    n, panels = len(order.vertex), len(order.first) - 1
    y, local = np.empty(3 * n), np.empty(order.widest)
    for p in range(n):
        for d in range(3):
            y[3 * p + d] = right[order.vertex[p], d]
    for s in range(panels):
        begin, low = 3 * order.first[s], order.row_start[s]
        width, count = 3 * order.first[s + 1] - begin, order.row_start[s + 1] - low
        size = width + 3 * count
        local[:width] = y[begin : begin + width]
        local[width:size] = 0.0
        for c in range(width):
            column = factor[order.panel_start[s] + c * size : order.panel_start[s] + (c + 1) * size]
            value = local[c] / column[c]
            y[begin + c] = value
            for r in range(c + 1, size):
                local[r] -= value * column[r]
        for k in range(count):
            for d in range(3):
                y[3 * order.rows[low + k] + d] += local[width + 3 * k + d]
    for s in range(panels - 1, -1, -1):
        begin, low = 3 * order.first[s], order.row_start[s]
        width, count = 3 * order.first[s + 1] - begin, order.row_start[s + 1] - low
        size = width + 3 * count
        local[:width] = y[begin : begin + width]
        for k in range(count):
            for d in range(3):
                local[width + 3 * k + d] = y[3 * order.rows[low + k] + d]
        for c in range(width - 1, -1, -1):
            column = factor[order.panel_start[s] + c * size : order.panel_start[s] + (c + 1) * size]
            value = local[c]
            for r in range(c + 1, size):
                value -= column[r] * local[r]
            local[c] = value / column[c]
            y[begin + c] = local[c]
    for p in range(n):
        for d in range(3):
            x[order.vertex[p], d] = y[3 * p + d]
