"""Which tags of a graph lie where all their sightings say: wrong ids, moved tags and clones are found here.

Every sighting of a tag claims that it lies at one place; ``blunders`` tells by how much W of eq. (5) falls
when that is given up. A moved or cloned tag becomes one vertex per place, a stray sighting a vertex of its
own, and the graph is solved again. Where giving up one displacement explains much more than giving up any
tag, the way is at fault (a robot carried, slip that nobody noticed, two robots under one name), and that edge
is loosened.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import log
from typing import Literal

import numpy as np

from robots.estimation.graph.blunders import WayTests, tag_tests, way_tests
from robots.estimation.graph.solve import GraphProblem, GraphSolution, solve
from robots.estimation.tag_graph.places import TagSightings, contradiction, places_of
from robots.graph_report import IntArray
from robots.se2 import Array

TagState = Literal["moved", "cloned", "wrong"]

FALSE_ALARM = 1e-4  # of one sound tag, where all covariances are as claimed
LEAST_SHIFT_M = 0.3  # what lies nearer may come from antennas and wheels
_LARGEST_SCALE = 9.0  # deviations three times as claimed: beyond, it is not the covariances that are wrong
_ENOUGH = 8  # so many claims at least tell how honest the covariances are
_SHARE = 0.3  # tags this suspicious, against the most suspicious one, are looked at in one go
_WAY_MARGIN = 16.0  # by which loosening a displacement has to explain more than giving up any tag
_LOOSE = 1e4  # of a displacement's covariance, once it is not believed
_TRIALS = 6
_ROUNDS = 12


@dataclass(frozen=True, slots=True, eq=False)
class TagVerdict:
    """What the sightings of one tag say about it.

    ``tag``: its index in the graph that was judged. ``places_m`` (g, 2): where it was found, in the order of
    the first sighting there, ``firsts_s`` and ``lasts_s`` (g,) when; ``strays``: indices of sightings that
    contradict all others. *moved*: one place after the other; *cloned*: places in turn; *wrong*: one place,
    and strays. ``chi2``: between its places, 2 degrees of freedom.
    """

    tag: int
    state: TagState
    places_m: Array
    firsts_s: Array
    lasts_s: Array
    strays: tuple[int, ...]
    chi2: float


@dataclass(frozen=True, slots=True, eq=False)
class Judgement:
    """A graph after the tags that are not what they claim were split.

    ``tag_of`` (m',): which tag of the judged graph each tag vertex of ``problem`` is; ``place_of`` (m',):
    which of its places, -1 for a stray sighting. ``loosened``: edges that contradict the tags. ``scale``: by
    how much the claims contradict each other more than their covariances say, 1 where they are honest.
    """

    problem: GraphProblem
    solution: GraphSolution
    tag_of: IntArray
    place_of: IntArray
    verdicts: tuple[TagVerdict, ...]
    loosened: tuple[int, ...]
    scale: float


def judge(
    problem: GraphProblem,
    stamps_s: Array,
    *,
    ways: IntArray | None = None,
    method: Literal["gauss-newton", "linear"] = "gauss-newton",
    max_iterations: int = 20,
    kernel_sd: float = 3.0,
    tested: IntArray | None = None,
) -> Judgement:
    """Solve a graph, find the tags that are not where all their sightings claim, split them, solve again.

    ``stamps_s`` (s,): when each sighting was made. ``ways`` (w,): the edges that are displacements driven;
    ``tested`` (t,): sightings that cast doubt; all by default. Each tag has to have a sighting.

    Raises:
        GraphError: as ``solve``.
    """
    order = np.argsort(stamps_s, kind="stable")
    doubtful = order if tested is None else order[np.isin(order, tested)]
    labels = np.zeros(len(problem.sighting_pairs), np.int64)
    loosened: list[int] = []
    doubted: dict[int, float] = {}  # tags that were looked at, and what came of it

    def solved(of: GraphProblem) -> GraphSolution:
        # with a kernel that lets go, nothing would be left of a contradiction to be tested
        return solve(of, method, max_iterations, kernel_sd, kernel="huber")

    final = solve(problem, method, max_iterations, kernel_sd)
    given, problem = problem, _without_outliers(problem, final, kernel_sd)
    split = _Split(problem, np.arange(len(problem.tags)), np.zeros(len(problem.tags), np.int64))
    solution = solved(problem)
    scale = 1.0
    for _ in range(_ROUNDS):
        tests = tag_tests(split.problem, solution, doubtful, kernel_sd)
        scale = _scale(tests.neighbours)
        limits = scale * np.array([alarm_limit(int(n)) for n in tests.hypotheses])
        excess = np.where(tests.chi2 > limits, tests.chi2, 0.0)
        excess[np.isin(split.tag_of, list(doubted))] = 0.0
        worst = float(excess.max(initial=0.0))
        if worst == 0.0:
            break
        suspicious = _worst_ways(
            way_tests(split.problem, solution, ways), loosened, worst + scale * _WAY_MARGIN
        )
        if suspicious:  # which of them it was, the kernel may have smeared
            trials = [solved(_loosened(split.problem, [way])).chi2 for way in suspicious]
            loosened.append(suspicious[int(np.argmin(trials))])
        else:
            suspects = [int(split.tag_of[k]) for k in np.flatnonzero(excess > _SHARE * worst)]
            first = int(split.tag_of[int(np.argmax(excess))])
            for tags in dict.fromkeys((tuple(suspects), (first,))):
                apart = _apart(problem, solution, labels, loosened, tags, order, solved)
                found = {tag: places_of(seen, scale, LEAST_SHIFT_M) for tag, seen in apart.items()}
                guilty = [tag for tag in tags if found[tag].any()]
                if guilty:
                    break
            for tag in guilty or [first]:  # the others may have been accused for the guilty ones' sake
                labels[apart[tag].rows] = found[tag]
                doubted[tag] = contradiction(apart[tag], found[tag])
        split = _split(problem, solution, labels, loosened, order)
        solution = solved(split.problem)
    if doubted or loosened:
        split = _split(given, solution, labels, loosened, order)
        final = solve(split.problem, method, max_iterations, kernel_sd)
    else:
        split = replace(split, problem=given)
    verdicts, place_of = _verdicts(split, final, labels, stamps_s, order, doubted)
    loose = tuple(sorted(loosened))
    return Judgement(split.problem, final, split.tag_of, place_of, verdicts, loose, scale)


def _without_outliers(problem: GraphProblem, solution: GraphSolution, kernel_sd: float) -> GraphProblem:
    """Return the problem without the robust edges (loops, meetings) that the solution let go of."""
    if problem.edge_robust is None:
        return problem
    wrong = problem.edge_robust & (solution.edge_residuals > 2.0 * kernel_sd)
    return _loosened(problem, np.flatnonzero(wrong).tolist())


def alarm_limit(hypotheses: int) -> float:
    """Return the chi-square (2 degrees of freedom) that the largest of so many reaches by chance."""
    return -2.0 * log(FALSE_ALARM / max(hypotheses, 1))


def _scale(neighbours: Array) -> float:
    """Return how much larger than honest the contradictions of a graph's sightings are, never below 1."""
    if len(neighbours) < _ENOUGH:
        return 1.0
    found = float(np.quantile(neighbours, 0.25)) / (2.0 * log(4.0 / 3.0))  # that of chi-square with 2
    return min(max(1.0, found), _LARGEST_SCALE)


