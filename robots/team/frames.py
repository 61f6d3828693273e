"""How the robots' map frames lie in the world, well enough to begin the joint solution.

Surveyed starts first, then from robot to robot: by points known in both frames (shared tags, and places of
robots that saw one another), by compasses where they agree with one another, by laser where one tag is all
there is.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from math import atan2, cos, hypot, inf, sin, sqrt

import numpy as np

from robots.graph_report import GraphReport
from robots.se2 import Array, Pose2, wrap
from robots.team.meetings import Meeting
from robots.team.types import StartPose

BASELINE_M = 1.0  # two points nearer than this say too little about the rotation
BIAS_SD_RAD = 0.0175  # by which an aligned compass is off
_AGREE_SD = 3.0
_TAG_SD_M = 0.15  # of a tag against another in one robot's map,
_BENT = 0.03  # and this share of the distance between them
_MOST_POINTS = 24

Look = Callable[[str, str, str], Pose2 | None]
"""``first_from_second`` of two robots' maps by laser at a tag they share, any heading; None where unsure."""


@dataclass(frozen=True, slots=True, eq=False)
class _Point:
    """A point in a robot's own map and in the world. ``tag``: which robot and tag it comes from, if any."""

    own: Array
    world: Array
    sd_m: float
    tag: tuple[str, str] | None = None


def join_frames(
    graphs: Mapping[str, GraphReport],
    starts: Mapping[str, StartPose | None],
    meetings: Sequence[Meeting] = (),
    look: Look | None = None,
) -> dict[str, Pose2]:
    """Return ``world_from_map`` of every robot that can be placed.

    Robots with a surveyed start stand where it says; if none has one, the first robot's map is the world.
    Every other robot joins by the points it shares with those placed: two or more apart, or one and a compass
    that agrees with theirs, or one tag and a laser match round it. Points that contradict the rest (a tag
    that was moved, a wrong id) are outvoted. Those with more to go by join first.
    """
    frames = _surveyed(graphs, starts)
    if not frames and graphs:
        frames[min(graphs)] = Pose2()
    while True:
        waiting = [name for name in sorted(graphs) if name not in frames]
        shared = {name: _points(name, graphs, frames, meetings) for name in waiting}
        north = common_north(graphs, frames)
        turns = {
            name: north if np.isfinite(graphs[name].yaws_rad).any() else None for name in waiting
        }  # of its map, whose x axis is north where it has a compass
        joined = {name: fit for name in waiting if (fit := _by_points(shared[name], turns[name])) is not None}
        if not joined:
            for name in waiting:
                frame = _by_one_point(name, shared[name], turns[name], frames, look)
                if frame is not None:
                    joined[name] = frame
        if not joined:
            return frames
        frames.update(joined)


def common_north(graphs: Mapping[str, GraphReport], frames: Mapping[str, Pose2]) -> float | None:
    """Return the heading of north in the world as most placed robots' compasses show it.

    None where they contradict each other: then no compass can be believed unseen.
    """
    norths = [frames[name].theta for name in sorted(frames) if np.isfinite(graphs[name].yaws_rad).any()]
    if not norths:
        return None
    limit = _AGREE_SD * sqrt(2.0) * BIAS_SD_RAD + 0.05
    groups = [[n for n in norths if abs(wrap(n - m)) < limit] for m in norths]
    best = max(groups, key=len)
    if 2 * len(best) <= len(norths):
        return None
    return atan2(sum(map(sin, best)), sum(map(cos, best)))


def _surveyed(graphs: Mapping[str, GraphReport], starts: Mapping[str, StartPose | None]) -> dict[str, Pose2]:
    """Return the frames of surveyed robots; a vague heading gives way to the sharpest and a compass."""
    norths: dict[str, tuple[float, float]] = {}  # heading of north in the world, and its deviation
    for name, graph in graphs.items():
        start, yaw = starts.get(name), graph.yaws_rad[0]
        if start is not None and np.isfinite(yaw):
            norths[name] = wrap(start.pose.theta - float(yaw)), hypot(start.sd_rad, BIAS_SD_RAD)
    sharpest = min(norths.values(), key=lambda item: item[1], default=(0.0, inf))
    frames = {}
    for name, graph in graphs.items():
        start = starts.get(name)
        if start is None:
            continue
        pose = start.pose
        if name in norths:
            north, sd = norths[name]
            other = hypot(sharpest[1], BIAS_SD_RAD)
            if other < sd and abs(wrap(north - sharpest[0])) < _AGREE_SD * hypot(sd, other):
                pose = Pose2(pose.x, pose.y, wrap(sharpest[0] + float(graph.yaws_rad[0])))
        frames[name] = pose @ Pose2.from_array(graph.poses[0]).inverse()
    return frames


