"""How far all ranges to a tag may have moved it: walls lengthen what is measured through them alike.

A batch of ranges takes their errors for independent but for some seconds. What stands between a tag and a
stretch of the way stays there: however often it is measured, a part of the error is the same. It is
*considered* (Schmidt 1966): not solved for, but counted in the covariance of the place.
"""

from __future__ import annotations

import numpy as np

from robots.estimation.graph.problem import GraphProblem
from robots.estimation.ranges.errors import shares
from robots.estimation.ranges.smoothing import RangeSolution
from robots.estimation.ranges.views import RangeViews
from robots.graph_report import IntArray
from robots.se2 import Array

_SECTORS = 8  # round a tag: a wall hides about so much
_LASTING = 0.7  # of a range's deviation: by signal 0.2 in ln d, three quarters of a wall where n = 2
_NEAREST_M = 0.1


def range_doubts(views: RangeViews, batch: RangeSolution) -> Array:
    """Return what lasting errors of ranges without bearing add to the covariance of each tag, (m, 2, 2).

    The poses are taken as they are. Sector k of a tag, whose ranges are all off by b of their deviations s:
        A = sum h h^T / s^2 + prior + passings,    g_k = b A^-1 sum_k h / s,    added: sum_k g_k g_k^T
    with h the direction to the tag and the one of its offset, each range counted by its share.
    """
    graph, heard = batch.graph, np.flatnonzero(np.isnan(views.bearings_rad))
    poses, tags = graph.sighting_pairs[views.links[heard] - len(graph.edge_pairs)].T
    away = graph.tags[tags] - _antennas(graph.poses[poses], views.arms[heard])
    far = np.maximum(np.hypot(*away.T), _NEAREST_M)
    scales, expected = batch.scales[views.radios[heard]], views.ranges_m.copy()
    expected[heard] = scales * far + batch.offsets_m[tags]
    sds = views.sds_at(expected)[heard] / scales
    root = np.sqrt(shares(views.stamps_s, views.series, batch.lasts_s[0])[heard])
    rows = np.column_stack([away / far[:, None], 1.0 / scales]) * (root / sds)[:, None]
    sector = np.floor(np.arctan2(away[:, 1], away[:, 0]) / (2.0 * np.pi / _SECTORS)).astype(np.int64)
    added, passed = np.zeros((len(graph.tags), 2, 2)), _passings(graph, views.links)
    for tag in np.unique(tags):
        own = tags == tag
        known = rows[own].T @ rows[own]
        known[:2, :2] += passed[tag]
        known[2, 2] += max(float(views.offset_sds_m[tag]), 1e-4) ** -2.0
        for each in np.unique(sector[own]):
            there = own & (sector == each)
            moved = np.linalg.lstsq(known, _LASTING * rows[there].T @ root[there], rcond=1e-9)[0][:2]
            added[tag] += np.outer(moved, moved)
    return added


def _antennas(poses: Array, arms: Array) -> Array:
    c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    turned = np.column_stack([c * arms[:, 0] - s * arms[:, 1], s * arms[:, 0] + c * arms[:, 1]])
    places: Array = poses[:, :2] + turned
    return places


def _passings(graph: GraphProblem, links: IntArray) -> Array:
    """Return the information (m, 2, 2) of a tag's place in the sightings that are no ranges."""
    found = np.zeros((len(graph.tags), 2, 2))
    others = np.setdiff1d(np.arange(len(graph.sighting_pairs)), links - len(graph.edge_pairs))
    for pose, tag, spread in zip(
        *graph.sighting_pairs[others].T, graph.sighting_covariances[others], strict=True
    ):
        c, s = np.cos(graph.poses[pose, 2]), np.sin(graph.poses[pose, 2])
        turn = np.array([[c, -s], [s, c]])
        found[tag] += np.linalg.inv(turn @ spread @ turn.T)
    return found
