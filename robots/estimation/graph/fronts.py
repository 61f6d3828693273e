"""The arithmetic on the panels of the incremental solver: elimination, back-substitution, covariances."""

from __future__ import annotations

from math import atan2, cos, sin

import numpy as np
from numba import njit

from robots.estimation.graph.cholesky import eliminate_columns
from robots.estimation.graph.factors import link_error
from robots.estimation.graph.panels import PANELS, Anchors, Links, Panels, Vertices
from robots.graph_report import IntArray
from robots.se2 import Array

_TINY = 1e-13  # of the diagonal: what is left of a pivot that cancels


@njit(cache=True)
def eliminate(vertices: Vertices, links: Links, anchors: Anchors, panels: Panels, new: IntArray) -> None:
    """Fill the ``new`` panels, in order of elimination, with what was measured and what lies below them."""
    rank = np.full(panels.counts[PANELS] + 1, -1, np.int64)  # the last stands for "not in the top"
    for t in range(len(new)):
        rank[new[t]] = t
    at = np.empty(len(vertices.panel), np.int64)
    blocks = np.empty((3, 3, 3))
    slopes = np.empty((2, 3))
    for t in range(len(new)):
        s = new[t]
        begin, width, height = panels.start[s], panels.width[s], panels.height[s]
        size = 3 * height
        stride = size + 1
        front = panels.numbers[panels.offset[s] : panels.offset[s] + stride * stride + size]
        front[:] = 0.0
        whole = front[stride * stride :]  # the diagonal before anything was eliminated
        for k in range(height):
            at[panels.names[begin + k]] = 3 * k
        for a in range(width):
            v = panels.names[begin + a]
            c = 3 * a
            k = vertices.link[v]
            while k >= 0:
                end = 0 if links.pairs[k, 0] == v else 1
                u = links.pairs[k, 1 - end]
                other = rank[vertices.panel[u]]
                if other > t or (other == t and at[u] > c):
                    _linearised(vertices, links, k, blocks, slopes)
                    r = at[u]
                    mine, his = (blocks[0], blocks[2]) if end == 0 else (blocks[2], blocks[0])
                    for i in range(3):
                        for j in range(3):
                            # the block below the diagonal: rows of the other, columns of this one
                            front[(c + j) * stride + r + i] += (
                                blocks[1, i, j] if end == 0 else blocks[1, j, i]
                            )
                        for j in range(i + 1):
                            front[(c + j) * stride + c + i] += mine[i, j]
                            front[(r + j) * stride + r + i] += his[i, j]
                        whole[c + i] += mine[i, i]
                        whole[r + i] += his[i, i]
                        front[(c + i) * stride + size] -= slopes[end, i]
                        front[(r + i) * stride + size] -= slopes[1 - end, i]
                k = links.following[k, end]
            k = vertices.anchor[v]
            while k >= 0:
                for i in range(3):
                    error = vertices.state[v, i] - anchors.values[k, i]
                    if i == 2:
                        error = atan2(sin(error), cos(error))
                    front[(c + i) * stride + c + i] += anchors.weights[k, i]
                    whole[c + i] += anchors.weights[k, i]
                    front[(c + i) * stride + size] -= anchors.weights[k, i] * error
                k = anchors.following[k]
            if vertices.is_tag[v]:
                front[(c + 2) * stride + c + 2] = whole[c + 2] = 1.0
        child = panels.child[s]
        while child >= 0:
            _add_rest(panels, child, front, stride, at)
            child = panels.sibling[child]
        for a in range(width):
            for i in range(3):
                vertices.sharpness[panels.names[begin + a], i] = whole[3 * a + i]
        eliminate_columns(front, stride, 3 * width, whole * _TINY, True)


