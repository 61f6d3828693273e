"""Moved, cloned and misread tags are found by their residuals; honest ones are left alone."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robots.estimation.graph.blunders import tag_tests, way_tests
from robots.estimation.graph.solve import GraphProblem, solve
from robots.estimation.tag_graph.trust import judge
from robots.se2 import Pose2

TAGS = 8
STEP_SD = np.array([0.03, 0.03, 0.02])
ANTENNA = np.array([0.03, 0.20]) / np.sqrt(12.0)


def rounds(
    rng: np.random.Generator,
    laps: int = 4,
    noise: float = 1.0,
    places: dict[int, tuple[float, float]] | None = None,
) -> tuple[GraphProblem, np.ndarray]:
    """Laps round a ring of tags 3 m apart, measured as noisily as claimed.

    ``places``: by how much the tag read at the k-th stop lies beside where it lay in the first lap.
    """
    radius = 3.0 * TAGS / (2.0 * np.pi)
    true, edges, offsets, pairs = [], [], [], []
    for k in range(laps * TAGS):
        angle = 2.0 * np.pi * k / TAGS
        true.append(Pose2(radius * np.cos(angle), radius * np.sin(angle), angle + np.pi / 2.0))
    begin = Pose2(*(true[0].as_array()))
    guess = [begin]
    for k in range(1, len(true)):
        step = true[k - 1].between(true[k])
        noisy = step.as_array() + noise * STEP_SD * rng.standard_normal(3)
        edges.append(noisy)
        guess.append(guess[-1] @ Pose2.from_array(noisy))
    for k, pose in enumerate(true):
        tag = true[k % TAGS]
        dx, dy = (places or {}).get(k, (0.0, 0.0))
        seen = pose.inverse().transform_point(tag.x + dx, tag.y + dy)
        offsets.append(np.array(seen) + noise * ANTENNA * rng.standard_normal(2))
        pairs.append((k, k % TAGS))
    n = len(true)
    problem = GraphProblem(
        poses=np.array([pose.as_array() for pose in guess]),
        tags=np.array([(pose.x, pose.y) for pose in true[:TAGS]]),
        edge_pairs=np.column_stack([np.arange(n - 1), np.arange(1, n)]),
        edge_poses=np.array(edges),
        edge_covariances=np.tile(np.diag(STEP_SD**2), (n - 1, 1, 1)),
        sighting_pairs=np.array(pairs),
        sighting_offsets=np.array(offsets),
        sighting_covariances=np.tile(np.diag(ANTENNA**2), (n, 1, 1)),
        prior_index=np.zeros(1, np.int64),
        prior_poses=begin.as_array()[None],
        prior_sds=np.full((1, 3), 1e-3),
    )
    return problem, 10.0 * np.arange(n)


def bend(problem: GraphProblem, judged: np.ndarray) -> float:
    """How far the judged poses lie from the true ring, at most."""
    truth, _ = rounds(np.random.default_rng(0), len(problem.poses) // TAGS, noise=0.0)
    return float(np.abs(judged[:, :2] - truth.poses[:, :2]).max())


def test_the_statistic_is_what_the_solver_gains_by_giving_a_claim_up():
    """T is W with all sightings of a tag at one place, less W with the later ones at another."""
    problem, stamps = rounds(np.random.default_rng(3), laps=2)
    solution = solve(problem, kernel_sd=np.inf, tolerance=1e-14)
    tests = tag_tests(problem, solution, np.argsort(stamps), np.inf)
    for tag in range(TAGS):
        pairs = problem.sighting_pairs.copy()
        pairs[TAGS + tag, 1] = TAGS
        tags = np.vstack([problem.tags, problem.tags[tag]])
        apart = solve(replace(problem, tags=tags, sighting_pairs=pairs), kernel_sd=np.inf, tolerance=1e-14)
        assert tests.chi2[tag] == pytest.approx(solution.chi2 - apart.chi2, rel=0.02, abs=0.02)
    ways = way_tests(problem, solution)
    for edge, chi2 in list(zip(ways.edges, ways.chi2, strict=True))[::3]:
        information = np.linalg.inv(problem.edge_covariances)
        information[edge] *= 1e-9
        loose = solve(replace(problem, edge_information=information), kernel_sd=np.inf, tolerance=1e-14)
        assert chi2 == pytest.approx(solution.chi2 - loose.chi2, rel=0.03, abs=0.03)


def test_honest_noise_accuses_nobody():
    accused = 0
    for seed in range(60):
        outcome = judge(*rounds(np.random.default_rng(seed)))
        accused += len(outcome.verdicts)
        assert outcome.loosened == ()
    assert accused <= 2  # of 480 tags


def test_noise_that_is_larger_than_claimed_accuses_hardly_anybody():
    """Covariances that are too small by 2.5 times: the graph as a whole tells."""
    accused = sum(len(judge(*rounds(np.random.default_rng(seed), noise=1.6)).verdicts) for seed in range(40))
    assert accused <= 3  # of 320 tags


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, TAGS - 1), st.integers(1, 3), st.floats(0, 2 * np.pi))
def test_a_moved_tag_is_found_and_bends_nothing(seed, tag, lap, angle):
    shift = (1.2 * np.cos(angle), 1.2 * np.sin(angle))
    moved = {k * TAGS + tag: shift for k in range(lap, 4)}
    problem, stamps = rounds(np.random.default_rng(seed), places=moved)
    outcome = judge(problem, stamps)
    (verdict,) = outcome.verdicts
    assert (verdict.tag, verdict.state, verdict.strays) == (tag, "moved", ())
    np.testing.assert_allclose(verdict.places_m[1] - verdict.places_m[0], shift, atol=0.25)
    assert verdict.firsts_s[1] == stamps[lap * TAGS + tag]
    assert verdict.lasts_s[0] == stamps[(lap - 1) * TAGS + tag]
    assert bend(problem, outcome.solution.poses) < 0.3
    vertices = np.flatnonzero(outcome.tag_of == tag)
    assert list(outcome.place_of[vertices]) == [0, 1]
    np.testing.assert_array_equal(outcome.solution.tags[vertices], verdict.places_m)


def test_without_noise_the_places_are_exact():
    problem, stamps = rounds(np.random.default_rng(0), noise=0.0, places={17: (5.0, 1.0), 25: (5.0, 1.0)})
    outcome = judge(problem, stamps)
    (verdict,) = outcome.verdicts
    np.testing.assert_allclose(verdict.places_m[1] - verdict.places_m[0], (5.0, 1.0), atol=1e-4)
    assert outcome.solution.chi2 < 1e-6


def test_tags_that_alternate_are_cloned():
    """Tag 2 at home in laps 0 and 2, at its twin's place in laps 1 and 3."""
    problem, stamps = rounds(np.random.default_rng(1), places={10: (4.0, 0.0), 26: (4.0, 0.0)})
    (verdict,) = judge(problem, stamps).verdicts
    assert (verdict.tag, verdict.state, len(verdict.places_m)) == (2, "cloned", 2)


