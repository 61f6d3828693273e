"""A pose graph as a recording: its poses come one at a time, each with the edges to those before it.

A graph has been measured already: there is no sensor for an agent to read, so none runs here. The newest
pose is reckoned along its edge from the one before, and the graph is solved as it grows, after every pose; at
the end all of it once more.
"""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter
from typing import Literal

import numpy as np

from robots.datasets.g2o import PoseGraph
from robots.estimation.graph.incremental import IncrementalGraph
from robots.estimation.graph.solve import GraphSolution, solve
from robots.graph_report import IntArray
from robots.se2 import Array, Pose2, wrap_array
from robots.trajectory import Trajectory

_HELD_SD = 1e-4  # m and rad: what holds a piece where it began
_TOLERANCE = 1e-6  # of chi2


@dataclass(frozen=True, slots=True, eq=False)
class GraphReplay:
    """What came of a pose graph.

    ``online``: each pose as it was known when it came, ``final``: after the last solve; stamps are the ids of
    the vertices. ``poses`` (n, 3) are the final ones in the graph's own order, ``reckoned`` (n, 3) those of
    the edges alone that placed each vertex. ``loops``: edges that are not from one id to the next.
    """

    online: Trajectory
    final: Trajectory
    poses: Array
    reckoned: Array
    distance_m: float
    loops: int
    solves: int
    step_s: Array
    notes: tuple[str, ...]


def replay_graph(
    graph: PoseGraph,
    slam: Literal["tag-graph", "odometry"] = "tag-graph",
    on_step: Callable[[], None] = lambda: None,
) -> GraphReplay:
    """Go through the vertices in the order of their ids.

    With ``odometry`` only edges from one id to the next are used, where there are such. A vertex that nothing
    joins to those before it waits until something does; what never is joined begins where the file has it.

    Raises:
        GraphError: the graph cannot be solved; the message says why.
    """
    run = _Run(graph, slam)
    order = np.argsort(np.array(graph.ids, dtype=object), kind="stable")
    steps = []
    for vertex in order:
        began = perf_counter()
        run.arrive(int(vertex))
        steps.append(perf_counter() - began)
        on_step()
    run.finish([int(vertex) for vertex in order])
    names = np.array([float(graph.ids[vertex]) for vertex in order])
    moved = np.diff(run.reckoned[order][:, :2], axis=0)
    return GraphReplay(
        online=Trajectory(names, run.online[order]),
        final=Trajectory(names, run.poses[order]),
        poses=run.poses,
        reckoned=run.reckoned,
        distance_m=float(np.hypot(moved[:, 0], moved[:, 1]).sum()),
        loops=int(np.count_nonzero(run.closes)),
        solves=run.solves,
        step_s=np.array(steps),
        notes=run.notes,
    )