@njit(cache=True)
def _linearised(vertices: Vertices, links: Links, k: int, blocks: Array, slopes: Array) -> None:
    """Write H_aa, H_ba, H_bb and g_a, g_b of one link, eq. (H) of ``graph_factors``."""
    a, b = links.pairs[k]
    state, o = vertices.state, links.information[k]
    weight = links.weight[k]
    c, s = cos(state[a, 2]), sin(state[a, 2])
    e0, e1, e2 = link_error(state[a], state[b], links.measured[k])
    if o[2, 2] <= 0.0:
        e2 = 0.0
    q0, q1 = state[a, 1] - state[b, 1], state[b, 0] - state[a, 0]
    a00, a01 = c * o[0, 0] - s * o[0, 1], c * o[0, 1] - s * o[1, 1]
    a10, a11 = s * o[0, 0] + c * o[0, 1], s * o[0, 1] + c * o[1, 1]
    M = blocks[2]
    M[0, 0], M[0, 1] = weight * (a00 * c - a01 * s), weight * (a00 * s + a01 * c)
    M[1, 0], M[1, 1] = M[0, 1], weight * (a10 * s + a11 * c)
    M[0, 2], M[1, 2] = weight * (c * o[0, 2] - s * o[1, 2]), weight * (s * o[0, 2] + c * o[1, 2])
    M[2, 0], M[2, 1], M[2, 2] = M[0, 2], M[1, 2], weight * o[2, 2]
    w0 = o[0, 0] * e0 + o[0, 1] * e1 + o[0, 2] * e2
    w1 = o[0, 1] * e0 + o[1, 1] * e1 + o[1, 2] * e2
    w2 = o[0, 2] * e0 + o[1, 2] * e1 + o[2, 2] * e2
    r0, r1, r2 = weight * (c * w0 - s * w1), weight * (s * w0 + c * w1), weight * w2
    slopes[1, 0], slopes[1, 1], slopes[1, 2] = r0, r1, r2
    slopes[0, 0], slopes[0, 1], slopes[0, 2] = -r0, -r1, -(q0 * r0 + q1 * r1 + r2)
    for i in range(3):  # H_ba = -M S; H_aa = S' M S
        last = M[i, 0] * q0 + M[i, 1] * q1 + M[i, 2]
        blocks[1, i, 0], blocks[1, i, 1], blocks[1, i, 2] = -M[i, 0], -M[i, 1], -last
        blocks[0, i, 0], blocks[0, i, 1], blocks[0, i, 2] = M[i, 0], M[i, 1], last
    for j in range(3):
        blocks[0, 2, j] = q0 * blocks[0, 0, j] + q1 * blocks[0, 1, j] + blocks[0, 2, j]


@njit(cache=True)
def _add_rest(panels: Panels, child: int, front: Array, stride: int, at: IntArray) -> None:
    """Add what a panel below left over to the dense matrix of its parent."""
    width, height = panels.width[child], panels.height[child]
    step = 3 * height + 1
    size = stride - 1
    rest = panels.numbers[panels.offset[child] : panels.offset[child] + step * step + 3 * height]
    for b in range(width, height):
        column = at[panels.names[panels.start[child] + b]]
        for c in range(3):
            source, target = (3 * b + c) * step, (column + c) * stride
            for r in range(c, 3):
                front[target + column + r] += rest[source + 3 * b + r]
            front[target + size] += rest[source + step - 1]
            front[stride * stride + column + c] += rest[step * step + 3 * b + c]
        for a in range(b + 1, height):
            row = at[panels.names[panels.start[child] + a]]
            if row > column:
                for c in range(3):
                    source, target = (3 * b + c) * step + 3 * a, (column + c) * stride + row
                    front[target] += rest[source]
                    front[target + 1] += rest[source + 1]
                    front[target + 2] += rest[source + 2]
            else:
                for r in range(3):
                    target, source = (row + r) * stride + column, 3 * b * step + 3 * a + r
                    front[target] += rest[source]
                    front[target + 1] += rest[source + step]
                    front[target + 2] += rest[source + 2 * step]