def test_one_stray_sighting_is_wrong():
    problem, stamps = rounds(np.random.default_rng(1), places={10: (3.0, 2.0)})
    outcome = judge(problem, stamps)
    (verdict,) = outcome.verdicts
    assert (verdict.tag, verdict.state, verdict.strays, len(verdict.places_m)) == (2, "wrong", (10,), 1)
    assert sorted(outcome.place_of[outcome.tag_of == 2]) == [-1, 0]
    assert bend(problem, outcome.solution.poses) < 0.3


def test_a_wrong_id_is_a_stray_of_the_tag_it_claims():
    problem, stamps = rounds(np.random.default_rng(5))
    pairs = problem.sighting_pairs.copy()
    pairs[12, 1] = 1  # tag 4 misread
    outcome = judge(replace(problem, sighting_pairs=pairs), stamps)
    (verdict,) = outcome.verdicts
    assert (verdict.tag, verdict.state, verdict.strays) == (1, "wrong", (12,))


def test_several_at_once():
    moved = dict.fromkeys((17, 25), (2.0, 0.0)) | dict.fromkeys((13, 21, 29), (0.0, -1.0)) | {11: (-3.0, 0.5)}
    problem, stamps = rounds(np.random.default_rng(2), places=moved)
    outcome = judge(problem, stamps)
    assert {v.tag: v.state for v in outcome.verdicts} == {1: "moved", 5: "moved", 3: "wrong"}
    assert bend(problem, outcome.solution.poses) < 0.3


def test_a_robot_that_was_carried_accuses_no_tag():
    """From lap 2 on the way between two stops is off by metres, and every tag would have to have moved."""
    problem, stamps = rounds(np.random.default_rng(4))
    edges = problem.edge_poses.copy()
    edges[18] += (4.0, -2.0, 0.5)
    outcome = judge(replace(problem, edge_poses=edges), stamps)
    assert outcome.verdicts == ()
    assert outcome.loosened == (18,)
    assert bend(problem, outcome.solution.poses) < 0.4


def test_tags_seen_once_and_none_at_all_are_survived():
    problem, stamps = rounds(np.random.default_rng(4), laps=1)
    assert judge(problem, stamps).verdicts == ()
    none = replace(
        problem,
        tags=np.zeros((0, 2)),
        sighting_pairs=np.zeros((0, 2), np.int64),
        sighting_offsets=np.zeros((0, 2)),
        sighting_covariances=np.zeros((0, 2, 2)),
    )
    assert judge(none, np.zeros(0)).verdicts == ()


@given(st.integers(0, 10**6))
@settings(max_examples=8, deadline=None)
def test_the_order_in_which_sightings_are_listed_does_not_matter(seed):
    rng = np.random.default_rng(seed)
    problem, stamps = rounds(rng, places={18: (1.0, 0.0), 26: (1.0, 0.0)})
    mixed = rng.permutation(len(stamps))
    other = replace(
        problem,
        sighting_pairs=problem.sighting_pairs[mixed],
        sighting_offsets=problem.sighting_offsets[mixed],
        sighting_covariances=problem.sighting_covariances[mixed],
    )
    (a,), (b,) = judge(problem, stamps).verdicts, judge(other, stamps[mixed]).verdicts
    assert (a.tag, a.state) == (b.tag, b.state)
    np.testing.assert_allclose(a.places_m, b.places_m, atol=1e-6)