class _Run:
    """The graph as far as it has come."""

    def __init__(self, graph: PoseGraph, slam: Literal["tag-graph", "odometry"]) -> None:
        self._graph = graph
        ids = np.array(graph.ids, dtype=object)
        first, second = graph.pairs.T
        self.closes = np.array([abs(ids[i] - ids[j]) > 1 for i, j in graph.pairs], np.bool_)
        self._used = (first != second) & (~self.closes if slam == "odometry" else True)
        self._edges_of: dict[int, list[int]] = defaultdict(list)
        for edge in np.flatnonzero(self._used):
            for vertex in graph.pairs[edge]:
                self._edges_of[int(vertex)].append(int(edge))
        self._slam = slam
        self._there = np.zeros(len(ids), np.bool_)
        self._waiting: set[int] = set()
        self._growing = IncrementalGraph()
        self._index: dict[int, int] = {}  # of a vertex in the growing graph
        self.poses = graph.poses.copy()
        self.online = graph.poses.copy()
        self.reckoned = graph.poses.copy()
        self.solves = 0
        self.notes: tuple[str, ...] = ()

    def arrive(self, vertex: int) -> None:
        """Put in a vertex, with those that waited for it, and solve the graph so far."""
        self._waiting.add(vertex)
        if self._there.any() and not self._place(vertex):
            return
        came = self._put(vertex)
        if self._slam == "tag-graph":
            self._growing.update()
            self.solves += 1
            for each in came:
                self.poses[each] = self._growing.pose(self._index[each])
        self.online[came] = self.poses[came]

    def finish(self, order: list[int]) -> None:
        """Begin what nothing joined where the file has it, and solve the whole."""
        for vertex in order:
            if vertex in self._waiting:
                self._put(vertex)
        if self._slam == "tag-graph":
            self._solve()

    def _put(self, vertex: int) -> list[int]:
        """Put in a vertex and those that waited for it; return all of them."""
        came = []
        queue = deque([vertex])
        while queue:
            here = queue.popleft()
            if here not in self._waiting:
                continue
            self._waiting.discard(here)
            known = [edge for edge in self._edges_of[here] if self._there[self._other(edge, here)]]
            self._there[here] = True
            self._grow(here, known)
            came.append(here)
            for edge in self._edges_of[here]:
                other = self._other(edge, here)
                if other in self._waiting and self._place(other):
                    queue.append(other)
        return came

    def _grow(self, vertex: int, edges: list[int]) -> None:
        self._index[vertex] = self._growing.add_pose(self.poses[vertex])
        if not edges or vertex in self._graph.held:
            self._growing.add_prior(self._index[vertex], self.poses[vertex], [_HELD_SD] * 3)
        for edge in edges:
            i, j = (self._index[int(end)] for end in self._graph.pairs[edge])
            information = self._graph.information[edge]
            self._growing.add_edge(i, j, self._graph.measured[edge], information=information)

    def _place(self, vertex: int) -> bool:
        """Reckon a vertex along an edge from one that is there, best that of the id before."""
        known = [edge for edge in self._edges_of[vertex] if self._there[self._other(edge, vertex)]]
        if not known:
            return False
        edge = min(known, key=lambda k: bool(self.closes[k]))
        other = self._other(edge, vertex)
        if self._slam == "tag-graph":
            self.poses[other] = self._growing.pose(self._index[other])
        measured = Pose2.from_array(self._graph.measured[edge])
        between = measured if self._graph.pairs[edge, 1] == vertex else measured.inverse()
        self.poses[vertex] = (Pose2.from_array(self.poses[other]) @ between).as_array()
        self.reckoned[vertex] = (Pose2.from_array(self.reckoned[other]) @ between).as_array()
        return True

    def _other(self, edge: int, vertex: int) -> int:
        first, second = self._graph.pairs[edge]
        return int(second if first == vertex else first)

    def _solve(self) -> None:
        for vertex, index in self._index.items():
            self.poses[vertex] = self._growing.pose(index)
        there = np.flatnonzero(self._there)
        row = np.full(len(self._there), -1)
        row[there] = np.arange(len(there))
        pairs: IntArray = row[self._graph.pairs]
        inside = self._used & (pairs >= 0).all(axis=1)
        part = PoseGraph(
            ids=tuple(self._graph.ids[k] for k in there),
            poses=self.poses[there],
            pairs=pairs[inside],
            measured=self._graph.measured[inside],
            information=self._graph.information[inside],
            held=tuple(int(row[k]) for k in self._graph.held if self._there[k]),
            notes=(),
        )
        problem, pieces = part.problem()
        solution: GraphSolution = solve(problem, max_iterations=100, tolerance=_TOLERANCE)
        self.poses[there] = solution.poses
        if not self._graph.held and not pieces:  # what holds nothing but the frame must not creep
            back = Pose2.from_array(part.poses[0]) @ Pose2.from_array(solution.poses[0]).inverse()
            self.poses[there, :2] = back.transform(solution.poses[:, :2])
            self.poses[there, 2] = wrap_array(solution.poses[:, 2] + back.theta)
        self.notes = (*pieces, *solution.notes)
        self.solves += 1