@njit(cache=True)
def substitute(vertices: Vertices, panels: Panels, new: IntArray, pass_sd: float) -> IntArray:
    """Solve the ``new`` panels from the root down, and those below them as far as anything changes.

    A change of a vertex is passed on where it matters by more than ``pass_sd`` deviations. Return the
    vertices that changed.
    """
    count = panels.counts[PANELS]
    changed = np.zeros(len(vertices.panel), np.bool_)
    found, n_found = np.empty(len(vertices.panel), np.int64), 0
    fresh = np.zeros(count, np.bool_)
    fresh[new] = True
    stack, depth = np.empty(count, np.int64), 0
    for s in new:
        if panels.parent[s] < 0:
            stack[depth] = s
            depth += 1
    local = np.empty(16)
    while depth:
        depth -= 1
        s = stack[depth]
        begin, width, height = panels.start[s], panels.width[s], panels.height[s]
        if not fresh[s]:
            news = False
            for k in range(begin + width, begin + height):
                news |= changed[panels.names[k]]
            if not news:
                continue
        size = 3 * height
        stride = size + 1
        if len(local) < size:
            local = np.empty(2 * size)
        for k in range(width, height):
            for d in range(3):
                local[3 * k + d] = vertices.step[panels.names[begin + k], d]
        numbers = panels.numbers[panels.offset[s] : panels.offset[s] + stride * stride]
        for c in range(3 * width - 1, -1, -1):
            column = numbers[c * stride : c * stride + stride]
            value = column[size]
            for r in range(c + 1, size):
                value -= column[r] * local[r]
            local[c] = value / column[c]
        for k in range(width):
            v = panels.names[begin + k]
            change = 0.0
            for d in range(3):
                vertices.step[v, d] = local[3 * k + d]
                change = max(
                    change, (local[3 * k + d] - vertices.passed[v, d]) ** 2 * vertices.sharpness[v, d]
                )
            if change > pass_sd * pass_sd:
                vertices.passed[v] = vertices.step[v]
                changed[v] = True
                found[n_found] = v
                n_found += 1
        child = panels.child[s]
        while child >= 0:
            stack[depth] = child
            depth += 1
            child = panels.sibling[child]
    return found[:n_found]


@njit(cache=True)
def joint_covariance(vertices: Vertices, panels: Panels, first: int, second: int) -> Array:
    """Return the covariance (6, 6) of two vertices; of one with itself its own stands in every block.

    With H = L L' it is Y' Y of Y = L^-1 [I_first I_second], which is not 0 on the ways to the root only.
    """
    way, length = np.empty(panels.counts[PANELS], np.int64), 0
    on_first = np.zeros(panels.counts[PANELS], np.bool_)
    s = vertices.panel[first]
    while s >= 0:
        on_first[s] = True
        s = panels.parent[s]
    meeting = vertices.panel[second]
    while meeting >= 0 and not on_first[meeting]:
        meeting = panels.parent[meeting]
    for start in (first, second):
        s = vertices.panel[start]
        while s != meeting:
            way[length] = s
            length += 1
            s = panels.parent[s]
    while meeting >= 0:
        way[length] = meeting
        length += 1
        meeting = panels.parent[meeting]
    place = np.full(len(vertices.panel), -1, np.int64)
    total = 0
    for t in range(length):
        s = way[t]
        for k in range(panels.start[s], panels.start[s] + panels.height[s]):
            v = panels.names[k]
            if place[v] < 0:
                place[v] = total
                total += 3
    right = np.zeros((6, total))
    for d in range(3):
        right[d, place[first] + d] = 1.0
        right[3 + d, place[second] + d] = 1.0
    covariance = np.zeros((6, 6))
    y = np.empty((6, total))
    for t in range(length):
        s = way[t]
        begin, width, size = panels.start[s], 3 * panels.width[s], 3 * panels.height[s]
        stride = size + 1
        numbers = panels.numbers[panels.offset[s] : panels.offset[s] + stride * stride]
        for m in range(6):
            for k in range(panels.height[s]):
                where = place[panels.names[begin + k]]
                for d in range(3):
                    y[m, 3 * k + d] = right[m, where + d]
            for c in range(width):
                column = numbers[c * stride : c * stride + stride]
                value = y[m, c] / column[c]
                y[m, c] = value
                if value != 0.0:
                    for r in range(c + 1, size):
                        y[m, r] -= value * column[r]
            for k in range(panels.width[s], panels.height[s]):
                where = place[panels.names[begin + k]]
                for d in range(3):
                    right[m, where + d] = y[m, 3 * k + d]
        for m in range(6):
            for other in range(m + 1):
                covariance[m, other] += np.sum(y[m, :width] * y[other, :width])
    for m in range(6):
        for other in range(m):
            covariance[other, m] = covariance[m, other]
    return covariance
