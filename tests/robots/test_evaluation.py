"""Errors of trajectories against oracles: scipy.optimize, brute force, the judge's own arithmetic."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.stats import chi2

from robots.evaluation import (
    EvaluationError,
    absolute_error,
    align,
    consistency,
    coverage,
    places_error,
    read_relations,
    relations_error,
    relative_error,
)
from robots.se2 import Pose2
from robots.trajectory import Trajectory
from robots.tum import write_tum

JUDGE = Path(__file__).parents[3] / "shared" / "tools" / "judge.py"


def wander(rng: np.random.Generator, n: int = 300, step_s: float = 0.1) -> Trajectory:
    heading = np.cumsum(rng.normal(0.0, 0.2, n))
    position = np.cumsum(0.05 * np.column_stack([np.cos(heading), np.sin(heading)]), axis=0)
    return Trajectory(100.0 + step_s * np.arange(n), np.column_stack([position, heading]))


def carried(trajectory: Trajectory, by: Pose2, noise: np.ndarray | float = 0.0) -> Trajectory:
    poses = np.array([(by @ Pose2.from_array(row)).as_array() for row in trajectory.poses])
    return Trajectory(trajectory.stamps_s, poses + noise)


def test_alignment_is_the_least_squares_optimum():
    rng = np.random.default_rng(2)
    estimate = rng.normal(size=(40, 2))
    truth = Pose2(3.0, -1.0, 2.5).transform(estimate) + rng.normal(0.0, 0.3, (40, 2))

    def residuals(x: np.ndarray) -> np.ndarray:
        return (Pose2(x[0], x[1], x[2]).transform(estimate) - truth).ravel()

    best = min(
        (least_squares(residuals, [0.0, 0.0, start]) for start in (-2.0, 0.0, 2.0)), key=lambda r: r.cost
    )
    ours = align(estimate, truth).apply(estimate) - truth
    assert np.sum(ours**2) == pytest.approx(2.0 * best.cost, rel=1e-9)


def test_alignment_never_mirrors():
    triangle = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 2.0]])
    assert np.linalg.det(align(triangle, triangle * [1.0, -1.0]).rotation) == pytest.approx(1.0)


def test_a_carried_trajectory_has_no_absolute_error():
    truth = wander(np.random.default_rng(3))
    error = absolute_error(carried(truth, Pose2(5.0, 6.0, 2.0)), truth)
    assert error.rmse_m == pytest.approx(0.0, abs=1e-9)
    assert error.poses == len(truth)


def test_truth_is_interpolated_and_its_gaps_are_left_out():
    truth = wander(np.random.default_rng(4))
    cut = np.r_[0:100, 150:300]  # 5 s without truth
    with_gap = Trajectory(truth.stamps_s[cut], truth.poses[cut])
    assert absolute_error(truth, with_gap).poses == 249  # the first pose after the gap has no truth before it
    late = Trajectory(truth.stamps_s[:-1] + 0.05, (truth.poses[1:] + truth.poses[:-1]) / 2.0)
    assert absolute_error(late, truth).rmse_m == pytest.approx(0.0, abs=1e-9)


def test_nothing_to_compare_is_an_error():
    truth = wander(np.random.default_rng(5))
    with pytest.raises(EvaluationError, match="only 0 of 300 poses lie within the truth's time"):
        absolute_error(Trajectory(truth.stamps_s + 1e6, truth.poses), truth)
    with pytest.raises(EvaluationError, match="fewer than two stamped poses"):
        absolute_error(truth, Trajectory(truth.stamps_s[:1], truth.poses[:1]))
    with pytest.raises(EvaluationError, match="no two compared poses are 100 s apart"):
        relative_error(truth, truth, interval_s=100.0)


def test_relative_error_is_blind_to_where_the_trajectory_lies_and_sees_scale():
    truth = wander(np.random.default_rng(6))
    same = relative_error(carried(truth, Pose2(5.0, 6.0, 2.0)), truth)
    assert same.translation_m == pytest.approx(0.0, abs=1e-9)
    assert same.rotation_rad == pytest.approx(0.0, abs=1e-9)
    longer = Trajectory(truth.stamps_s, truth.poses * [1.1, 1.1, 1.0])
    moved = np.linalg.norm(truth.poses[10:, :2] - truth.poses[:-10, :2], axis=1)
    expected = 0.1 * np.sqrt(np.mean(moved**2))
    assert relative_error(longer, truth).translation_m == pytest.approx(expected, rel=0.02)


def test_relations_of_the_trajectory_itself_have_no_error(tmp_path):
    truth = wander(np.random.default_rng(7))
    pairs = [(10, 200), (50, 40), (0, 299), (7, 8)]
    rows = []
    for i, j in pairs:
        motion = Pose2.from_array(truth.poses[i]).between(Pose2.from_array(truth.poses[j]))
        rows.append([truth.stamps_s[i], truth.stamps_s[j], motion.x, motion.y, 0.0, 0.0, 0.0, motion.theta])
    rows.append([0.0, 110.0, 9.0, 9.0, 0.0, 0.0, 0.0, 0.0])  # begins before the trajectory
    np.savetxt(tmp_path / "r.relations", rows, fmt="%.9f")
    found = relations_error(carried(truth, Pose2(1.0, 2.0, 3.0)), read_relations(tmp_path / "r.relations"))
    assert found.mean_m == pytest.approx(0.0, abs=1e-6)
    assert found.relations == 3  # the first pose has none before it to interpolate from


def test_unreadable_relations_are_named(tmp_path):
    (tmp_path / "r.relations").write_text("1 2 3\n")
    with pytest.raises(EvaluationError, match=r"r\.relations has to hold eight numbers"):
        read_relations(tmp_path / "r.relations")
    with pytest.raises(EvaluationError, match="cannot read the relations"):
        read_relations(tmp_path / "absent")


def test_an_honest_estimator_is_consistent_and_a_vain_one_is_not():
    rng = np.random.default_rng(8)
    roots = rng.normal(size=(400, 3, 3))
    covariances = roots @ roots.transpose(0, 2, 1) + 0.1 * np.eye(3)
    errors = np.einsum("nij,nj->ni", np.linalg.cholesky(covariances), rng.normal(size=(400, 3)))
    honest = consistency(errors, covariances)
    assert honest.consistent
    assert (honest.lower, honest.upper) == pytest.approx(chi2.ppf([0.025, 0.975], 1200) / 400)
    assert honest.average == pytest.approx(
        np.mean([e @ np.linalg.inv(P) @ e for e, P in zip(errors, covariances, strict=True)])
    )
    assert not consistency(errors, covariances / 4.0).consistent
    assert not consistency(errors, covariances * 4.0).consistent


def test_coverage_counts_only_what_could_be_seen():
    observable = np.array([[True, True], [True, False]])
    seen = np.array([[True, False], [True, True]])
    assert coverage(seen, observable) == pytest.approx(2.0 / 3.0)
    with pytest.raises(EvaluationError, match="no cell"):
        coverage(seen, np.zeros((2, 2), bool))


@pytest.fixture(scope="module")
def judge():
    if not JUDGE.exists():
        pytest.skip("the judge is not part of the project; it lies in ../shared/tools where that is present")
    spec = importlib.util.spec_from_file_location("judge", JUDGE)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.data
@pytest.mark.parametrize("seed", range(5))
def test_absolute_error_agrees_with_the_judge(judge, seed):
    rng = np.random.default_rng(seed)
    truth = wander(rng, 600)
    keep = rng.random(600) < 0.9
    keep[300:310] = False  # a gap of a second
    truth = Trajectory(truth.stamps_s[keep], truth.poses[keep])
    dense = carried(
        wander(np.random.default_rng(seed), 600), Pose2(1.0, 2.0, 3.0), rng.normal(0.0, 0.2, (600, 3))
    )
    estimate = Trajectory(dense.stamps_s - 5.0 + 0.013, dense.poses)
    theirs, poses = judge.ate(estimate.stamps_s, estimate.poses, truth.stamps_s, truth.poses)
    ours = absolute_error(estimate, truth)
    assert ours.rmse_m == pytest.approx(theirs, rel=1e-9)
    assert ours.poses == poses


@pytest.mark.data
def test_relations_error_agrees_with_the_judge(judge, tmp_path):
    rng = np.random.default_rng(9)
    estimate = wander(rng, 400, 0.5)
    shuffled = np.r_[0:100, 98, 101:200, 260:400]  # one stamp backwards, a gap of 30 s
    estimate = Trajectory(estimate.stamps_s[shuffled], estimate.poses[shuffled])
    times = rng.uniform(95.0, 305.0, (200, 2))
    relations = np.column_stack([times, rng.normal(size=(200, 2)), np.zeros((200, 3)), rng.normal(size=200)])
    np.savetxt(tmp_path / "r.relations", relations, fmt="%.9f")
    write_tum(tmp_path / "t.tum", estimate)
    theirs, count = judge.relations(tmp_path / "r.relations", tmp_path / "t.tum")
    ours = relations_error(estimate, read_relations(tmp_path / "r.relations"))
    assert ours.mean_m == pytest.approx(theirs, rel=1e-5)
    assert ours.relations == count


def test_places_are_compared_by_name_and_whatever_their_frame():
    truth = {"a": (0.0, 0.0), "b": (3.0, 0.0), "c": (0.0, 4.0), "d": (9.0, 9.0)}
    turned = {name: (1.0 - y, 2.0 + x) for name, (x, y) in truth.items()} | {"e": (7.0, 7.0)}
    assert places_error(turned, truth).mean_m == pytest.approx(0.0, abs=1e-9)
    assert places_error(turned, truth).places == 4
    mirrored = {name: (-x, y) for name, (x, y) in truth.items()}
    assert places_error(mirrored, truth).max_m > 1.0
    with pytest.raises(EvaluationError, match="only 2 places are known in truth; three are needed"):
        places_error({"a": (0.0, 0.0), "b": (1.0, 0.0), "x": (2.0, 0.0)}, truth)
