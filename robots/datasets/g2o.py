"""Pose graphs in the g2o format: VERTEX_SE2 id x y theta; EDGE_SE2 i j dx dy dtheta I11 I12 I13 I22 I23 I33.

Files of this kind come with all sorts of faults that leave a solution: vertices that only edges name, ids
given twice, edges of a vertex to itself, pieces that nothing joins. They are read, and ``notes`` say so.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import isfinite
from pathlib import Path

import numpy as np

from robots.estimation.graph.factors import link_chi2
from robots.estimation.graph.problem import GraphError, GraphProblem, pieces
from robots.estimation.graph.tree import spread_along_tree
from robots.graph_report import IntArray
from robots.se2 import Array

_NAMED = 5  # so many ids are named in a note
_NUMBERS = {"VERTEX_SE2": 4, "EDGE_SE2": 11, "FIX": 1}  # after the word; FIX may name more


@dataclass(frozen=True, slots=True, eq=False)
class PoseGraph:
    """``ids`` (n,) as the file has them and ``poses`` (n, 3), those of vertices it lacks composed from edges.

    ``pairs`` (k, 2) are rows of ``poses``, ``measured`` (k, 3), ``information`` (k, 3, 3); ``held`` are the
    vertices that FIX names.
    """

    ids: tuple[int, ...]
    poses: Array
    pairs: IntArray
    measured: Array
    information: Array
    held: tuple[int, ...]
    notes: tuple[str, ...]

    def chi2(self, poses: Array) -> float:
        """Return the sum of e' Omega e over all edges at poses (n, 3), as g2o reckons it."""
        return float(link_chi2(poses, self.pairs, self.measured, self.information).sum())

    def problem(self, robust: bool = False) -> tuple[GraphProblem, tuple[str, ...]]:
        """Return the graph, each of its pieces held where one vertex is, and notes on the pieces.

        If ``robust``, edges of vertices whose ids do not follow each other carry a kernel.
        """
        root = pieces(len(self.ids), self.pairs, self.information)
        fixed = np.array(sorted(self.held), np.int64)
        loose = np.setdiff1d(root, root[fixed])
        index = np.concatenate([fixed, loose])
        # As firm as a typical edge: it holds against nothing, so it only has to keep the numbers sound.
        firmness = np.median(self.information[:, [0, 1, 2], [0, 1, 2]]) if len(self.pairs) else 1.0
        sd = 1.0 / np.sqrt(firmness) if firmness > 0.0 else 1.0
        notes: tuple[str, ...] = ()
        if len(np.unique(root)) > 1:
            names = _named(self.ids[k] for k in loose)
            notes = (f"the graph is in {len(np.unique(root))} pieces; held where they are: {names}",)
        none = np.zeros(0)
        return (
            GraphProblem(
                poses=self.poses,
                tags=none,
                edge_pairs=self.pairs,
                edge_poses=self.measured,
                edge_covariances=none,
                edge_information=self.information,
                sighting_pairs=np.zeros((0, 2), np.int64),
                sighting_offsets=none,
                sighting_covariances=none,
                prior_index=index,
                prior_poses=self.poses[index],
                prior_sds=np.full((len(index), 3), min(sd, 1e-6) if len(fixed) > 1 else sd),
                edge_robust=np.abs(np.diff(np.array(self.ids)[self.pairs], axis=1)[:, 0]) != 1
                if robust
                else None,
            ),
            notes,
        )