def _worst_ways(ways: WayTests, loosened: list[int], least: float) -> list[int]:
    """Return the displacements that explain about as much as the best, if that is ``least`` or more."""
    chi2 = np.where(np.isin(ways.edges, loosened), 0.0, ways.chi2)
    best = float(chi2.max(initial=0.0))
    if best < least:
        return []
    order = np.argsort(-chi2, kind="stable")[:_TRIALS]
    return [int(ways.edges[k]) for k in order if chi2[k] > best / 2.0]


@dataclass(frozen=True, slots=True, eq=False)
class _Split:
    """A graph with one tag vertex per place: whose, and the label of the place."""

    problem: GraphProblem
    tag_of: IntArray
    label_of: IntArray


def _split(
    given: GraphProblem, solution: GraphSolution, labels: IntArray, loosened: list[int], order: IntArray
) -> _Split:
    """Return the graph whose sightings of a tag with unlike labels are of unlike vertices."""
    tags: list[Array] = []
    tag_of, label_of = [], []
    pairs = given.sighting_pairs.copy()
    by_tag = order[np.argsort(given.sighting_pairs[order, 1], kind="stable")]
    ends = np.searchsorted(given.sighting_pairs[by_tag, 1], np.arange(len(given.tags) + 1))
    for tag in range(len(given.tags)):
        rows = by_tag[ends[tag] : ends[tag + 1]]
        for label in dict.fromkeys(int(label) for label in labels[rows]):
            mine = rows[labels[rows] == label]
            pairs[mine, 1] = len(tags)
            tags.append(_claimed(given, solution, int(mine[-1])))
            tag_of.append(tag)
            label_of.append(label)
    problem = replace(given, poses=solution.poses, tags=np.array(tags).reshape(-1, 2), sighting_pairs=pairs)
    return _Split(_loosened(problem, loosened), np.array(tag_of, np.int64), np.array(label_of, np.int64))


