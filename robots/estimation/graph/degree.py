"""In which order to eliminate a graph's vertices: approximate minimum degree (Amestoy, Davis and Duff 1996).

The graph is given as neighbours and *cliques*: what was eliminated before stands for its rows as a clique, so
that the top of an elimination tree can be ordered anew over what hangs below it. Alike vertices are merged,
and neighbouring columns of nearly the same pattern are gathered into panels.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from robots.estimation.graph.factors import BoolArray
from robots.graph_report import IntArray

_SLACK_ROWS = 3  # zeros a panel may carry for being wider: so many a column, or this share of its entries
_SLACK_SHARE = 0.2


class Elimination(NamedTuple):
    """Panels in the order of elimination; each holds vertices and touches rows, which go later."""

    column_start: IntArray  # (s + 1,)
    columns: IntArray  # (n,)
    row_start: IntArray  # (s + 1,)
    rows: IntArray
    parent: IntArray  # (s,) panel of the earliest of the rows, -1 for none


@njit(cache=True)
def minimum_degree(
    starts: IntArray, beside: IntArray, clique_starts: IntArray, cliques: IntArray, late: BoolArray
) -> Elimination:
    """Return the elimination of vertices 0 .. n - 1.

    Neighbours of vertex i are ``beside[starts[i] : starts[i + 1]]``, both ways and each once. Those that are
    ``late`` (n,) go after all others.
    """
    n, m = len(starts) - 1, len(clique_starts) - 1
    given = len(cliques)
    pool = np.empty(len(beside) + 2 * given + 8 * n + 16, np.int64)
    pool[:given] = cliques
    used = given
    # An element is what a pivot leaves: a clique. Those given come after the vertices.
    element_at, element_length = np.zeros(n + m, np.int64), np.zeros(n + m, np.int64)
    size, outside = np.zeros(n + m, np.int64), np.zeros(n + m, np.int64)
    live, stamp = np.zeros(n + m, np.bool_), np.full(n + m, -1, np.int64)
    elements, length, at = np.zeros(n, np.int64), np.zeros(n, np.int64), np.empty(n, np.int64)
    degree = np.zeros(n, np.int64)
    for k in range(given):
        elements[cliques[k]] += 1
    for i in range(n):
        at[i] = used
        used += elements[i] + starts[i + 1] - starts[i]
    for e in range(m):
        element_at[n + e] = clique_starts[e]
        element_length[n + e] = size[n + e] = clique_starts[e + 1] - clique_starts[e]
        live[n + e] = True
        for k in range(clique_starts[e], clique_starts[e + 1]):
            i = cliques[k]
            pool[at[i] + length[i]] = n + e
            length[i] += 1
            degree[i] += size[n + e] - 1
    weight = np.ones(
        n, np.int64
    )  # vertices a vertex stands for; below 0 while in the pivot's rows, 0 when gone
    head, ahead, behind = np.full(2 * n + 1, -1, np.int64), np.full(n, -1, np.int64), np.full(n, -1, np.int64)
    for i in range(n):
        for k in range(starts[i], starts[i + 1]):
            pool[at[i] + length[i]] = beside[k]
            length[i] += 1
        degree[i] = min(degree[i] + starts[i + 1] - starts[i], n - 1)
        _enlist(i, degree[i] + (n if late[i] else 0), head, ahead, behind)
    following, tail = np.full(n, -1, np.int64), np.arange(n)  # the vertices a vertex stands for
    column_start, row_start = np.zeros(n + 1, np.int64), np.zeros(n + 1, np.int64)
    columns, rows = np.empty(n, np.int64), np.empty(4 * n + 16, np.int64)
    panel_of = np.empty(n, np.int64)
    hashed, alike = np.full(n, -1, np.int64), np.empty(n, np.int64)
    seen, kept = np.full(n + m, -1, np.int64), np.empty(n, np.int64)
    panels, done, least, looks = 0, 0, 0, 0
    while done < n:
        while head[least] < 0:
            least += 1
        p = head[least]
        _delist(p, degree[p] + (n if late[p] else 0), head, ahead, behind)
        if used + n > len(pool):
            more = np.empty(2 * len(pool) + n, np.int64)
            more[:used] = pool[:used]
            pool = more
        begin, total = used, 0
        done += weight[p]
        weight[p] = -weight[p]
        for k in range(length[p]):  # the pivot's rows: all its neighbours
            name = pool[at[p] + k]
            if k < elements[p]:
                if not live[name]:
                    continue
                live[name] = False
                low, high = element_at[name], element_at[name] + element_length[name]
            else:
                low, high = at[p] + k, at[p] + k + 1
            for where in range(low, high):
                i = pool[where]
                if weight[i] > 0:
                    total += weight[i]
                    weight[i] = -weight[i]
                    pool[used] = i
                    used += 1
                    _delist(i, degree[i] + (n if late[i] else 0), head, ahead, behind)
        for where in range(begin, used):  # how much of each element lies outside these rows
            i = pool[where]
            for k in range(at[i], at[i] + elements[i]):
                e = pool[k]
                if live[e]:
                    if stamp[e] != p:
                        stamp[e], outside[e] = p, size[e]
                    outside[e] += weight[i]
        for where in range(begin, used):
            i = pool[where]
            beyond, mixed, count, others = 0, p, 0, 0
            for k in range(at[i], at[i] + elements[i]):
                e = pool[k]
                if live[e] and outside[e] > 0:
                    pool[at[i] + count] = e
                    count += 1
                    beyond += outside[e]
                    mixed += e
                else:
                    live[e] = False  # wholly within: absorbed
            for k in range(at[i] + elements[i], at[i] + length[i]):
                j = pool[k]
                if weight[j] > 0:
                    kept[others] = j
                    others += 1
                    beyond += weight[j]
                    mixed += j
            if beyond == 0 and late[i] == late[p]:  # nothing else: goes with the pivot
                total += weight[i]
                done -= weight[i]
                following[tail[p]], tail[p] = i, tail[i]
                weight[i] = 0
                continue
            pool[at[i] + count] = p
            pool[at[i] + count + 1 : at[i] + count + 1 + others] = kept[:others]
            elements[i], length[i] = count + 1, count + 1 + others
            degree[i] = min(degree[i], beyond)
            bucket = mixed % n
            alike[i], hashed[bucket] = hashed[bucket], i
            size[i] = bucket  # remembered where an element's size will stand once i is one
        for where in range(begin, used):  # vertices with the same neighbours stand for each other
            i = pool[where]
            if weight[i] >= 0:
                continue
            first = hashed[size[i]]
            hashed[size[i]] = -1
            while first >= 0:
                looks += 1
                for k in range(at[first], at[first] + length[first]):
                    seen[pool[k]] = looks
                before, j = first, alike[first]
                while j >= 0:
                    same = (
                        elements[j] == elements[first]
                        and length[j] == length[first]
                        and late[j] == late[first]
                    )
                    k = at[j]
                    while same and k < at[j] + length[j]:
                        same = seen[pool[k]] == looks
                        k += 1
                    if same:
                        following[tail[first]], tail[first] = j, tail[j]
                        weight[first] += weight[j]
                        weight[j] = 0
                        alike[before] = alike[j]
                    else:
                        before = j
                    j = alike[j]
                first = alike[first]
        end = begin
        row = row_start[panels]
        if row + total > len(rows):
            wider = np.empty(2 * len(rows) + total, np.int64)
            wider[:row] = rows[:row]
            rows = wider
        for where in range(begin, used):
            i = pool[where]
            if weight[i] >= 0:
                continue
            weight[i] = -weight[i]
            degree[i] = min(degree[i] + total - weight[i], n - done - weight[i])
            key = degree[i] + (n if late[i] else 0)
            _enlist(i, key, head, ahead, behind)
            least = min(least, key)
            pool[end] = i
            end += 1
            j = i
            while j >= 0:
                rows[row] = j
                row += 1
                j = following[j]
        used = end
        element_at[p], element_length[p], size[p] = begin, end - begin, total
        live[p] = total > 0
        weight[p] = 0
        column, j = column_start[panels], p
        while j >= 0:
            columns[column], panel_of[j] = j, panels
            column += 1
            j = following[j]
        panels += 1
        column_start[panels], row_start[panels] = column, row
    found: Elimination = _gathered(
        column_start[: panels + 1], columns, row_start[: panels + 1], rows, panel_of
    )
    return found


@njit(cache=True, inline="always")
def _enlist(i: int, key: int, head: IntArray, ahead: IntArray, behind: IntArray) -> None:
    first = head[key]
    ahead[i], behind[i] = first, -1
    if first >= 0:
        behind[first] = i
    head[key] = i


@njit(cache=True, inline="always")
def _delist(i: int, key: int, head: IntArray, ahead: IntArray, behind: IntArray) -> None:
    if ahead[i] >= 0:
        behind[ahead[i]] = behind[i]
    if behind[i] >= 0:
        ahead[behind[i]] = ahead[i]
    else:
        head[key] = ahead[i]


@njit(cache=True)
def _gathered(
    column_start: IntArray, columns: IntArray, row_start: IntArray, rows: IntArray, panel_of: IntArray
) -> Elimination:
    """Merge panels into their parents where that adds few zeros."""
    panels, n = len(column_start) - 1, len(columns)
    parent = np.full(panels, -1, np.int64)
    width, zeros = np.empty(panels, np.int64), np.zeros(panels, np.int64)
    first, last = np.empty(panels, np.int64), np.empty(panels, np.int64)
    into = np.arange(panels)
    following = np.full(n, -1, np.int64)
    for s in range(panels):
        width[s] = column_start[s + 1] - column_start[s]
        first[s], last[s] = columns[column_start[s]], columns[column_start[s + 1] - 1]
        for k in range(column_start[s], column_start[s + 1] - 1):
            following[columns[k]] = columns[k + 1]
        for k in range(row_start[s], row_start[s + 1]):
            t = panel_of[rows[k]]
            if parent[s] < 0 or t < parent[s]:
                parent[s] = t
    for s in range(panels):
        t = parent[s]
        if t < 0:
            continue
        below = row_start[t + 1] - row_start[t]
        more = width[s] * (width[t] + below - (row_start[s + 1] - row_start[s]))
        both = width[s] + width[t]
        entries = both * below + both * (both + 1) // 2
        sum_zeros = zeros[s] + zeros[t] + more
        if sum_zeros <= max(_SLACK_ROWS * both if both <= 4 else 0, _SLACK_SHARE * entries):
            into[s] = t
            zeros[t], width[t] = sum_zeros, both
            following[last[s]], first[t] = first[t], first[s]
    left = 0
    for s in range(panels):
        left += into[s] == s
    starts, row_starts = np.zeros(left + 1, np.int64), np.zeros(left + 1, np.int64)
    renamed, parents = np.empty(panels, np.int64), np.full(left, -1, np.int64)
    order, lower = np.empty(n, np.int64), np.empty(len(rows), np.int64)
    at, row, t = 0, 0, 0
    for s in range(panels):
        if into[s] != s:
            continue
        j = first[s]
        while j >= 0:
            order[at] = j
            at += 1
            j = following[j]
        count = row_start[s + 1] - row_start[s]
        lower[row : row + count] = rows[row_start[s] : row_start[s + 1]]
        row += count
        renamed[s] = t
        t += 1
        starts[t], row_starts[t] = at, row
    for s in range(panels - 1, -1, -1):
        if into[s] != s:
            renamed[s] = renamed[into[s]]
    for s in range(panels):
        if into[s] == s and parent[s] >= 0:
            parents[renamed[s]] = renamed[parent[s]]
    return Elimination(starts, order, row_starts, lower[:row], parents)
