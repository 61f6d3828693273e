"""What the robots of a team saw by range, tags and one another, for one batch solve of all."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields
from math import atan2, hypot, sqrt

import numpy as np

from robots.estimation.ranges.views import RangeViews, views_of
from robots.graph_report import GraphReport
from robots.se2 import wrap
from robots.team.meetings import Meeting

_LEAST_M = 1e-3


def joint_views(
    graphs: Mapping[str, GraphReport],
    names: Sequence[str],
    tag_index: Mapping[str, int],
    meetings: Sequence[Meeting],
    met_from: int,
    edges: int,
) -> RangeViews | None:
    """Return the ranges of all ``names`` as links of their joint problem; None where none saw a tag so.

    ``met_from``: the edge before which the edges of the meetings begin, two of each: where the other was by
    its own account, and what the seer saw. ``edges``: how many there are before the sightings.
    """
    offsets, offset_sds = np.zeros(len(tag_index)), np.ones(len(tag_index))
    parts, begin = [], edges
    for radio, name in enumerate(names):
        graph = graphs[name]
        begin += len(graph.sighting_pairs)
        views = views_of(graph, begin)
        begin += len(views.links)
        to_team = np.array([tag_index[tag] for tag in graph.tag_ids], np.int64)
        offsets[to_team] = views.offsets_m
        offset_sds[to_team] = views.offset_sds_m
        series = to_team[views.series] if len(views.series) else views.series
        parts.append((views, np.full(len(views.links), radio), radio * len(tag_index) + series))
    if not any(len(views.links) for views, _, _ in parts):
        return None
    parts.append(
        _met(names, [m for m in meetings if m.seer in names and m.seen in names], met_from, tag_index)
    )
    rows = {
        item.name: np.concatenate([getattr(views, item.name) for views, _, _ in parts])
        for item in fields(RangeViews)
        if item.name not in ("radios", "series", "scales", "scale_sds", "offsets_m", "offset_sds_m")
    }
    return RangeViews(
        radios=np.concatenate([radios for _, radios, _ in parts]),
        series=np.concatenate([series for _, _, series in parts]),
        scales=np.array([graphs[name].range_scale for name in names]),
        scale_sds=np.array([graphs[name].range_scale_sd for name in names]),
        offsets_m=offsets,
        offset_sds_m=offset_sds,
        **rows,
    )


def _met(
    names: Sequence[str], meetings: Sequence[Meeting], met_from: int, tag_index: Mapping[str, int]
) -> tuple[RangeViews, np.ndarray, np.ndarray]:
    """Return what robots saw of one another, by whom, and the series of each pair."""
    rows = []
    for meeting in meetings:
        x, y = meeting.offset_m - meeting.base[:2]
        distance = max(hypot(x, y), _LEAST_M)
        u, v = np.array([x, y]) / distance, np.array([-y, x]) / distance
        along = sqrt(float(u @ meeting.covariance @ u))
        across = sqrt(float(v @ meeting.covariance @ v)) / distance
        bearing = wrap(atan2(y, x) - float(meeting.base[2]))
        rows.append((*meeting.base, distance, along, bearing, across, meeting.stamp_s))
    table = np.array(rows).reshape(-1, 8)
    seers = np.array([names.index(meeting.seer) for meeting in meetings], np.int64)
    seen = np.array([names.index(meeting.seen) for meeting in meetings], np.int64)
    views = RangeViews(
        links=met_from + 1 + 2 * np.arange(len(rows)),
        radios=seers,
        series=seen,
        stamps_s=table[:, 7],
        arms=table[:, :3],
        ranges_m=table[:, 3],
        range_sds_m=table[:, 4],
        bearings_rad=table[:, 5],
        bearing_sds_rad=table[:, 6],
        scales=np.zeros(0),
        scale_sds=np.zeros(0),
        offsets_m=np.zeros(0),
        offset_sds_m=np.zeros(0),
    )
    return views, seers, len(names) * len(tag_index) + seers * len(names) + seen
