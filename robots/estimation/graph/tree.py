"""Places for vertices that have none: composed along a spanning tree of the graph."""

from __future__ import annotations

from math import cos, sin

import numpy as np
from numba import njit

from robots.estimation.graph.factors import Factors
from robots.graph_report import IntArray
from robots.se2 import Array


def along_tree(state: Array, factors: Factors) -> Array:
    """Return a state (n, 3) in which each vertex is where the fewest edges from an anchored one put it."""
    known = np.zeros(len(state), np.bool_)
    begin = state.copy()
    for index, value, weight in zip(factors.anchored, factors.values, factors.weights, strict=True):
        if weight.all():
            known[index] = True
            begin[index] = value
    spread: Array = spread_along_tree(begin, known, factors.pairs, factors.measured, factors.tags_from)
    return spread


@njit(cache=True)
def spread_along_tree(state: Array, known: Array, pairs: IntArray, measured: Array, edges: int) -> Array:
    """Return the state (n, 3) with every vertex that is not ``known`` (n,) composed from its neighbours.

    Breadth first over the first ``edges`` links, which are poses; then the others, which are tags seen. In a
    piece where nothing is known its first vertex stays where it is.
    """
    n = len(state)
    state, known = state.copy(), known.copy()
    starts = np.zeros(n + 1, np.int64)
    for k in range(edges):
        starts[pairs[k, 0] + 1] += 1
        starts[pairs[k, 1] + 1] += 1
    starts = np.cumsum(starts)
    filled, links = starts.copy(), np.empty(2 * edges, np.int64)
    for k in range(edges):
        for end in range(2):
            i = pairs[k, end]
            links[filled[i]] = k
            filled[i] += 1
    queue, head, tail = np.empty(n, np.int64), 0, 0
    for i in range(n):
        if known[i]:
            queue[tail] = i
            tail += 1
    waiting = 0
    while True:
        while head < tail:
            i = queue[head]
            head += 1
            for at in range(starts[i], starts[i + 1]):
                k = links[at]
                a, b = pairs[k, 0], pairs[k, 1]
                j = b if a == i else a
                if known[j]:
                    continue
                if a == i:
                    c, s = cos(state[i, 2]), sin(state[i, 2])
                    state[j, 2] = state[i, 2] + measured[k, 2]
                    x, y = measured[k, 0], measured[k, 1]
                    state[j, 0], state[j, 1] = state[i, 0] + c * x - s * y, state[i, 1] + s * x + c * y
                else:
                    state[j, 2] = state[i, 2] - measured[k, 2]
                    c, s = cos(state[j, 2]), sin(state[j, 2])
                    x, y = measured[k, 0], measured[k, 1]
                    state[j, 0], state[j, 1] = state[i, 0] - c * x + s * y, state[i, 1] - s * x - c * y
                known[j] = True
                queue[tail] = j
                tail += 1
        while waiting < n and (known[waiting] or starts[waiting] == starts[waiting + 1]):
            waiting += 1
        if waiting == n:
            break
        known[waiting] = True
        queue[tail] = waiting
        tail += 1
    for k in range(edges, len(pairs)):
        i, j = pairs[k, 0], pairs[k, 1]
        if not known[j]:
            c, s = cos(state[i, 2]), sin(state[i, 2])
            x, y = measured[k, 0], measured[k, 1]
            state[j, 0], state[j, 1] = state[i, 0] + c * x - s * y, state[i, 1] + s * x + c * y
            known[j] = True
    return state