def _loosened(problem: GraphProblem, edges: list[int]) -> GraphProblem:
    """Return the problem with edges that hold next to nothing."""
    if not edges:
        return problem
    if problem.edge_information is not None:
        information = problem.edge_information.copy()
        information[edges] /= _LOOSE
        return replace(problem, edge_information=information)
    covariances = problem.edge_covariances.copy()
    covariances[edges] *= _LOOSE
    return replace(problem, edge_covariances=covariances)


def _claimed(problem: GraphProblem, solution: GraphSolution, sighting: int) -> Array:
    """Return where a sighting by itself puts its tag, (2,)."""
    x, y, theta = solution.poses[problem.sighting_pairs[sighting, 0]]
    c, s = np.cos(theta), np.sin(theta)
    ahead, left = problem.sighting_offsets[sighting]
    return np.array([x + c * ahead - s * left, y + s * ahead + c * left])


def _apart(
    given: GraphProblem,
    solution: GraphSolution,
    labels: IntArray,
    loosened: list[int],
    suspects: tuple[int, ...],
    order: IntArray,
    solved: Callable[[GraphProblem], GraphSolution],
) -> dict[int, TagSightings]:
    """Return where each sighting of the suspects puts its tag, when no sighting of theirs holds the graph."""
    free = labels.copy()
    for tag in suspects:
        rows = order[given.sighting_pairs[order, 1] == tag]
        free[rows] = np.arange(len(rows))
    split = _split(given, solution, free, loosened, order)
    apart = solved(split.problem)
    found = {}
    for tag in suspects:
        vertices = np.flatnonzero(split.tag_of == tag)
        joint = apart.marginals.joint(len(apart.poses) + vertices)
        keep = np.flatnonzero(np.arange(len(joint)) % 3 < 2)
        rows = order[given.sighting_pairs[order, 1] == tag]
        found[tag] = TagSightings(rows, apart.tags[vertices], joint[np.ix_(keep, keep)])
    return found


def _verdicts(
    split: _Split,
    solution: GraphSolution,
    labels: IntArray,
    stamps_s: Array,
    order: IntArray,
    doubted: dict[int, float],
) -> tuple[tuple[TagVerdict, ...], IntArray]:
    """Return the verdicts, and of which place of its tag each vertex is."""
    verdicts, place_of = [], split.label_of.copy()
    of_tag = split.tag_of[split.problem.sighting_pairs[:, 1]]
    for tag, chi2 in sorted(doubted.items()):
        rows = order[of_tag[order] == tag]
        sequence = [int(label) for label in labels[rows]]
        if len(set(sequence)) == 1:
            continue  # its sightings agree after all
        stray = _strays(sequence)
        vertices = np.flatnonzero(split.tag_of == tag)
        kept = [int(v) for v in vertices if int(split.label_of[v]) not in stray]
        place_of[vertices] = -1
        place_of[kept] = np.arange(len(kept))
        stamps = [stamps_s[rows[labels[rows] == split.label_of[v]]] for v in kept]
        verdicts.append(
            TagVerdict(
                tag=tag,
                state=_state([label for label in sequence if label not in stray]),
                places_m=solution.tags[kept],
                firsts_s=np.array([s[0] for s in stamps]),
                lasts_s=np.array([s[-1] for s in stamps]),
                strays=tuple(int(s) for s in rows if int(labels[s]) in stray),
                chi2=chi2,
            )
        )
    return tuple(verdicts), place_of


def _strays(labels: list[int]) -> set[int]:
    """Return the places that were seen once, between sightings elsewhere."""
    return {label for label in labels[1:-1] if labels.count(label) == 1}


def _state(labels: list[int]) -> TagState:
    changes = [label for k, label in enumerate(labels) if k == 0 or labels[k - 1] != label]
    if len(changes) == 1:
        return "wrong"
    return "moved" if len(changes) == len(set(changes)) else "cloned"