def read(path: Path) -> PoseGraph:
    """Read a pose graph.

    Raises:
        GraphError: the file cannot be read, a line is not of the format, a number is not finite, an
            information matrix has a negative eigenvalue, or there is no vertex at all; the message names the
            line.
    """
    try:
        lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError as error:
        raise GraphError(f"cannot read the graph {path} ({error.strerror})") from error
    index: dict[int, int] = {}
    poses: list[list[float]] = []
    given: set[int] = set()
    ends: list[tuple[int, int]] = []
    rows: list[list[float]] = []
    edge_lines: list[int] = []
    held: list[int] = []
    twice: list[int] = []
    unread: dict[str, int] = {}

    def place_of(name: int) -> int:
        if name not in index:
            index[name] = len(index)
            poses.append([0.0, 0.0, 0.0])
        return index[name]

    for number, line in enumerate(lines, 1):
        words = line.split()
        if not words or words[0].startswith("#"):
            continue
        if words[0] not in _NUMBERS:
            unread[words[0]] = unread.get(words[0], 0) + 1
            continue
        values = _numbers(path, number, words)
        if words[0] == "VERTEX_SE2":
            if int(words[1]) in given:
                twice.append(int(words[1]))
            given.add(int(words[1]))
            poses[place_of(int(words[1]))] = values[1:]
        elif words[0] == "FIX":
            held.extend(int(value) for value in values)
        else:
            ends.append((place_of(int(words[1])), place_of(int(words[2]))))
            rows.append(values[2:])
            edge_lines.append(number)
    if not index:
        raise GraphError(f"{path.name} has no VERTEX_SE2 and no EDGE_SE2 line")
    ids = tuple(index)
    notes = [f"lines of a kind not known were left out: {kind} ({n} times)" for kind, n in unread.items()]
    if twice:
        notes.append(f"vertices given more than once, the last place stands: {_named(twice)}")
    pairs = np.array(ends, np.int64).reshape(-1, 2)
    to_itself = pairs[pairs[:, 0] == pairs[:, 1], 0]
    if len(to_itself):
        notes.append(f"edges of a vertex to itself change nothing: {_named(ids[k] for k in to_itself)}")
    numbers = np.array(rows).reshape(-1, 9)
    information = numbers[:, [3, 4, 5, 4, 6, 7, 5, 7, 8]].reshape(-1, 3, 3)
    _check_information(path, information, edge_lines)
    missing = [name for name in ids if name not in given]
    begin, measured = np.array(poses), np.ascontiguousarray(numbers[:, :3])
    if missing:
        notes.append(f"vertices that only edges name were placed along them: {_named(missing)}")
        known = np.array([name in given for name in ids])
        begin = spread_along_tree(begin, known, pairs, measured, len(pairs))
    return PoseGraph(
        ids, begin, pairs, measured, information, tuple(index[k] for k in held if k in index), tuple(notes)
    )


def write(path: Path, graph: PoseGraph, poses: Array) -> None:
    """Write the graph with its vertices at ``poses`` (n, 3).

    Raises:
        GraphError: the file cannot be written.
    """
    lines = [
        f"VERTEX_SE2 {name} {x!r} {y!r} {theta!r}"
        for name, (x, y, theta) in zip(graph.ids, poses.tolist(), strict=True)
    ]
    lines += [f"FIX {graph.ids[k]}" for k in graph.held]
    upper = graph.information[:, [0, 0, 0, 1, 1, 2], [0, 1, 2, 1, 2, 2]].tolist()
    for (i, j), measured, numbers in zip(graph.pairs.tolist(), graph.measured.tolist(), upper, strict=True):
        written = " ".join(repr(value) for value in measured + numbers)
        lines.append(f"EDGE_SE2 {graph.ids[i]} {graph.ids[j]} {written}")
    try:
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    except OSError as error:
        raise GraphError(f"cannot write {path} ({error.strerror})") from error


def _numbers(path: Path, number: int, words: list[str]) -> list[float]:
    where, wanted = f"{path.name}, line {number}", _NUMBERS[words[0]]
    if len(words) != wanted + 1 and (words[0] != "FIX" or len(words) < 2):
        raise GraphError(f"{where}: {words[0]} has {wanted} numbers, not {len(words) - 1}")
    try:
        values = [float(word) for word in words[1:]]
        [int(word) for word in words[1 : 3 if words[0] == "EDGE_SE2" else 2]]
    except ValueError as error:
        raise GraphError(f"{where}: {error}") from error
    if not all(isfinite(value) for value in values):
        raise GraphError(f"{where}: a number is not finite")
    return values


def _check_information(path: Path, information: Array, lines: list[int]) -> None:
    if not len(information):
        return
    eigenvalues = np.linalg.eigvalsh(information)
    bad = np.flatnonzero(eigenvalues[:, 0] < -1e-9 * np.maximum(eigenvalues[:, 2], 0.0))
    if len(bad):
        raise GraphError(
            f"{path.name}, line {lines[bad[0]]}: the information matrix has a negative eigenvalue"
        )


def _named(names: Iterable[int]) -> str:
    every = list(dict.fromkeys(int(name) for name in names))
    more = f" and {len(every) - _NAMED} more" if len(every) > _NAMED else ""
    return ", ".join(str(name) for name in every[:_NAMED]) + more
