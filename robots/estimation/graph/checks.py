"""What the incremental solver looks at again after a step: bent links, and what robust ones are worth."""

from __future__ import annotations

from math import cos, sin, sqrt

import numpy as np
from numba import njit

from robots.estimation.graph.factors import between_jacobian, link_chi2, link_error
from robots.estimation.graph.fronts import joint_covariance
from robots.estimation.graph.panels import Links, Panels, Vertices
from robots.graph_report import IntArray

SETTLED = 0.02  # a weight that changes by less stays, one that is less counts for nothing
_BELIEVED = 0.5
_ALONE = 1e-6  # share of a link that others measure too: below it none does
_ENDS = np.array([[0, 1]])


@njit(cache=True)
def bent(vertices: Vertices, links: Links, changed: IntArray, bend_sd: float) -> tuple[IntArray, float]:
    """Return the vertices to linearise anew, (m,), and the largest error of the linear form, in deviations.

    Of a link e' = e + J d is held against its true error at the estimate. Errors are linear but for the
    heading of the link's first vertex, so that vertex is the one to move.
    """
    found, n, worst = np.empty(16, np.int64), 0, 0.0
    flagged = np.zeros(len(vertices.panel), np.bool_)
    for v in changed:
        k = vertices.link[v]
        while k >= 0:
            a, b = links.pairs[k, 0], links.pairs[k, 1]
            d = vertices.step[a]
            if not flagged[a] and d[2] != 0.0:
                x, o = vertices.state[a], links.information[k]
                dx, dy = vertices.state[b, 0] - x[0], vertices.state[b, 1] - x[1]
                sx, sy = vertices.step[b, 0] - d[0], vertices.step[b, 1] - d[1]
                most = abs(d[2]) * (abs(d[2]) * (abs(dx) + abs(dy)) + abs(sx) + abs(sy))
                if links.weight[k] * (o[0, 0] + o[1, 1]) * most * most < bend_sd * bend_sd:
                    k = links.following[k, 0 if a == v else 1]
                    continue
                c, s = cos(x[2]), sin(x[2])
                c2, s2 = cos(x[2] + d[2]), sin(x[2] + d[2])
                ux, uy = sx + dy * d[2], sy - dx * d[2]  # J d turned into the frame of the map
                ex = c2 * (dx + sx) + s2 * (dy + sy) - (c * (dx + ux) + s * (dy + uy))
                ey = -s2 * (dx + sx) + c2 * (dy + sy) - (-s * (dx + ux) + c * (dy + uy))
                square = links.weight[k] * (o[0, 0] * ex * ex + 2.0 * o[0, 1] * ex * ey + o[1, 1] * ey * ey)
                worst = max(worst, square)
                if square > bend_sd * bend_sd:
                    flagged[a] = True
                    if n == len(found):
                        more = np.empty(2 * n, np.int64)
                        more[:n] = found
                        found = more
                    found[n] = a
                    n += 1
            k = links.following[k, 0 if a == v else 1]
    return found[:n], sqrt(worst)


@njit(cache=True)
def _weight(square: float, kernel_sd: float) -> float:
    """Return the weight of the redescending kernel, see ``graph_factors.Kernel``."""
    limit = kernel_sd * kernel_sd
    if square <= limit:
        return 1.0
    share = 2.0 * limit / (limit + square)
    return share * share


@njit(cache=True)
def weigh_again(
    vertices: Vertices, links: Links, changed: IntArray, kernel_sd: float, least: float
) -> IntArray:
    """Weigh the robust links of vertices that changed by their residuals.

    Return the vertices of those whose weight changed by more than ``least``.
    """
    concerned = np.zeros(len(vertices.panel), np.bool_)
    for v in changed:
        k = vertices.link[v]
        while k >= 0:
            a, b = links.pairs[k, 0], links.pairs[k, 1]
            if links.robust[k]:
                estimates = vertices.state[links.pairs[k]] + vertices.step[links.pairs[k]]
                one = slice(k, k + 1)
                square = link_chi2(estimates, _ENDS, links.measured[one], links.information[one])[0]
                weight = _weight(square, kernel_sd)
                if abs(weight - links.weight[k]) > least:
                    links.weight[k] = weight
                    concerned[a] = concerned[b] = True
            k = links.following[k, 0 if a == v else 1]
    return np.flatnonzero(concerned)


def innovation(vertices: Vertices, links: Links, panels: Panels, k: int) -> float:
    """Return the squared distance of link k from what all others say of it.

    A link that bends its surroundings into place has a small residual, right or wrong. So it is taken out
    again, by the formula of the rank-3 update, and its error held against the covariance of what is predicted
    without it. Directions in which nothing else says anything do not count.
    """
    a, b = links.pairs[k].tolist()
    x, y = vertices.state[[a, b]] + vertices.step[[a, b]]
    error = np.array(link_error(x, y, links.measured[k]))
    J = between_jacobian(x, y)
    S = J @ joint_covariance(vertices, panels, a, b) @ J.T
    values, vectors = np.linalg.eigh(links.information[k])
    white = (vectors * np.sqrt(np.maximum(values, 0.0))).T
    known, axes = np.linalg.eigh(white @ S @ white.T)
    redundancy = 1.0 - links.weight[k] * known
    heard = redundancy > _ALONE
    along = (axes.T @ (white @ error))[heard]
    left = redundancy[heard]
    return float(np.sum(along**2 / (left * (left + known[heard]))))


def believable(
    vertices: Vertices, links: Links, panels: Panels, waiting: list[int], kernel_sd: float
) -> list[int]:
    """Weigh robust links that are not yet part of the graph; return those that are worth anything."""
    found: list[int] = []
    for k in waiting:
        links.weight[k] = 0.0
        weight = _weight(innovation(vertices, links, panels, k), kernel_sd)
        if weight > SETTLED:
            links.weight[k] = weight
            found.append(k)
    return found


def doubt_worst(vertices: Vertices, links: Links, panels: Panels, count: int, kernel_sd: float) -> IntArray:
    """Let go of the believed link that all others contradict the most; return its vertices, none if none is.

    One at a time: of two that contradict each other one may be right (data snooping, Baarda 1968).
    """
    worst, least = -1, _BELIEVED
    for k in range(count):
        a, b = links.pairs[k].tolist()
        if links.robust[k] and a != b and links.weight[k] >= _BELIEVED:
            weight = _weight(innovation(vertices, links, panels, k), kernel_sd)
            if weight < least:
                worst, least = k, weight
    if worst < 0:
        return np.zeros(0, np.int64)
    links.weight[worst] = least
    pair: IntArray = links.pairs[worst].copy()
    return pair
