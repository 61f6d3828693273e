"""The growing elimination tree of the incremental solver, and its top that is built anew.

After Kaess et al. 2012 (iSAM2, the Bayes tree). Each panel keeps its dense matrix after elimination: its
columns of the factor, and what it leaves to its parent. New measurements, and vertices that have moved far
from where their errors were linearised, concern the panels from theirs to the root alone; everything
below stands. The top is ordered anew each time, with the newest vertices last, so that the next ones again
concern little.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from robots.estimation.graph.degree import Elimination, minimum_degree
from robots.estimation.graph.factors import BoolArray
from robots.graph_report import IntArray
from robots.se2 import Array

NAMES, NUMBERS, PANELS = range(3)  # places in ``Panels.counts``
_LATE = 16  # so many new vertices are ordered last; more are a graph of their own


class Vertices(NamedTuple):
    """Poses and tags; the estimate is ``state + step``."""

    state: Array  # (n, 3) where the errors are linearised
    step: Array  # (n, 3)
    passed: Array  # (n, 3) the step that the panels below have last been solved with
    sharpness: Array  # (n, 3) diagonal of the normal equations
    is_tag: BoolArray  # (n,)
    link: IntArray  # (n,) its newest link, -1 for none
    anchor: IntArray  # (n,) its newest anchor, -1 for none
    panel: IntArray  # (n,) where it is eliminated, -1 before


class Links(NamedTuple):
    """Edges and sightings, in a list for each vertex: ``following`` (k, 2) by end."""

    pairs: IntArray
    measured: Array
    information: Array
    robust: BoolArray
    weight: Array  # (k,) of the kernel
    following: IntArray


class Anchors(NamedTuple):
    """Values known of one vertex: priors and headings."""

    values: Array  # (p, 3)
    weights: Array  # (p, 3) inverse variances
    following: IntArray  # (p,)


class Panels(NamedTuple):
    """Panels by number; those with no width are free, and their room serves again.

    The vertices of panel s are ``names[start[s] :][: height[s]]``, columns first. From ``offset[s]`` on stand
    its dense matrix with the right-hand side as last row, by columns, and the diagonal before elimination.
    """

    start: IntArray
    width: IntArray
    height: IntArray
    parent: IntArray
    child: IntArray
    sibling: IntArray  # next child of its parent; of a free one the next free one with as much room
    offset: IntArray
    capacity: IntArray  # greatest height
    free: IntArray  # first free panel by capacity, -1 for none
    free_count: IntArray  # by capacity
    names: IntArray
    numbers: Array
    counts: IntArray  # (3,)


class Top(NamedTuple):
    """What is eliminated anew: its vertices, the panels that stay below it, and its new elimination."""

    vertices: IntArray
    below: IntArray
    elimination: Elimination


@njit(cache=True)
def room(height: int) -> int:
    """Return how many numbers a panel takes."""
    return int((3 * height + 1) ** 2 + 3 * height)


@njit(cache=True)
def move(vertices: Vertices, links: Links, bent: IntArray) -> IntArray:
    """Linearise anew at the estimates of vertices; return all that this concerns, some perhaps twice."""
    n = len(bent)
    for v in bent:
        k = vertices.link[v]
        while k >= 0:
            n += 1
            k = links.following[k, 0 if links.pairs[k, 0] == v else 1]
    concerned, n = np.empty(n, np.int64), 0
    for v in bent:
        for d in range(3):
            vertices.state[v, d] += vertices.step[v, d]
            vertices.step[v, d] = vertices.passed[v, d] = 0.0
        concerned[n] = v
        n += 1
        k = vertices.link[v]
        while k >= 0:
            end = 0 if links.pairs[k, 0] == v else 1
            concerned[n] = links.pairs[k, 1 - end]
            n += 1
            k = links.following[k, end]
    return concerned


@njit(cache=True)
def take_off(
    vertices: Vertices, links: Links, panels: Panels, touched: IntArray, old: int, count: int
) -> Top:
    """Free the panels from ``touched`` vertices to the roots; return them with the new ones, ordered anew.

    Vertices ``old`` to ``count`` - 1 are new.
    """
    high = panels.counts[PANELS]
    marked = np.zeros(high, np.bool_)
    taken, n_taken, n_vertices = np.empty(high, np.int64), 0, count - old
    for v in touched:
        s = vertices.panel[v]
        while s >= 0 and not marked[s]:
            marked[s] = True
            taken[n_taken] = s
            n_taken += 1
            n_vertices += panels.width[s]
            s = panels.parent[s]
    top, at = np.empty(n_vertices, np.int64), 0
    below, n_below = np.empty(high, np.int64), 0
    local = np.full(count, -1, np.int64)
    for t in range(n_taken):
        s = taken[t]
        for k in range(panels.start[s], panels.start[s] + panels.width[s]):
            v = panels.names[k]
            top[at], local[v], vertices.panel[v] = v, at, -1
            at += 1
        c = panels.child[s]
        while c >= 0:
            if not marked[c]:
                below[n_below] = c
                n_below += 1
            c = panels.sibling[c]
    for t in range(n_taken):
        s = taken[t]
        room_for = panels.capacity[s]
        panels.width[s], panels.sibling[s] = 0, panels.free[room_for]
        panels.free[room_for] = s
        panels.free_count[room_for] += 1
    for v in range(old, count):
        top[at], local[v] = v, at
        at += 1
    below = below[:n_below]
    starts, ends = np.zeros(at + 1, np.int64), 0
    for i in range(at):
        k = vertices.link[top[i]]
        while k >= 0:
            end = 0 if links.pairs[k, 0] == top[i] else 1
            ends += 1
            k = links.following[k, end]
    beside, seen, used = np.empty(ends, np.int64), np.full(at, -1, np.int64), 0
    for i in range(at):
        k = vertices.link[top[i]]
        while k >= 0:
            end = 0 if links.pairs[k, 0] == top[i] else 1
            j = local[links.pairs[k, 1 - end]]
            if j >= 0 and seen[j] != i:
                seen[j] = i
                beside[used] = j
                used += 1
            k = links.following[k, end]
        starts[i + 1] = used
    clique_starts = np.zeros(n_below + 1, np.int64)
    for t in range(n_below):
        c = below[t]
        clique_starts[t + 1] = clique_starts[t] + panels.height[c] - panels.width[c]
    cliques = np.empty(clique_starts[-1], np.int64)
    for t in range(n_below):
        low = panels.start[below[t]] + panels.width[below[t]]
        for k in range(clique_starts[t + 1] - clique_starts[t]):
            cliques[clique_starts[t] + k] = local[panels.names[low + k]]
    late = np.zeros(at, np.bool_)
    if count - old <= _LATE:
        late[at - (count - old) :] = True
    found = minimum_degree(starts, beside[:used], clique_starts, cliques, late)
    return Top(top, below, found)


@njit(cache=True)
def heights(top: Top) -> IntArray:
    """Return how many vertices each panel of a new top has, rows and columns."""
    found = top.elimination
    return np.diff(found.column_start) + np.diff(found.row_start)


@njit(cache=True)
def _fitting(height: int, free_count: IntArray) -> int:
    """Return the least capacity of a free panel that is not much more than ``height``, -1 for none."""
    for capacity in range(height, min(height + 2 + height // 8, len(free_count))):
        if free_count[capacity]:
            return capacity
    return -1


@njit(cache=True)
def shortage(panels: Panels, height: IntArray) -> tuple[int, int, int]:
    """Return how many panels, names and numbers are needed beside what is free."""
    left = panels.free_count.copy()
    count, names, numbers = 0, 0, 0
    for h in height:
        capacity = _fitting(h, left)
        if capacity >= 0:
            left[capacity] -= 1
        else:
            count, names, numbers = count + 1, names + h, numbers + room(h)
    return count, names, numbers


@njit(cache=True)
def place(vertices: Vertices, panels: Panels, top: Top, height: IntArray) -> IntArray:
    """Give the new top its panels, hang those below under them, and return them in order of elimination."""
    found, counts = top.elimination, panels.counts
    new = np.empty(len(found.parent), np.int64)
    for t in range(len(new)):
        capacity = _fitting(height[t], panels.free_count)
        if capacity >= 0:
            s = panels.free[capacity]
            panels.free[capacity] = panels.sibling[s]
            panels.free_count[capacity] -= 1
        else:
            s = counts[PANELS]
            panels.start[s], panels.offset[s], panels.capacity[s] = counts[NAMES], counts[NUMBERS], height[t]
            counts[PANELS] += 1
            counts[NAMES] += height[t]
            counts[NUMBERS] += room(height[t])
        new[t] = s
    rank = np.empty(len(top.vertices), np.int64)
    for t in range(len(new)):
        s = new[t]
        low, high = found.column_start[t], found.column_start[t + 1]
        width, below = high - low, found.row_start[t + 1] - found.row_start[t]
        panels.width[s], panels.height[s] = width, width + below
        panels.child[s] = panels.sibling[s] = -1
        for k in range(width):
            local = found.columns[low + k]
            panels.names[panels.start[s] + k] = top.vertices[local]
            vertices.panel[top.vertices[local]] = s
            rank[local] = t
        for k in range(below):
            panels.names[panels.start[s] + width + k] = top.vertices[found.rows[found.row_start[t] + k]]
    for t in range(len(new)):
        panels.parent[new[t]] = -1
        if found.parent[t] >= 0:
            s = new[found.parent[t]]
            panels.parent[new[t]] = s
            panels.sibling[new[t]], panels.child[s] = panels.child[s], new[t]
    order = np.full(int(np.max(top.vertices)) + 1 if len(top.vertices) else 0, -1, np.int64)
    for k in range(len(top.vertices)):
        order[top.vertices[k]] = rank[k]
    for c in top.below:
        first = len(new)
        for k in range(panels.start[c] + panels.width[c], panels.start[c] + panels.height[c]):
            first = min(first, order[panels.names[k]])
        s = new[first]
        panels.parent[c] = s
        panels.sibling[c], panels.child[s] = panels.child[s], c
    return new


def no_panels(few: int) -> Panels:
    """Return room for a few panels."""

    def zeros() -> IntArray:
        return np.zeros(few, np.int64)

    return Panels(
        start=zeros(), width=zeros(), height=zeros(), parent=zeros(), child=zeros(), sibling=zeros(),
        offset=zeros(), capacity=zeros(), free=np.full(few, -1), free_count=zeros(), names=zeros(),
        numbers=np.zeros(few), counts=np.zeros(3, np.int64),
    )  # fmt: skip
