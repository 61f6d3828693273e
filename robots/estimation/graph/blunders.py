"""By how much W would fall if one claim of a graph were given up: the test of blunders (Baarda 1968).

With e, Omega and J a claim's error, information and Jacobian, and P the covariance of what it joins, giving
it up lowers W by

    T = g' N^-1 g,   g = B' Omega e,   N = B' (Omega - Omega J P J' Omega) B                            (T)

where B says how the error would change if the claim were off. Where the claim is right, T is chi-square with
as many degrees of freedom as B has columns. No graph has to be solved again for it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robots.estimation.graph.factors import link_chi2
from robots.estimation.graph.solve import GraphProblem, GraphSolution
from robots.graph_report import IntArray
from robots.se2 import Array, wrap_array

_CHECKED = 1e-6  # share of a claim's information that others have to check, else it cannot be tested
_WAYS = 40  # displacements of the largest errors are tested, no others


@dataclass(frozen=True, slots=True, eq=False)
class TagTests:
    """The tests of all tags, (m,).

    ``chi2``: the largest T of a tag, over the splits of its sightings in two by time and over single ones,
    each with 2 degrees of freedom; ``hypotheses`` how many those were. ``neighbours`` (q,): T of every split
    between two sightings, of all tags.
    """

    chi2: Array
    hypotheses: IntArray
    neighbours: Array


@dataclass(frozen=True, slots=True, eq=False)
class WayTests:
    """The tests of displacements: ``edges`` (k,) indices, ``chi2`` (k,) with at most 3 degrees of freedom."""

    edges: IntArray
    chi2: Array


def tag_tests(problem: GraphProblem, solution: GraphSolution, order: IntArray, kernel_sd: float) -> TagTests:
    """Test every tag for not lying at one place; ``order`` (s,) puts the sightings in the order of time."""
    count = len(problem.tags)
    chi2, hypotheses = np.zeros(count), np.zeros(count, np.int64)
    neighbours: list[Array] = []
    by_tag = order[np.argsort(problem.sighting_pairs[order, 1], kind="stable")]
    ends = np.searchsorted(problem.sighting_pairs[by_tag, 1], np.arange(count + 1))
    for tag in range(count):
        rows = by_tag[ends[tag] : ends[tag + 1]]
        if len(rows) < 2:
            continue
        forces, covered = _claims(problem, solution, rows, kernel_sd)
        later = np.tri(len(rows), dtype=bool)[:, 1:].T  # later than the k-th: row k - 1
        splits = _chi2(forces, covered, later.astype(np.float64))
        single = np.eye(len(rows))[1:-1]
        chi2[tag] = max(splits.max(), _chi2(forces, covered, single).max(initial=0.0))
        hypotheses[tag] = len(splits) + len(single)
        neighbours.append(splits)
    return TagTests(chi2, hypotheses, np.concatenate([np.zeros(0), *neighbours]))


def _claims(
    problem: GraphProblem, solution: GraphSolution, rows: IntArray, kernel_sd: float
) -> tuple[Array, Array]:
    """Return B' Omega e (k, 2) and B' (Omega - Omega J P J' Omega) B (k, 2, k, 2) of a tag's sightings.

    B: the tag lies elsewhere by so much, in the frame of the graph.
    """
    poses, tag = problem.sighting_pairs[rows, 0], int(problem.sighting_pairs[rows[0], 1])
    at = solution.poses[poses]
    c, s = np.cos(at[:, 2]), np.sin(at[:, 2])
    turned = np.stack([np.stack([c, -s], 1), np.stack([s, c], 1)], 1)  # map from base
    gap = solution.tags[tag] - at[:, :2]
    error = np.einsum("kji,kj->ki", turned, gap) - problem.sighting_offsets[rows]
    information = np.linalg.inv(problem.sighting_covariances[rows])
    square = np.einsum("ki,kij,kj->k", error, information, error)
    weight = np.minimum(1.0, kernel_sd / np.sqrt(np.maximum(square, 1e-12)))  # Huber, as the solver has it
    information *= weight[:, None, None]
    in_map = turned @ information @ turned.transpose(0, 2, 1)
    forces = np.einsum("kij,kj->ki", turned @ information, error)
    k = len(rows)
    by_pose = np.zeros((k, 2, 3))  # Omega J of the pose, turned into the map: -Omega [I q]
    by_pose[:, :, :2] = -in_map
    by_pose[:, :, 2] = -np.einsum("kij,kj->ki", in_map, np.stack([-gap[:, 1], gap[:, 0]], 1))
    unique, place = np.unique(poses, return_inverse=True)
    size = 3 * len(unique)
    jacobian = np.zeros((k, 2, size + 3))
    for i in range(k):
        jacobian[i, :, 3 * place[i] : 3 * place[i] + 3] = by_pose[i]
        jacobian[i, :, size : size + 2] = in_map[i]
    joint = solution.marginals.joint(np.append(unique, len(solution.poses) + tag))
    flat = jacobian.reshape(2 * k, size + 3)
    covered = (-(flat @ joint @ flat.T)).reshape(k, 2, k, 2)
    covered[np.arange(k), :, np.arange(k), :] += in_map
    return forces, covered


def _chi2(forces: Array, covered: Array, groups: Array) -> Array:
    """Return T of each group, (n, k) of 0 and 1: what if the tag of these sightings lay elsewhere."""
    g = groups @ forces
    n = np.einsum("ak,kilj,al->aij", groups, covered, groups)
    values, vectors = np.linalg.eigh((n + n.transpose(0, 2, 1)) / 2.0)
    whole = np.einsum("kiki->", covered) / max(len(forces), 1)
    along = np.einsum("aij,ai->aj", vectors, g)
    sure = values > _CHECKED * max(whole, 1e-12)
    chi2: Array = np.where(sure, along**2 / np.where(sure, values, 1.0), 0.0).sum(axis=1)
    return chi2


def way_tests(problem: GraphProblem, solution: GraphSolution, among: IntArray | None = None) -> WayTests:
    """Test the displacements of the largest errors for being wrong altogether; ``among`` (k,) some edges."""
    given = problem.edge_information
    information = np.linalg.inv(problem.edge_covariances) if given is None else given
    errors = link_chi2(solution.poses, problem.edge_pairs, problem.edge_poses, information)
    among = np.arange(len(errors)) if among is None else among
    edges = np.sort(among[np.argsort(-errors[among], kind="stable")[:_WAYS]])
    chi2 = np.array([_way_chi2(problem, solution, int(k), information[k]) for k in edges])
    return WayTests(edges.astype(np.int64), chi2)


def _way_chi2(problem: GraphProblem, solution: GraphSolution, edge: int, information: Array) -> float:
    i, j = problem.edge_pairs[edge]
    if i == j:
        return 0.0
    a, b = solution.poses[i], solution.poses[j]
    c, s = np.cos(a[2]), np.sin(a[2])
    turned = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    shift = np.array([[1.0, 0.0, a[1] - b[1]], [0.0, 1.0, b[0] - a[0]], [0.0, 0.0, 1.0]])
    error = turned @ (b - a) - problem.edge_poses[edge]
    error[2] = wrap_array(error[2:])[0]
    jacobian = np.hstack([-turned @ shift, turned])
    values, vectors = np.linalg.eigh(information)
    half = vectors * np.sqrt(np.maximum(values, 0.0))  # Omega = half half'
    joint = solution.marginals.joint(np.array([i, j]))
    free = np.eye(3) - half.T @ jacobian @ joint @ jacobian.T @ half
    shares, axes = np.linalg.eigh((free + free.T) / 2.0)
    along = axes.T @ half.T @ error
    checked = shares > 1e-3
    return float((along[checked] ** 2 / shares[checked]).sum())
