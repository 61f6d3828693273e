"""The union of the robots' tag graphs as one problem in the world frame.

Beside the robots' own poses it has one vertex for the place of a robot at the moment another saw it, and one
per compass: its heading is that of north as this compass shows it, so that the offset of a compass is
estimated. Compasses that agree are tied to a common north.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robots.estimation.graph.solve import GraphProblem
from robots.estimation.ranges.views import RangeViews, as_sightings
from robots.graph_report import GraphReport, IntArray
from robots.se2 import Array, Pose2
from robots.team.frames import BIAS_SD_RAD
from robots.team.laser_loops import TeamLoop
from robots.team.meetings import Meeting
from robots.team.ranges import joint_views
from robots.team.types import StartPose

_HEADING_SD_RAD = 0.035  # of a compass, for minutes at a time
_HELD_SD = 1e-3  # what holds the world in place where nobody surveyed it
_ANYWHERE = 1e3  # deviation of what is not known: metres, or radians


@dataclass(frozen=True, slots=True, eq=False)
class JointProblem:
    """The joint problem and whose is what in it.

    ``begins``: index of each robot's first pose; ``norths``: index of the vertex of its compass; ``stamps_s``
    and ``readers`` (s,) when and by which of ``names`` each sighting was made; ``ways`` (w,): edges that are
    displacements driven, ``drivers`` (w,) by whom; ``ties``: the edge that ties a compass to the common
    north; ``ranges``: what was seen by range, where links of the problem are but tangents.
    """

    problem: GraphProblem
    names: tuple[str, ...]
    tag_ids: tuple[str, ...]
    begins: dict[str, int]
    norths: dict[str, int]
    stamps_s: Array
    readers: IntArray
    ways: IntArray
    drivers: IntArray
    ties: dict[str, int]
    ranges: RangeViews | None


class _Edges:
    """Edges as they are gathered."""

    def __init__(self) -> None:
        self.pairs: list[IntArray] = []
        self.poses: list[Array] = []
        self.information: list[Array] = []
        self.robust: list[NDArray[np.bool_]] = []

    def add(self, pairs: ArrayLike, poses: ArrayLike, information: ArrayLike, robust: bool) -> None:
        self.pairs.append(np.asarray(pairs, np.int64).reshape(-1, 2))
        self.poses.append(np.asarray(poses, np.float64).reshape(-1, 3))
        self.information.append(np.asarray(information, np.float64).reshape(-1, 3, 3))
        self.robust.append(np.full(len(self.pairs[-1]), robust))

    @property
    def count(self) -> int:
        return sum(map(len, self.pairs))


def joint_problem(
    graphs: Mapping[str, GraphReport],
    starts: Mapping[str, StartPose | None],
    frames: Mapping[str, Pose2],
    *,
    loops: Sequence[TeamLoop] = (),
    meetings: Sequence[Meeting] = (),
    tied: frozenset[str] | None = None,
) -> JointProblem:
    """Return the union of the graphs of all robots that have a frame.

    ``tied``: robots whose compasses are held to agree; all by default.
    """
    names = tuple(sorted(frames))
    tag_ids = tuple(sorted({tag for name in names for tag in graphs[name].tag_ids}))
    tag_index = {tag: k for k, tag in enumerate(tag_ids)}
    tags = np.zeros((len(tag_ids), 2))
    for name in reversed(names):  # the first robot's places of shared tags are the ones that stand
        for tag, place in zip(graphs[name].tag_ids, frames[name].transform(graphs[name].tags), strict=True):
            tags[tag_index[tag]] = place
    begins: dict[str, int] = {}
    poses: list[Array] = []
    count = 0
    edges = _Edges()
    ways, drivers, sightings, stamps, readers, placed = [], [], [], [], [], []
    for index, name in enumerate(names):
        graph = as_sightings(graphs[name])
        begins[name] = count
        poses.append(moved(frames[name], graph.poses))
        ways.append(edges.count + np.arange(len(graph.edge_pairs)))
        drivers.append(np.full(len(graph.edge_pairs), index))
        edges.add(graph.edge_pairs + count, graph.edge_poses, np.linalg.inv(graph.edge_covariances), False)
        edges.add(graph.loop_pairs + count, graph.loop_poses, np.linalg.inv(graph.loop_covariances), True)
        to_team = np.array([tag_index[tag] for tag in graph.tag_ids], np.int64)
        pairs = graph.sighting_pairs
        sightings.append(
            np.column_stack([pairs[:, 0] + count, to_team[pairs[:, 1]]]) if len(pairs) else pairs
        )
        placed.append(graph)
        stamps.append(graph.stamps_s[pairs[:, 0]])
        readers.append(np.full(len(pairs), index))
        count += len(graph.poses)
    for loop in loops:
        if loop.first in begins and loop.second in begins:
            pair = [begins[loop.first] + loop.first_pose, begins[loop.second] + loop.second_pose]
            edges.add(pair, loop.pose, np.linalg.inv(loop.covariance), True)
    met_from = edges.count
    count = _add_meetings(meetings, begins, poses, count, edges)
    agreeing = frozenset(names) if tied is None else tied
    norths, ties, priors = _add_norths(graphs, frames, begins, poses, count, edges, agreeing)
    priors += _held(names, graphs, starts, begins, np.concatenate(poses))
    problem = GraphProblem(
        poses=np.concatenate(poses),
        tags=tags,
        edge_pairs=np.concatenate(edges.pairs),
        edge_poses=np.concatenate(edges.poses),
        edge_covariances=np.tile(np.eye(3), (edges.count, 1, 1)),
        sighting_pairs=np.concatenate(sightings).astype(np.int64),
        sighting_offsets=np.concatenate([graph.sighting_offsets for graph in placed]),
        sighting_covariances=np.concatenate([graph.sighting_covariances for graph in placed]),
        prior_index=np.array([vertex for vertex, _, _ in priors], np.int64),
        prior_poses=np.array([pose for _, pose, _ in priors]),
        prior_sds=np.array([sds for _, _, sds in priors]),
        edge_information=np.concatenate(edges.information),
        edge_robust=np.concatenate(edges.robust),
    )
    return JointProblem(
        problem=problem,
        names=names,
        tag_ids=tag_ids,
        begins=begins,
        norths=norths,
        stamps_s=np.concatenate(stamps),
        readers=np.concatenate(readers),
        ways=np.concatenate(ways),
        drivers=np.concatenate(drivers),
        ties=ties,
        ranges=joint_views(graphs, names, tag_index, meetings, met_from, edges.count),
    )


def moved(frame: Pose2, poses: Array) -> Array:
    """Return poses (n, 3) in the frame's parent."""
    moved = poses.copy()
    moved[:, :2] = frame.transform(poses[:, :2])
    moved[:, 2] += frame.theta
    return moved


