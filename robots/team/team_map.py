"""The team's map: all robots' tag graphs, submaps and victims in one world frame.

A function of the set of updates it was given, not of their order: for each robot the newest graph, for each
submap and victim the newest version. Robots share no poses, only tags: two robots that have read the same tag
are joined by it.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from robots.graph_report import GraphReport
from robots.mapping.fused import FusedGrid
from robots.mapping.submap import unpack
from robots.se2 import Pose2
from robots.team.history import History
from robots.team.joint import JointSolution, Method, solve_together
from robots.team.laser_loops import LaserLoops
from robots.team.types import StartPose, TeamGrid, TeamRobot, TeamUpdate, TeamVictim
from robots.team.victims import in_world, merge_victims
from robots.types import AgentUpdate, FloatArray32, SubmapReport, VictimEstimate

_TRAIL_M = 0.25
_FREE, _BOUND = -4, 60  # log-odds in tenths
_STEP_M, _STEP_RAD = 0.01, 0.001  # submaps are drawn at the nearest of places so far apart: see _snapped
_SAME_PLACE_M = 1e-9


@dataclass(slots=True)
class _Member:
    start: StartPose | None
    graph: GraphReport | None = None
    graph_seq: int = -1
    submaps: dict[int, SubmapReport] = field(default_factory=dict)
    victims: dict[str, VictimEstimate] = field(default_factory=dict)
    history: History = field(default_factory=History)
    # cell -> seq, x, y
    trail: dict[tuple[int, int, int], tuple[int, float, float]] = field(default_factory=dict)


class TeamMap:
    """Joins robots by the tags they share and keeps one map of them.

    ``method`` as in ``robots.estimation.graph.solve.solve``.
    """

    def __init__(self, resolution_m: float = 0.05, method: Method = "gauss-newton") -> None:
        self._method = method
        self._members: dict[str, _Member] = {}
        self._grid = FusedGrid(resolution_m)
        self._grid_version = 0
        self._unpacked: dict[tuple[str, int], tuple[int, NDArray[np.int8]]] = {}
        self._graphs_changed = True
        self._lasers = LaserLoops()
        self._solution = JointSolution()

    def add_robot(self, robot_id: str, start: StartPose | None) -> None:
        """Make a robot known, with its surveyed start pose where there is one."""
        if robot_id not in self._members:
            self._members[robot_id] = _Member(start)
            self._graphs_changed = True

    def put(self, robot_id: str, update: AgentUpdate) -> None:
        """Take in an update; older than what is known changes nothing.

        Raises:
            KeyError: the robot was never added.
        """
        member = self._members[robot_id]
        if update.graph is not None and update.seq > member.graph_seq:
            member.graph, member.graph_seq = update.graph, update.seq
            self._graphs_changed = True
        for submap in update.submaps:
            known = member.submaps.get(submap.anchor)
            if known is None or submap.version > known.version:
                member.submaps[submap.anchor] = submap
                self._graphs_changed = True  # there may be loops to be matched by laser
        for victim in update.victims:
            seen = member.victims.get(victim.victim_id)
            if seen is None or victim.sightings > seen.sightings:
                member.victims[victim.victim_id] = victim
        place = update.anchor_from_base
        member.history.put(update.seq, update.stamp_s, update.anchor, place)
        cell = (update.anchor, round(place.x / _TRAIL_M), round(place.y / _TRAIL_M))
        first = member.trail.get(cell)
        if first is None or update.seq < first[0]:
            member.trail[cell] = (update.seq, place.x, place.y)

    def solve(self) -> TeamUpdate:
        """Return the team's map of everything put in so far."""
        if self._graphs_changed:
            self._solve_graphs()
            self._graphs_changed = False
        self._draw()
        victims = self._merged_victims()
        solution = self._solution
        robots = tuple(
            TeamRobot(
                robot_id,
                robot_id in solution.located,
                solution.anchors[robot_id],
                self._trail(robot_id),
                solution.covariances.get(robot_id),
            )
            for robot_id in sorted(solution.anchors)
        )
        explored = float((self._grid.cells <= _FREE).sum()) * self._grid.resolution_m**2
        return TeamUpdate(
            robots, solution.tags, self._links(), victims, self._team_grid(), explored, solution.notices
        )

    def _solve_graphs(self) -> None:
        graphs = {name: m.graph for name, m in sorted(self._members.items()) if m.graph is not None}
        members = {name: self._members[name] for name in graphs}
        self._solution = solve_together(
            graphs,
            {name: member.start for name, member in members.items()},
            {name: member.history for name, member in members.items()},
            {name: member.submaps for name, member in members.items()},
            self._lasers,
            self._method,
        )

    def _links(self) -> tuple[tuple[str, str], ...]:
        pairs: set[tuple[str, str]] = set()
        for name in sorted(self._solution.located):
            graph = self._members[name].graph
            if graph is None:
                continue
            seen = np.concatenate([graph.sighting_pairs, graph.range_pairs])
            seen = seen[np.argsort(seen[:, 0], kind="stable")]
            order = [graph.tag_ids[int(tag)] for _, tag in seen]
            for a, b in pairwise(order):
                if a != b:
                    pairs.add((min(a, b), max(a, b)))
        return tuple(sorted(pairs))

    def _draw(self) -> None:
        changed = False
        for key in [key for key in self._unpacked if key[0] not in self._solution.located]:
            self._grid.drop(key)  # it was the world until somebody else was heard
            del self._unpacked[key]
            changed = True
        for name in sorted(self._solution.located):
            anchors = self._solution.anchors[name]
            for anchor, report in sorted(self._members[name].submaps.items()):
                if anchor >= len(anchors):
                    continue  # its graph is still on the way
                key = (name, anchor)
                if key not in self._unpacked or self._unpacked[key][0] != report.version:
                    self._unpacked[key] = (report.version, unpack(report))
                place = _snapped(Pose2.from_array(anchors[anchor]) @ report.anchor_from_grid)
                changed |= self._grid.put(key, report.version, place, self._unpacked[key][1], _SAME_PLACE_M)
        self._grid_version += changed

    def _team_grid(self) -> TeamGrid | None:
        cells, origin = self._grid.known()
        if not cells.size:
            return None
        log_odds = np.clip(cells, -_BOUND, _BOUND) / 10.0
        occupancy = np.round(100.0 / (1.0 + np.exp(-log_odds))).astype(np.int8)
        occupancy[cells == 0] = -1
        return TeamGrid(occupancy, origin, self._grid.resolution_m, self._grid_version)

    def _trail(self, robot_id: str) -> FloatArray32:
        anchors = self._solution.anchors[robot_id]
        # the anchors themselves, too: what was put in before a restart may not be known point by point
        points = sorted(
            [(anchor, seq, x, y) for (anchor, _, _), (seq, x, y) in self._members[robot_id].trail.items()]
            + [(anchor, -1, 0.0, 0.0) for anchor in range(len(anchors))]
        )
        kept = [(anchor, x, y) for anchor, _, x, y in points if anchor < len(anchors)]
        if not kept:
            return np.zeros((0, 2), np.float32)
        index = np.array([anchor for anchor, _, _ in kept])
        xy = np.array([(x, y) for _, x, y in kept])
        cosine, sine = np.cos(anchors[index, 2]), np.sin(anchors[index, 2])
        world = anchors[index, :2] + np.column_stack(
            [cosine * xy[:, 0] - sine * xy[:, 1], sine * xy[:, 0] + cosine * xy[:, 1]]
        )
        trail: FloatArray32 = world.astype(np.float32)
        return trail

    def _merged_victims(self) -> tuple[TeamVictim, ...]:
        seen, anchored = [], {}
        for name in sorted(self._solution.located):
            anchors = self._solution.anchors[name]
            for victim in self._members[name].victims.values():
                if victim.anchor < len(anchors):
                    seen.append(in_world(name, victim, Pose2.from_array(anchors[victim.anchor])))
                    anchored[victim.victim_id] = name, victim.anchor
        return merge_victims(
            seen, lambda a, b: self._solution.between(anchored[a.victim_id], anchored[b.victim_id])
        )


def _snapped(place: Pose2) -> Pose2:
    """Return the nearest place of a lattice: a drawing stays while its submap hardly moves.

    A tolerance against the last drawing would do that too, but then the map would depend on its history.
    """
    return Pose2(
        round(place.x / _STEP_M) * _STEP_M,
        round(place.y / _STEP_M) * _STEP_M,
        round(place.theta / _STEP_RAD) * _STEP_RAD,
    )
