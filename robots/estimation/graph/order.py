"""In which order a graph's vertices are eliminated, and where the factor then has entries.

Computed on the graph of blocks, nine times smaller than the matrix: qdldl's minimum-degree order (AMD) of a
matrix with that pattern, its elimination tree in postorder, and neighbouring columns of nearly the same
pattern gathered into panels (supernodes), so that the arithmetic is on small dense matrices.
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
import qdldl
from numba import njit

from robots.graph_report import IntArray
from robots.se2 import Array

_SLACK_ROWS = 3  # zeros a panel may carry for being wider: so many a column, or this share of its entries
_SLACK_SHARE = 0.2


class Order(NamedTuple):
    """Places are positions in the order of elimination; panel s holds places first[s] .. first[s + 1] - 1."""

    vertex: IntArray  # (n,) at each place
    place: IntArray  # (n,) of each vertex
    first: IntArray  # (s + 1,)
    row_start: IntArray  # (s + 1,) into rows
    rows: IntArray  # places below each panel that it touches, ascending
    children: IntArray  # (s,) how many panels hang on each
    entry_start: IntArray  # (n + 1,) into entries, by the lower place of a block
    entries: IntArray  # (b,) blocks beside the diagonal
    entry_row: IntArray  # (b,) the higher place of each of the entries
    panel_start: IntArray  # (s + 1,) into the factor's numbers
    widest: int  # rows of the largest dense matrix
    stack: int  # numbers waiting at the same time


def order(count: int, pairs: IntArray) -> tuple[Order, IntArray, IntArray]:
    """Return the order for vertices 0 .. count - 1 joined by ``pairs`` (k, 2), and each pair's block.

    The last two are ``slot`` and ``turned`` of ``graph_factors.Equations``, each (k,).
    """
    slot, starts, indices, data = blocks(count, pairs)
    size = (count, count)
    pattern = SimpleNamespace(data=data, indices=indices, indptr=starts, shape=size, nnz=len(data))
    lower, _, permutation = qdldl.Solver(pattern, upper=True).factors()
    found, turned = _analyse(
        count,
        pairs,
        slot,
        starts,
        indices,
        lower.indptr.astype(np.int64),
        lower.indices.astype(np.int64),
        np.asarray(permutation, np.int64),
    )
    return Order(*found), slot, turned


@njit(cache=True)
def blocks(count: int, pairs: IntArray) -> tuple[IntArray, IntArray, IntArray, Array]:
    """Return each pair's block (k,), and the graph's Laplacian + 1 by columns, upper triangle."""
    k = len(pairs)
    low, high = np.empty(k, np.int64), np.empty(k, np.int64)
    by_low, by_high = np.zeros(count + 1, np.int64), np.zeros(count + 1, np.int64)
    for f in range(k):
        low[f], high[f] = min(pairs[f, 0], pairs[f, 1]), max(pairs[f, 0], pairs[f, 1])
        by_low[low[f] + 1] += 1
        by_high[high[f] + 1] += 1
    by_low, by_high = np.cumsum(by_low), np.cumsum(by_high)
    first, second = np.empty(k, np.int64), np.empty(k, np.int64)
    for f in range(k):
        first[by_low[low[f]]] = f
        by_low[low[f]] += 1
    for at in range(k):
        f = first[at]
        second[by_high[high[f]]] = f
        by_high[high[f]] += 1
    slot = np.full(k, -1, np.int64)
    indices, starts = np.empty(k + count, np.int64), np.zeros(count + 1, np.int64)
    data = np.full(k + count, -1.0)
    degree = np.ones(count)
    unique, at, f = 0, 0, 0
    for column in range(count):
        previous = -1
        while f < k and high[second[f]] == column:
            edge = second[f]
            f += 1
            if low[edge] == column:
                continue  # a vertex seen from itself
            if low[edge] != previous:
                previous = int(low[edge])
                indices[at] = previous
                degree[previous] += 1.0
                degree[column] += 1.0
                at += 1
                unique += 1
            slot[edge] = unique - 1
        indices[at] = column
        at += 1
        starts[column + 1] = at
    for column in range(count):
        data[starts[column + 1] - 1] = degree[column]
    return slot, starts, indices[:at], data[:at]


@njit(cache=True)
def _postorder(parent: IntArray) -> IntArray:
    n = len(parent)
    head, following = np.full(n, -1, np.int64), np.full(n, -1, np.int64)
    for j in range(n - 1, -1, -1):
        if parent[j] >= 0:
            following[j] = head[parent[j]]
            head[parent[j]] = j
    visited, stack, count = np.empty(n, np.int64), np.empty(n, np.int64), 0
    for root in range(n):
        if parent[root] >= 0:
            continue
        depth, stack[0] = 1, root
        while depth:
            j = stack[depth - 1]
            if head[j] >= 0:
                stack[depth] = head[j]
                head[j] = following[head[j]]
                depth += 1
            else:
                visited[count] = j
                count, depth = count + 1, depth - 1
    return visited


@njit(cache=True)
def _panels(parent: IntArray, counts: IntArray) -> IntArray:
    """Return the first place of each panel and n, (s + 1,)."""
    n = len(parent)
    first = np.empty(n + 1, np.int64)
    panels, zeros = 0, 0
    for j in range(n):
        if j and parent[j - 1] == j:
            width = j - first[panels - 1]
            more = (counts[j] + 1 - counts[j - 1]) * width
            entries = (counts[j] + 1) * (width + 1) + width * (width + 1) // 2
            if zeros + more <= max(_SLACK_ROWS * (width + 1) if width < 4 else 0, _SLACK_SHARE * entries):
                zeros += more
                continue
        first[panels] = j
        panels, zeros = panels + 1, 0
    first[panels] = n
    return first[: panels + 1]


@njit(cache=True)
def _analyse(
    count: int,
    pairs: IntArray,
    slot: IntArray,
    starts: IntArray,
    indices: IntArray,
    lower_start: IntArray,
    lower: IntArray,
    permutation: IntArray,
) -> tuple[Any, IntArray]:  # the fields of Order, and turned
    parent = np.full(count, -1, np.int64)
    for j in range(count):
        for at in range(lower_start[j], lower_start[j + 1]):
            if parent[j] < 0 or lower[at] < parent[j]:
                parent[j] = lower[at]
    visited = _postorder(parent)
    renamed = np.empty(count, np.int64)
    renamed[visited] = np.arange(count)
    vertex = permutation[visited]
    place = np.empty(count, np.int64)
    place[vertex] = np.arange(count)
    above, counts = np.full(count, -1, np.int64), np.empty(count, np.int64)
    for k in range(count):
        j = visited[k]
        counts[k] = lower_start[j + 1] - lower_start[j]
        if parent[j] >= 0:
            above[k] = renamed[parent[j]]
    first = _panels(above, counts)
    panels = len(first) - 1
    panel_of = np.empty(count, np.int64)
    row_start, panel_start = np.zeros(panels + 1, np.int64), np.zeros(panels + 1, np.int64)
    for s in range(panels):
        panel_of[first[s] : first[s + 1]] = s
        below, width = counts[first[s + 1] - 1], first[s + 1] - first[s]
        row_start[s + 1] = row_start[s] + below
        panel_start[s + 1] = panel_start[s] + 9 * width * (width + below)
    rows = np.empty(row_start[-1], np.int64)
    children = np.zeros(panels, np.int64)
    waiting = np.zeros(panels + 1, np.int64)  # sizes on the stack
    depth, used, most, widest = 0, 0, 0, 0
    for s in range(panels):
        top = first[s + 1] - 1
        j = visited[top]
        rows[row_start[s] : row_start[s + 1]] = np.sort(renamed[lower[lower_start[j] : lower_start[j + 1]]])
        if above[top] >= 0:
            children[panel_of[above[top]]] += 1
        for _ in range(children[s]):
            depth -= 1
            used -= waiting[depth]
        waiting[depth] = 9 * counts[top] ** 2
        used += waiting[depth]
        depth += 1
        most, widest = max(most, used), max(widest, 3 * (counts[top] + first[s + 1] - first[s]))
    entry_start = np.zeros(count + 1, np.int64)
    for column in range(count):
        for at in range(starts[column], starts[column + 1] - 1):
            entry_start[min(place[column], place[indices[at]]) + 1] += 1
    entry_start = np.cumsum(entry_start)
    filled = entry_start.copy()
    entries, entry_row = np.empty(entry_start[-1], np.int64), np.empty(entry_start[-1], np.int64)
    for column in range(count):
        for at in range(starts[column], starts[column + 1] - 1):
            p, q = place[column], place[indices[at]]
            entries[filled[min(p, q)]] = at - column
            entry_row[filled[min(p, q)]] = max(p, q)
            filled[min(p, q)] += 1
    turned = np.zeros(len(pairs), np.int64)
    for f in range(len(pairs)):
        turned[f] = place[pairs[f, 0]] > place[pairs[f, 1]]
    found = (
        vertex, place, first, row_start, rows, children, entry_start, entries, entry_row, panel_start, widest,
        most,
    )  # fmt: skip
    return found, turned
