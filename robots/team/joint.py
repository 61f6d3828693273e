"""The joint solution of all robots' graphs: where everything is, and what does not fit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from robots.estimation.graph.blunders import way_tests
from robots.estimation.graph.problem import GraphError, assemble
from robots.estimation.graph.solve import Marginals
from robots.estimation.ranges.smoothing import smooth_ranges
from robots.estimation.ranges.views import as_sightings
from robots.estimation.tag_graph.trust import Judgement, judge
from robots.graph_report import GraphReport
from robots.se2 import Array, Pose2, wrap
from robots.team.frames import common_north, join_frames
from robots.team.history import History
from robots.team.laser_loops import LaserLoops
from robots.team.meetings import meetings_of
from robots.team.notices import tag_notices, way_notices
from robots.team.problem import JointProblem, joint_problem, moved
from robots.team.range_doubt import range_doubts
from robots.team.types import StartPose, TeamNotice, TeamTag
from robots.types import SubmapReport

_COMPASS_CHI2 = 10.8  # a compass that agrees with the others is off by more once in a thousand
_COMPASS_RAD = 0.15  # by which a compass may seem off before anything is solved

Method = Literal["gauss-newton", "linear"]


@dataclass(frozen=True, slots=True, eq=False)
class JointSolution:
    """The robots' pose vertices (n, 3) in the world, and the joint covariance of the newest of each.

    Robots that are not ``located`` have their poses in their own map frame, and no covariance. ``begins``:
    the vertex of ``marginals`` that is a robot's first pose.
    """

    anchors: dict[str, Array] = field(default_factory=dict)
    located: frozenset[str] = frozenset()
    covariances: dict[str, Array] = field(default_factory=dict)
    tags: tuple[TeamTag, ...] = ()
    notices: tuple[TeamNotice, ...] = ()
    marginals: Marginals | None = None
    begins: dict[str, int] = field(default_factory=dict)

    def between(self, first: tuple[str, int], second: tuple[str, int]) -> Array:
        """Return the covariance (2, 2) of where pose vertices (robot, index) stand to each other."""
        if self.marginals is None:
            return np.zeros((2, 2))
        i, j = (self.begins[name] + index for name, index in (first, second))
        joint = self.marginals.joint(np.array([i, j]))
        spread: Array = joint[:2, :2] + joint[3:5, 3:5] - joint[:2, 3:5] - joint[3:5, :2]
        return spread


def solve_together(
    graphs: Mapping[str, GraphReport],
    starts: Mapping[str, StartPose | None],
    histories: Mapping[str, History],
    submaps: Mapping[str, Mapping[int, SubmapReport]],
    lasers: LaserLoops,
    method: Method,
) -> JointSolution:
    """Return the joint solution of the graphs that can be solved; the others are told as notices."""
    sound, notices = _sound(graphs)
    anchors = {name: graph.poses for name, graph in graphs.items()}
    if not sound:
        return JointSolution(anchors, notices=tuple(notices))
    meetings = meetings_of(sound, histories)
    lasers.begin()
    placed = {name: as_sightings(graph) for name, graph in sound.items()}
    frames = join_frames(sound, starts, meetings, lambda a, b, tag: lasers.at_tag(a, b, tag, placed, submaps))
    loops = lasers.between(placed, submaps, frames)
    lasers.end()
    tied = _agreeing(sound, frames)

    def solved() -> tuple[JointProblem, Judgement, Array]:
        joint = joint_problem(sound, starts, frames, loops=loops, meetings=meetings, tied=tied)
        return _judged(joint, any(len(graph.sighting_pairs) for graph in sound.values()), method)

    joint, judged, doubts = solved()
    loose = _contradicted(joint, judged)
    if loose:
        tied -= loose
        joint, judged, doubts = solved()
    anchors |= {name: moved(frames[name], graph.poses) for name, graph in sound.items() if name in frames}
    covariances, every = {}, judged.solution.marginals.all()
    for name in joint.names:
        begin, count = joint.begins[name], len(sound[name].poses)
        anchors[name] = judged.solution.poses[begin : begin + count]
        covariances[name] = every[begin + count - 1]
    spreads = every[len(judged.solution.poses) :, :2, :2][: len(judged.tag_of)]
    found = tag_notices(joint, judged)
    notices += [*found.values(), *way_notices(joint, judged, sound)]
    return JointSolution(
        anchors=anchors,
        located=frozenset(joint.names),
        covariances=covariances,
        tags=_tags(joint, judged, found, spreads + doubts[judged.tag_of]),
        marginals=judged.solution.marginals,
        begins=joint.begins,
        notices=tuple(sorted(notices, key=lambda notice: (notice.kind, notice.about, notice.since_s))),
    )


def _judged(joint: JointProblem, passed: bool, method: Method) -> tuple[JointProblem, Judgement, Array]:
    """Solve; test the tags where robots ``passed`` over some, in that. Ranges have a kernel of their own.

    The last: what ranges leave open of each tag's place beyond the solution's covariance, (m, 2, 2).
    """
    if joint.ranges is None:
        judged = judge(joint.problem, joint.stamps_s, ways=joint.ways, method=method)
        return joint, judged, np.zeros((len(joint.tag_ids), 2, 2))
    links = joint.ranges.links
    batch = smooth_ranges(joint.problem, joint.ranges)
    doubts = range_doubts(joint.ranges, batch)
    joint = replace(joint, problem=batch.graph)
    if passed:
        edges = len(batch.graph.edge_pairs)
        under = np.setdiff1d(edges + np.arange(len(joint.stamps_s)), links) - edges
        judged = judge(batch.graph, joint.stamps_s, ways=joint.ways, method=method, tested=under)
        if judged.verdicts or judged.loosened:
            return joint, judged, doubts
    tags = np.arange(len(joint.tag_ids))
    return joint, Judgement(batch.graph, batch.solution, tags, np.zeros_like(tags), (), (), 1.0), doubts


def _sound(graphs: Mapping[str, GraphReport]) -> tuple[dict[str, GraphReport], list[TeamNotice]]:
    """Return the graphs that can be solved, and notices of the others."""
    sound, notices = {}, []
    for name, graph in sorted(graphs.items()):
        try:
            assemble(joint_problem({name: graph}, {}, {name: Pose2()}).problem)
            sound[name] = graph
        except (GraphError, ValueError, IndexError, np.linalg.LinAlgError) as error:
            text = f"What {name} measured cannot be used: {error}."
            notices.append(TeamNotice("way", name, text, 0.0, (name,)))
    return sound, notices


def _agreeing(graphs: Mapping[str, GraphReport], frames: Mapping[str, Pose2]) -> frozenset[str]:
    """Return the robots whose compasses may agree, as far as their frames tell."""
    north = common_north(graphs, frames)
    return frozenset(
        name for name in frames if north is not None and abs(wrap(frames[name].theta - north)) < _COMPASS_RAD
    )


def _contradicted(joint: JointProblem, judged: Judgement) -> frozenset[str]:
    """Return the robots whose compasses contradict the common north by more than chance."""
    if not joint.ties:
        return frozenset()
    names = list(joint.ties)
    tests = way_tests(judged.problem, judged.solution, np.array([joint.ties[name] for name in names]))
    found = dict(zip(tests.edges.tolist(), tests.chi2.tolist(), strict=True))
    chi2 = {name: found.get(edge, 0.0) for name, edge in joint.ties.items()}
    worst = max(chi2.values())
    # where two compasses contradict each other, either may be wrong: neither is believed
    return frozenset(name for name in names if chi2[name] > _COMPASS_CHI2 and chi2[name] > 0.5 * worst)


def _tags(
    joint: JointProblem, judged: Judgement, notices: Mapping[int, TeamNotice], covariances: Array
) -> tuple[TeamTag, ...]:
    """Return the tags: one where it is now, a clone at each of its places. ``covariances`` (m, 2, 2)."""
    readers: list[list[int]] = [[] for _ in judged.tag_of]
    for (_, vertex), reader in zip(judged.problem.sighting_pairs, joint.readers, strict=True):
        readers[int(vertex)].append(int(reader))
    states = {verdict.tag: verdict.state for verdict in judged.verdicts}
    last = {verdict.tag: int(np.argmax(verdict.lasts_s)) for verdict in judged.verdicts}
    tags = []
    for vertex, (tag, place) in enumerate(zip(judged.tag_of, judged.place_of, strict=True)):
        state, name = states.get(int(tag)), joint.tag_ids[int(tag)]
        if place < 0 or (state == "moved" and place != last[int(tag)]):
            continue  # a stray sighting, or where it lay before
        if state == "cloned" and place > 0:
            name = f"{name}#{int(place) + 1}"
        notice = notices.get(int(tag))
        tags.append(
            TeamTag(
                tag_id=name,
                x_m=float(judged.solution.tags[vertex, 0]),
                y_m=float(judged.solution.tags[vertex, 1]),
                covariance=covariances[vertex],
                sightings=len(readers[vertex]),
                robots=tuple(sorted({joint.names[k] for k in readers[vertex]})),
                state=notice.kind if notice is not None and notice.kind != "way" else "sound",
                notice="" if notice is None else notice.text,
            )
        )
    return tuple(sorted(tags, key=lambda item: item.tag_id))
