"""Loops between robots by laser: where two have read one tag, what their submaps show round it is matched.

The clouds are cut out round the tag and laid down with the map's north up, so that two robots' clouds of one
tag lie on each other but for compasses and antennas. Every pair of finished submaps is matched once: what is
known of a match depends on the two submaps and a guess that is rounded to a lattice, never on when it was
made.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import hypot, pi

import numpy as np

from robots.estimation.scans.cloud_matching import Cloud, CloudMatch, Window, match_clouds
from robots.graph_report import GraphReport
from robots.mapping.clouds import surface_points
from robots.mapping.submap import unpack
from robots.se2 import Array, Pose2, compose_jacobians, wrap
from robots.types import SubmapReport

_REACH_M = 4.0  # of what lies round the tag
_LEAST_POINTS = 60
_WINDOW = Window(0.6, 0.3)
_ANY_HEADING = Window(0.6, pi)
_OVERLAP, _MARGIN, _RMS_M = 0.7, 0.1, 0.05  # a match that is believed; the kernel guards against the rest,
_SURE_MARGIN = 0.25  # but not where a whole map hangs on it
_PER_PAIR = 5  # matches of two robots,
_APART_M = 3.0  # at tags so far apart
_STEP_M, _STEP_RAD = 0.2, 0.1  # of the lattice
_SD_M, _SD_RAD = 0.03, 0.012  # by which submaps are bent between anchor and tag,
_SD_SHARE = 0.015  # and more with the distance


@dataclass(frozen=True, slots=True, eq=False)
class TeamLoop:
    """A laser match of two robots' submaps.

    ``pose`` (3,): pose vertex ``second_pose`` of robot ``second`` in vertex ``first_pose`` of robot
    ``first``, with its covariance (3, 3).
    """

    first: str
    first_pose: int
    second: str
    second_pose: int
    pose: Array
    covariance: Array


@dataclass(frozen=True, slots=True)
class _View:
    """A robot's cloud round a tag: the submap it is cut out of, and where the cut lies in the anchor's frame.

    ``anchor_from_cut``: at the tag, x axis along that of the robot's map; rounded.
    """

    robot: str
    anchor: int
    version: int
    anchor_from_cut: Pose2


class LaserLoops:
    """Matches of submaps, each made once."""

    def __init__(self) -> None:
        self._surfaces: dict[tuple[str, int], tuple[int, Array, Array]] = {}
        self._matches: dict[tuple[_View, _View, Pose2, float], CloudMatch | None] = {}
        self._used: set[tuple[_View, _View, Pose2, float]] = set()

    def begin(self) -> None:
        """Begin a solution: matches that it does not ask for are forgotten at its end."""
        self._used.clear()

    def end(self) -> None:
        """Forget what this solution did not ask for."""
        self._matches = {key: match for key, match in self._matches.items() if key in self._used}

    def between(
        self,
        graphs: Mapping[str, GraphReport],
        submaps: Mapping[str, Mapping[int, SubmapReport]],
        frames: Mapping[str, Pose2],
    ) -> tuple[TeamLoop, ...]:
        """Return the loops between all pairs of robots that have a frame."""
        names = sorted(frames)
        loops = []
        for k, second in enumerate(names):
            for first in names[:k]:
                turn = _rounded(wrap(frames[second].theta - frames[first].theta), _STEP_RAD)
                for tag in _shared_tags(graphs[first], graphs[second]):
                    views = self._views(first, second, tag, graphs, submaps)
                    if views is None:
                        continue
                    match = self._matched(*views, Pose2(0.0, 0.0, turn), _WINDOW)
                    if match is not None and _is_good(match, _MARGIN):
                        loops.append(_loop(*views, match))
        return tuple(loops)

    def at_tag(
        self,
        first: str,
        second: str,
        tag: str,
        graphs: Mapping[str, GraphReport],
        submaps: Mapping[str, Mapping[int, SubmapReport]],
    ) -> Pose2 | None:
        """Return ``first_from_second`` of two robots' maps by a match of any heading; None where unsure."""
        views = self._views(first, second, tag, graphs, submaps)
        if views is None:
            return None
        match = self._matched(*views, Pose2(), _ANY_HEADING)
        if match is None or not _is_good(match, _SURE_MARGIN):
            return None
        loop = _loop(*views, match)
        first_from_anchor = Pose2.from_array(graphs[first].poses[loop.first_pose])
        second_from_anchor = Pose2.from_array(graphs[second].poses[loop.second_pose])
        return first_from_anchor @ Pose2.from_array(loop.pose) @ second_from_anchor.inverse()

    def _views(
        self,
        first: str,
        second: str,
        tag: str,
        graphs: Mapping[str, GraphReport],
        submaps: Mapping[str, Mapping[int, SubmapReport]],
    ) -> tuple[_View, _View] | None:
        a = self._view(first, tag, graphs[first], submaps[first])
        b = self._view(second, tag, graphs[second], submaps[second])
        return None if a is None or b is None else (a, b)

    def _view(
        self, robot: str, tag: str, graph: GraphReport, submaps: Mapping[int, SubmapReport]
    ) -> _View | None:
        """Return the finished submap that shows most round a tag; the newest one is still being written."""
        finished = sorted(anchor for anchor in submaps if anchor < len(graph.poses))[:-1]
        index = graph.tag_ids.index(tag)
        near: set[int] = set()
        for pose in graph.sighting_pairs[graph.sighting_pairs[:, 1] == index, 0]:
            near |= set([anchor for anchor in finished if anchor <= pose][-2:])
        best, most = None, _LEAST_POINTS - 1
        for anchor in sorted(near):
            map_from_anchor = Pose2.from_array(graph.poses[anchor])
            x, y = map_from_anchor.inverse().transform_point(*(float(v) for v in graph.tags[index]))
            points, _ = self._surface(robot, submaps[anchor])
            count = int((np.hypot(points[:, 0] - x, points[:, 1] - y) < _REACH_M).sum())
            if count > most:
                cut = Pose2(
                    _rounded(x, _STEP_M), _rounded(y, _STEP_M), _rounded(-map_from_anchor.theta, _STEP_RAD)
                )
                best, most = _View(robot, anchor, submaps[anchor].version, cut), count
        return best

    def _surface(self, robot: str, report: SubmapReport) -> tuple[Array, Array]:
        known = self._surfaces.get((robot, report.anchor))
        if known is None or known[0] != report.version:
            known = (report.version, *surface_points(report, unpack(report)))
            self._surfaces[robot, report.anchor] = known
        return known[1], known[2]

    def _cloud(self, view: _View) -> Cloud:
        _, points, normals = self._surfaces[view.robot, view.anchor]
        cut = view.anchor_from_cut
        inside = np.hypot(points[:, 0] - cut.x, points[:, 1] - cut.y) < _REACH_M
        turn = Pose2(0.0, 0.0, -cut.theta)
        return Cloud(cut.inverse().transform(points[inside]), turn.transform(normals[inside]))

    def _matched(self, a: _View, b: _View, guess: Pose2, window: Window) -> CloudMatch | None:
        key = (a, b, guess, window.turn_rad)
        self._used.add(key)
        if key not in self._matches:
            self._matches[key] = match_clouds(self._cloud(a), self._cloud(b), guess, window)
        return self._matches[key]