_Prior = tuple[int, Array, Array]  # vertex, pose, deviations


def _held(
    names: tuple[str, ...],
    graphs: Mapping[str, GraphReport],
    starts: Mapping[str, StartPose | None],
    begins: Mapping[str, int],
    poses: Array,
) -> list[_Prior]:
    """Return what holds the graph in the world: the surveys, or the first robot's start."""
    surveyed = [(begins[name], start) for name in names if (start := starts.get(name)) is not None]
    if not surveyed:
        first = begins[names[0]]
        return [(first, poses[first], np.full(3, _HELD_SD))]
    return [
        (vertex, start.pose.as_array(), np.maximum([start.sd_m, start.sd_m, start.sd_rad], _HELD_SD))
        for vertex, start in surveyed
    ]


def _add_meetings(
    meetings: Sequence[Meeting], begins: Mapping[str, int], poses: list[Array], count: int, edges: _Edges
) -> int:
    """Add a vertex for the place of each robot that was seen, and what holds it; return the new count."""
    for meeting in meetings:
        if meeting.seer not in begins or meeting.seen not in begins:
            continue
        every = np.concatenate(poses)
        anchor = begins[meeting.seen] + meeting.there.anchor
        seen_from = meeting.there.anchor_from_base
        poses.append((Pose2.from_array(every[anchor]) @ seen_from).as_array()[None])
        sd = meeting.there.sd_m
        edges.add([anchor, count], seen_from.as_array(), np.diag([sd**-2, sd**-2, 1.0]), False)
        place_only = np.zeros((3, 3))
        place_only[:2, :2] = np.linalg.inv(meeting.covariance)
        edges.add([begins[meeting.seer] + meeting.pose, count], [*meeting.offset_m, 0.0], place_only, True)
        count += 1
    return count


def _add_norths(
    graphs: Mapping[str, GraphReport],
    frames: Mapping[str, Pose2],
    begins: Mapping[str, int],
    poses: list[Array],
    count: int,
    edges: _Edges,
    tied: frozenset[str],
) -> tuple[dict[str, int], dict[str, int], list[_Prior]]:
    """Add a vertex per compass whose heading is its north, and one for the north of those that agree."""
    with_compass = [name for name in begins if np.isfinite(graphs[name].yaws_rad).any()]
    norths: dict[str, int] = {}
    ties: dict[str, int] = {}
    heading_only = np.diag([0.0, 0.0, _HEADING_SD_RAD**-2])
    agreeing = [name for name in with_compass if name in tied]
    common = count + len(with_compass)
    for vertex, name in enumerate(with_compass, count):
        norths[name] = vertex
        poses.append(np.array([[0.0, 0.0, frames[name].theta]]))
        known = np.flatnonzero(np.isfinite(graphs[name].yaws_rad))
        measured = np.zeros((len(known), 3))
        measured[:, 2] = graphs[name].yaws_rad[known]
        pairs = np.column_stack([np.full(len(known), vertex), begins[name] + known])
        edges.add(pairs, measured, np.tile(heading_only, (len(known), 1, 1)), False)
        if name in agreeing:
            ties[name] = edges.count
            edges.add([common, vertex], np.zeros(3), np.diag([0.0, 0.0, BIAS_SD_RAD**-2]), False)
    vertices = list(norths.values())
    if agreeing:
        poses.append(np.array([[0.0, 0.0, frames[agreeing[0]].theta]]))
        vertices.append(common)
    every = np.concatenate(poses)
    return norths, ties, [(vertex, every[vertex], np.full(3, _ANYWHERE)) for vertex in vertices]
