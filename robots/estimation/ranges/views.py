"""Sightings by range as a batch solve takes them: rows beside links of a graph that stand for them.

Whoever wants a graph of places alone (the tests of tags, the joint covariances) gets each range as its
*tangent*: a sighting whose place and covariance say what the range says where the graph is, and nothing along
the circle round the antenna.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from robots.estimation.graph.problem import GraphProblem
from robots.estimation.ranges.factors import Ranges, expected_ranges
from robots.graph_report import GraphReport, IntArray
from robots.se2 import Array

_ANYWHERE_M = 100.0  # deviation along the circle
_LEAST_SD_M = 1e-4
_KERNEL_CHI2 = 9.0  # what is farther off than that counts for less


@dataclass(frozen=True, slots=True, eq=False)
class RangeViews:
    """Sightings by range and, where not NaN, bearing, row by row (q,).

    ``links``: the graph's links (edges, then sightings) that stand for them; ``radios``: which of k
    instruments; ``series``: rows of one number are of one instrument and one thing seen; ``arms`` (q, 3) the
    antenna in the frame of the pose; ``range_sds_m`` at the range measured; ``scales`` (k,) and ``offsets_m``
    (m,) of each tag: what is believed to begin with; their deviations are those about 1 and 0.
    """

    links: IntArray
    radios: IntArray
    series: IntArray
    stamps_s: Array
    arms: Array
    ranges_m: Array
    range_sds_m: Array
    bearings_rad: Array
    bearing_sds_rad: Array
    scales: Array
    scale_sds: Array
    offsets_m: Array
    offset_sds_m: Array

    def sds_at(self, expected_m: Array) -> Array:
        """Return the deviations (q,) of ranges that ought to have been ``expected_m`` (q,).

        What the instrument's deviations are at each range is read off the rows themselves, as a + b r.
        """
        found = np.empty(len(expected_m))
        for radio in np.unique(self.radios):
            rows = self.radios == radio
            measured, sds = self.ranges_m[rows], self.range_sds_m[rows]
            slope = np.cov(measured, sds, bias=True)[0, 1] / max(float(np.var(measured)), 1e-9)
            slope = min(max(float(slope), 0.0), float(np.mean(sds) / max(np.mean(measured), 1e-9)))
            base = float(np.mean(sds) - slope * np.mean(measured))
            here = np.maximum(base + slope * measured, _LEAST_SD_M)
            found[rows] = sds * np.maximum(base + slope * expected_m[rows], _LEAST_SD_M) / here
        return found


def views_of(report: GraphReport, links_from: int) -> RangeViews:
    """Return the ranges of a report; its graph has their links from ``links_from`` on (``as_sightings``)."""
    tags = report.range_pairs[:, 1]
    offsets = report.range_offsets_m
    return RangeViews(
        links=links_from + np.arange(len(tags)),
        radios=np.zeros(len(tags), np.int64),
        series=tags,
        stamps_s=report.stamps_s[report.range_pairs[:, 0]],
        arms=report.range_poses,
        ranges_m=report.ranges_m,
        range_sds_m=report.range_sds_m,
        bearings_rad=report.bearings_rad,
        bearing_sds_rad=report.bearing_sds_rad,
        scales=np.array([report.range_scale]),
        scale_sds=np.array([report.range_scale_sd]),
        offsets_m=offsets if len(offsets) == len(report.tag_ids) else np.zeros(len(report.tag_ids)),
        offset_sds_m=np.full(len(report.tag_ids), report.range_offset_sd_m),
    )


def as_sightings(report: GraphReport) -> GraphReport:
    """Return the report with its ranges appended to its sightings, as their tangents at its own places."""
    if not len(report.range_pairs):
        return report
    poses, tags = report.range_pairs.T
    scale = np.where(np.isnan(report.bearings_rad), report.range_scale, 1.0)
    offsets = np.where(np.isnan(report.bearings_rad), views_of(report, 0).offsets_m[tags], 0.0)
    places, spreads = _tangent(
        report.range_poses,
        _directions(report.poses[poses], report.range_poses, report.tags[tags], report.bearings_rad),
        (report.ranges_m - offsets) / scale,
        report.range_sds_m / scale,
        report.bearing_sds_rad,
    )
    return replace(
        report,
        sighting_pairs=np.concatenate([report.sighting_pairs, report.range_pairs]),
        sighting_offsets=np.concatenate([report.sighting_offsets, places]),
        sighting_covariances=np.concatenate([report.sighting_covariances, spreads]),
    )


def tangents(graph: GraphProblem, views: RangeViews, state: Array, ranges: Ranges) -> GraphProblem:
    """Return the graph with the links that stand for ranges made their tangents at ``state``."""
    _, errors = expected_ranges(state, ranges)
    directed = ~np.isnan(views.bearings_rad)
    scale = np.where(directed, 1.0, state[ranges.radios, 0])
    offsets = np.where(directed, 0.0, state[ranges.seen, 2])
    directions = _directions(state[ranges.poses], views.arms, state[ranges.seen, :2], np.nan)
    places, spreads = _tangent(
        views.arms,
        np.where(directed, directions - errors[:, 1], directions),
        (views.ranges_m - offsets) / scale,
        ranges.sds / scale / np.sqrt(ranges.shares[:, 0]),
        ranges.bearing_sds / np.sqrt(ranges.shares[:, 1]),
    )
    edges = len(graph.edge_pairs)
    seen = views.links >= edges
    sightings = views.links[seen] - edges
    found = graph.sighting_offsets.copy(), graph.sighting_covariances.copy()
    found[0][sightings], found[1][sightings] = places[seen], spreads[seen]
    graph = replace(graph, sighting_offsets=found[0], sighting_covariances=found[1])
    if seen.all() or graph.edge_information is None:
        return graph
    poses, information = graph.edge_poses.copy(), graph.edge_information.copy()
    met = views.links[~seen]
    poses[met, :2] = places[~seen]
    away = (errors / np.column_stack([ranges.sds, ranges.bearing_sds]))[~seen] ** 2
    believed = np.minimum(1.0, _KERNEL_CHI2 / np.maximum((ranges.shares[~seen] * away).sum(axis=1), 1e-12))
    information[met, :2, :2] = np.linalg.inv(spreads[~seen]) * believed[:, None, None]
    robust = None if graph.edge_robust is None else graph.edge_robust.copy()
    if robust is not None:
        robust[met] = False  # the batch has let go of what is wrong
    return replace(graph, edge_poses=poses, edge_information=information, edge_robust=robust)


def _directions(poses: Array, arms: Array, tags: Array, bearings: Array | float) -> Array:
    """Return the directions (q,) of tags from antennas in the poses' frames: as measured, or as they are."""
    c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    dx, dy = (tags - poses[:, :2]).T
    there = np.arctan2(-s * dx + c * dy - arms[:, 1], c * dx + s * dy - arms[:, 0])
    return np.asarray(np.where(np.isnan(bearings), there, arms[:, 2] + bearings))


def _tangent(
    arms: Array, directions: Array, ranges: Array, sds: Array, bearing_sds: Array
) -> tuple[Array, Array]:
    """Return places (q, 2) in the poses' frames and their covariances (q, 2, 2)."""
    c, s = np.cos(directions), np.sin(directions)
    places = arms[:, :2] + ranges[:, None] * np.column_stack([c, s])
    across = np.where(np.isnan(bearing_sds), _ANYWHERE_M, bearing_sds * np.maximum(ranges, sds)) ** 2
    along = sds**2
    spreads = np.empty((len(ranges), 2, 2))
    spreads[:, 0, 0] = c * c * along + s * s * across
    spreads[:, 1, 1] = s * s * along + c * c * across
    spreads[:, 0, 1] = spreads[:, 1, 0] = c * s * (along - across)
    return places, spreads