def _shared_tags(first: GraphReport, second: GraphReport) -> Sequence[str]:
    """Return the tags at which two robots' maps are matched: the earliest known to both, some way apart."""
    seen_a, seen_b = _first_stamps(first), _first_stamps(second)
    both = sorted((max(stamp, seen_b[tag]), tag) for tag, stamp in seen_a.items() if tag in seen_b)
    places = dict(zip(first.tag_ids, first.tags, strict=True))
    chosen: list[str] = []
    for _, tag in both:
        if len(chosen) < _PER_PAIR and all(_far(places[tag], places[other]) for other in chosen):
            chosen.append(tag)
    return chosen


def _first_stamps(graph: GraphReport) -> dict[str, float]:
    stamps: dict[str, float] = {}
    for pose, tag in graph.sighting_pairs:
        name, stamp = graph.tag_ids[int(tag)], float(graph.stamps_s[int(pose)])
        stamps[name] = min(stamp, stamps.get(name, stamp))
    return stamps


def _far(a: Iterable[float], b: Iterable[float]) -> bool:
    (ax, ay), (bx, by) = a, b
    return hypot(ax - bx, ay - by) >= _APART_M


def _is_good(match: CloudMatch, margin: float) -> bool:
    return match.overlap >= _OVERLAP and match.margin >= margin and match.rms_m <= _RMS_M


def _loop(a: _View, b: _View, match: CloudMatch) -> TeamLoop:
    """Return the match between cuts as one between anchors, with its covariance carried along."""
    cut_from_anchor = b.anchor_from_cut.inverse()
    first_from_cut = a.anchor_from_cut @ match.pose.mean
    _, by_match = compose_jacobians(a.anchor_from_cut, match.pose.mean)
    by_cut, _ = compose_jacobians(first_from_cut, cut_from_anchor)
    jacobian = by_cut @ by_match
    away_m = sum(hypot(view.anchor_from_cut.x, view.anchor_from_cut.y) for view in (a, b))
    bent_m = hypot(_SD_M, _SD_SHARE * away_m)
    bent = np.diag([bent_m**2, bent_m**2, _SD_RAD**2])
    return TeamLoop(
        a.robot,
        a.anchor,
        b.robot,
        b.anchor,
        (first_from_cut @ cut_from_anchor).as_array(),
        jacobian @ (match.pose.covariance + bent) @ jacobian.T,
    )


def _rounded(value: float, step: float) -> float:
    return round(value / step) * step