def _points(
    name: str, graphs: Mapping[str, GraphReport], frames: Mapping[str, Pose2], meetings: Sequence[Meeting]
) -> list[_Point]:
    own = graphs[name]
    places = dict(zip(own.tag_ids, own.tags, strict=True))
    found = []
    for other, frame in sorted(frames.items()):
        for tag, place in zip(graphs[other].tag_ids, graphs[other].tags, strict=True):
            if tag in places:
                world = np.array(frame.transform_point(float(place[0]), float(place[1])))
                found.append(_Point(places[tag], world, _TAG_SD_M, (other, tag)))
    for meeting in meetings:
        seer, seen = meeting.seer, meeting.seen
        if name not in (seer, seen):
            continue
        other = seen if name == seer else seer
        if other not in frames:
            continue
        by_seer = Pose2.from_array(graphs[seer].poses[meeting.pose]).transform(meeting.offset_m[None])[0]
        there = Pose2.from_array(graphs[seen].poses[meeting.there.anchor]) @ meeting.there.anchor_from_base
        by_seen = np.array([there.x, there.y])
        mine, theirs = (by_seer, by_seen) if name == seer else (by_seen, by_seer)
        sd = sqrt(float(np.trace(meeting.covariance)) / 2.0 + meeting.there.sd_m**2 + _TAG_SD_M**2)
        found.append(_Point(mine, frames[other].transform(theirs[None])[0], sd))
    stride = max(1, len(found) // _MOST_POINTS)
    return found[::stride]


def _by_points(points: list[_Point], compass: float | None) -> Pose2 | None:
    """Return the frame that most points agree on, where they tell the rotation by themselves."""
    best: list[_Point] = []
    most = 0.0
    for a, b in combinations(points, 2):
        along, there = b.own - a.own, b.world - a.world
        if min(np.hypot(*along), np.hypot(*there)) < BASELINE_M:
            continue
        turn = atan2(float(there[1]), float(there[0])) - atan2(float(along[1]), float(along[0]))
        agree = _agreeing(points, a, turn)
        if b not in agree:
            continue
        sd = _turn_sd(agree)
        believed = compass is not None and abs(wrap(turn - compass)) < _AGREE_SD * hypot(sd, 2 * BIAS_SD_RAD)
        score = len(agree) + (0.5 if believed else 0.0)
        if score > most:
            best, most = agree, score
    if len(best) < 2:
        return None
    turn, sd = _turn(best), _turn_sd(best)
    if compass is not None and abs(wrap(turn - compass)) < _AGREE_SD * hypot(sd, 2 * BIAS_SD_RAD):
        share = sd**2 / (sd**2 + 2.0 * BIAS_SD_RAD**2)
        turn += share * wrap(compass - turn)
    return _placed(best, turn)


def _by_one_point(
    name: str, points: list[_Point], compass: float | None, frames: Mapping[str, Pose2], look: Look | None
) -> Pose2 | None:
    """Return the frame by one point: with the rotation a laser match at that tag shows, or the compass."""
    for point in points:
        if look is not None and point.tag is not None:
            other, tag = point.tag
            other_from_own = look(other, name, tag)
            if other_from_own is not None:
                return frames[other] @ other_from_own
    if compass is None or not points:
        return None
    best = max((_agreeing(points, point, compass) for point in points), key=len)
    return _placed(best, compass)


def _agreeing(points: list[_Point], pivot: _Point, turn: float) -> list[_Point]:
    """Return the points that lie where a frame through ``pivot`` with this rotation puts them."""
    c, s = cos(turn), sin(turn)
    agree = []
    for point in points:
        x, y = point.own - pivot.own
        u, v = point.world - pivot.world
        gap = hypot(c * x - s * y - u, s * x + c * y - v)
        if gap <= _AGREE_SD * (hypot(point.sd_m, pivot.sd_m) + _BENT * hypot(x, y)):
            agree.append(point)
    return agree


def _turn(points: list[_Point]) -> float:
    """Return the rotation that lays the points' own places on those in the world (Umeyama 1991)."""
    weights = np.array([1.0 / point.sd_m**2 for point in points])[:, None]
    own, world = np.array([p.own for p in points]), np.array([p.world for p in points])
    a = own - (weights * own).sum(axis=0) / weights.sum()
    b = world - (weights * world).sum(axis=0) / weights.sum()
    across = (weights[:, 0] * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])).sum()
    return float(np.arctan2(across, (weights * a * b).sum()))


def _turn_sd(points: list[_Point]) -> float:
    """Return the standard deviation of that rotation."""
    weights = np.array([1.0 / (2.0 * point.sd_m**2) for point in points])[:, None]
    own = np.array([p.own for p in points])
    arms = own - (weights * own).sum(axis=0) / weights.sum()
    return hypot(1.0 / sqrt(max(float((weights * arms**2).sum()), 1e-9)), _BENT)


def _placed(points: list[_Point], turn: float) -> Pose2:
    weights = np.array([1.0 / point.sd_m**2 for point in points])[:, None]
    own = (weights * np.array([p.own for p in points])).sum(axis=0) / weights.sum()
    world = (weights * np.array([p.world for p in points])).sum(axis=0) / weights.sum()
    x, y = Pose2(0.0, 0.0, turn).transform_point(float(own[0]), float(own[1]))
    return Pose2(float(world[0]) - x, float(world[1]) - y, wrap(turn))
