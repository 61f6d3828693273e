"""The batch solve of ranges: derivatives, exactness, calibration, mirrored nodes, honest covariances."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.config import AgentConfig
from robots.estimation.ranges.errors import error_lasts_s, shares
from robots.estimation.ranges.factors import Ranges, range_errors
from robots.estimation.ranges.smoothing import RangeSolution, smooth_ranges
from robots.estimation.ranges.views import as_sightings, views_of
from robots.estimation.tag_graph.graph import graph_problem
from robots.estimation.tag_graph.smoothing import smooth_radio
from robots.graph_report import GraphReport
from robots.se2 import Pose2, wrap

SCALE, OFFSETS, SD_M, BEARING_SD = 1.07, np.array([0.10, -0.05, 0.0, 0.06]), 0.08, 0.02
TAGS = np.array([[-2.0, 3.0], [7.0, 7.5], [12.0, -3.0], [4.0, -4.0]])
STEP_SD = np.array([0.01, 0.003, 0.005])


def loop(laps: int = 2, straight: bool = False) -> np.ndarray:
    """Poses (n, 3) half a metre apart: round a rectangle of 10 x 5 m, or along a line."""
    step = np.tile([[0.5, 0.0, 0.0]], (60 * laps, 1))
    if not straight:
        for corner in (19, 29, 49, 59):
            step[corner::60, 2] = np.pi / 2
    pose, poses = Pose2(), [Pose2()]
    for row in step:
        pose = pose @ Pose2.from_array(row)
        poses.append(pose)
    return np.array([p.as_array() for p in poses])


def drive(
    seed: int | None, bearings: bool, poses: np.ndarray | None = None, lasts_s: float = 0.0
) -> GraphReport:
    """A report of a drive, at dead reckoning's poses; without a seed poses, sightings and radios are exact.

    Errors of range last for ``lasts_s``.
    """
    rng = np.random.default_rng(seed)
    truth = loop() if poses is None else poses
    noise = 0.0 if seed is None else 1.0
    edges, reckoned = [], [Pose2.from_array(truth[0])]
    for a, b in pairwise(truth):
        edge = Pose2.from_array(a).between(Pose2.from_array(b)).as_array()
        edges.append(edge + noise * STEP_SD * rng.normal(size=3))
        reckoned.append(reckoned[-1] @ Pose2.from_array(edges[-1]))
    n, m = len(truth), len(TAGS)
    pairs = np.array([(i, j) for i in range(n) for j in range(m)])
    arm = Pose2(0.2, 0.05, 0.3)
    antennas = [Pose2.from_array(pose) @ arm for pose in truth]
    seen = [antennas[i].inverse().transform_point(*TAGS[j]) for i, j in pairs]
    rho = np.exp(-1.0 / lasts_s) if lasts_s else 0.0
    errors = rng.normal(size=(n, m))
    for k in range(1, n):
        errors[k] = rho * errors[k - 1] + np.sqrt(1.0 - rho**2) * errors[k]
    lengths = np.hypot(*np.array(seen).T)
    if not bearings:
        lengths = lengths if seed is None else SCALE * lengths + OFFSETS[pairs[:, 1]]
    angles = np.array([np.arctan2(y, x) for x, y in seen])
    return GraphReport(
        poses=np.array([pose.as_array() for pose in reckoned]),
        stamps_s=np.arange(n, dtype=float),
        yaws_rad=np.full(n, np.nan),
        tag_ids=tuple(f"n{j}" for j in range(m)),
        tags=TAGS + noise * rng.normal(scale=0.3, size=(m, 2)),
        edge_pairs=np.column_stack([np.arange(n - 1), np.arange(1, n)]),
        edge_poses=np.array(edges),
        edge_covariances=np.tile(np.diag(STEP_SD**2), (n - 1, 1, 1)),
        sighting_pairs=np.zeros((0, 2), np.int64),
        sighting_offsets=np.zeros((0, 2)),
        sighting_covariances=np.zeros((0, 2, 2)),
        range_pairs=pairs,
        range_poses=np.tile(arm.as_array(), (len(pairs), 1)),
        ranges_m=lengths + noise * SD_M * errors[pairs[:, 0], pairs[:, 1]],
        range_sds_m=np.full(len(pairs), SD_M),
        bearings_rad=angles + noise * BEARING_SD * rng.normal(size=len(pairs))
        if bearings
        else angles * np.nan,
        bearing_sds_rad=np.full(len(pairs), BEARING_SD if bearings else np.nan),
        range_offsets_m=np.zeros(m),
    )


def solved(report: GraphReport) -> RangeSolution:
    links_from = len(report.edge_pairs) + len(report.sighting_pairs)
    return smooth_ranges(graph_problem(as_sightings(report)), views_of(report, links_from))


numbers = st.floats(-3.0, 3.0)


@given(st.lists(numbers, min_size=9, max_size=9), st.lists(numbers, min_size=3, max_size=3), st.booleans())
def test_jacobians_agree_with_finite_differences(
    values: list[float], arm: list[float], directed: bool
) -> None:
    state = np.array(values).reshape(3, 3) + np.array([[0.0, 0, 0], [9.0, 0, 0], [4.0, 0, 0]])
    index, one = np.arange(3).reshape(3, 1), np.ones(1)
    bearing = 0.4 * one if directed else np.full(1, np.nan)
    rows = Ranges(
        *index, np.zeros((1, 3), np.int64), np.array([arm]) / 3.0, 5.0 * one, one, bearing, one,
        np.ones((1, 2)), np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros((0, 3)),
    )  # fmt: skip
    J, spare, h = np.empty((2, 9)), np.empty((2, 9)), 1e-6
    range_errors(state, rows, 0, J)
    for d in range(9):
        step = np.zeros(9)
        step[d] = h
        after = range_errors(state + step.reshape(3, 3), rows, 0, spare)
        before = range_errors(state - step.reshape(3, 3), rows, 0, spare)
        slope = [(after[0] - before[0]) / (2 * h), wrap(after[1] - before[1]) / (2 * h)]
        np.testing.assert_allclose(J[:, d], slope, atol=2e-6)


@pytest.mark.parametrize("bearings", [True, False])
def test_without_noise_the_solution_is_exact(bearings: bool) -> None:
    report = drive(None, bearings)
    rng = np.random.default_rng(0)
    bent = report.poses + np.append(
        np.zeros((1, 3)), rng.normal(scale=0.05, size=(len(report.poses) - 1, 3)), 0
    )
    begun = replace(report, poses=bent, tags=TAGS + 0.4, edge_covariances=report.edge_covariances)
    found = solved(begun)
    np.testing.assert_allclose(found.graph.tags, TAGS, atol=1e-3)
    np.testing.assert_allclose(found.graph.poses[:, :2], report.poses[:, :2], atol=1e-3)
    np.testing.assert_allclose(found.scales, 1.0, atol=1e-3)


def test_scale_and_offsets_of_radios_are_found() -> None:
    scales, offsets = [], []
    for seed in range(25):
        found = solved(drive(seed, bearings=False))
        n, m = len(found.graph.poses), len(TAGS)
        joint = found.solution.marginals.joint(np.arange(n, n + m + 1))
        sds = np.sqrt(np.diag(joint))
        scales.append((found.scales[0] - SCALE) / sds[3 * m])
        offsets.append((found.offsets_m - OFFSETS) / sds[2 : 3 * m : 3])
    assert np.abs(np.mean(scales)) < 0.6
    assert 0.4 < np.mean(np.square(scales)) < 2.0
    assert 0.4 < np.mean(np.square(offsets)) < 1.6


@pytest.mark.parametrize("bearings", [True, False])
def test_covariances_are_honest(bearings: bool) -> None:
    nees = []
    for seed in range(25):
        found = solved(drive(seed, bearings))
        first = len(found.graph.poses)
        joint = found.solution.marginals.joint(np.arange(first, first + len(TAGS)))
        keep = np.flatnonzero(np.arange(len(joint)) % 3 < 2)
        error = (found.graph.tags - TAGS).ravel()
        nees.append(error @ np.linalg.solve(joint[np.ix_(keep, keep)], error) / len(error))
    assert 0.6 < np.mean(nees) < 1.5


def test_errors_that_last_do_not_count_as_many() -> None:
    nees, lasts = [], []
    for seed in range(25):
        found = solved(drive(seed, True, lasts_s=8.0))
        first = len(found.graph.poses)
        joint = found.solution.marginals.joint(np.arange(first, first + len(TAGS)))
        keep = np.flatnonzero(np.arange(len(joint)) % 3 < 2)
        error = (found.graph.tags - TAGS).ravel()
        nees.append(error @ np.linalg.solve(joint[np.ix_(keep, keep)], error) / len(error))
        lasts.append(found.lasts_s)
    assert 4.0 <= np.median([each[0] for each in lasts]) <= 12.0
    assert np.median([each[1] for each in lasts]) == 0.0
    assert np.mean(nees) < 2.0


def test_a_mirrored_node_is_put_on_its_side_of_the_way() -> None:
    report = drive(3, bearings=False)
    mirrored = report.tags.copy()
    mirrored[0] = (-2.0, -3.0)  # the way begins along y = 0, between the two
    mirrored[3] = (4.0, 4.0)
    found = solved(replace(report, tags=mirrored))
    assert np.hypot(*(found.graph.tags - TAGS).T).max() < 0.3


def test_a_straight_way_leaves_a_node_where_the_filter_had_it() -> None:
    report = drive(2, bearings=False, poses=loop(straight=True, laps=1)[:40])
    mirrored = TAGS * [1.0, -1.0]
    for tags in (TAGS, mirrored):  # both fit alike: neither is better
        found = solved(replace(report, tags=tags.copy()))
        assert (np.sign(found.graph.tags[:, 1]) == np.sign(tags[:, 1])).all()


def test_what_is_wrong_is_let_go() -> None:
    report = drive(4, bearings=False)
    ranges = report.ranges_m.copy()
    ranges[::9] += 6.0
    found = solved(replace(report, ranges_m=ranges))
    assert np.hypot(*(found.graph.tags - TAGS).T).max() < 0.3


def test_a_report_comes_back_smoothed_and_calibrated() -> None:
    report = drive(1, bearings=False)
    smoothed = smooth_radio(report, AgentConfig())
    truth = loop()
    assert (
        np.hypot(*(smoothed.poses - truth)[:, :2].T).mean()
        < 0.5 * np.hypot(*(report.poses - truth)[:, :2].T).mean()
    )
    assert smoothed.range_scale == pytest.approx(SCALE, abs=0.03)
    again = smooth_radio(smoothed, AgentConfig())
    np.testing.assert_allclose(again.poses, smoothed.poses, atol=5e-3)


def test_one_range_to_one_node_is_survived() -> None:
    report = drive(1, bearings=False)
    few = replace(
        report,
        range_pairs=report.range_pairs[:1],
        range_poses=report.range_poses[:1],
        ranges_m=report.ranges_m[:1],
        range_sds_m=report.range_sds_m[:1],
        bearings_rad=report.bearings_rad[:1],
        bearing_sds_rad=report.bearing_sds_rad[:1],
        tag_ids=report.tag_ids[:1],
        tags=report.tags[:1],
        range_offsets_m=np.zeros(1),
    )
    smoothed = smooth_radio(few, AgentConfig())
    assert np.isfinite(smoothed.tags).all()
    np.testing.assert_allclose(smoothed.poses, few.poses, atol=0.05)


def test_shares_of_sightings_far_apart_are_whole() -> None:
    stamps, series = np.array([0.0, 1.0, 100.0, 0.5]), np.array([0, 0, 0, 1])
    found = shares(stamps, series, 2.0)
    expected = 1.0 / (1.0 + np.exp(-0.5))
    np.testing.assert_allclose(found, [expected, expected, 1.0, 1.0], atol=1e-12)
    np.testing.assert_array_equal(shares(stamps, series, 0.0), 1.0)


@given(st.permutations(range(6)))
def test_shares_do_not_depend_on_the_order_of_rows(order: list[int]) -> None:
    stamps, series = np.array([0.0, 1.0, 2.5, 3.0, 0.5, 9.0]), np.array([0, 0, 0, 1, 1, 0])
    np.testing.assert_allclose(
        shares(stamps[order], series[order], 3.0), shares(stamps, series, 3.0)[order], rtol=1e-12
    )


def test_few_errors_tell_nothing_of_how_long_they_last() -> None:
    assert error_lasts_s(np.ones(20), np.arange(20.0), np.zeros(20, np.int64)) == 0.0
    assert error_lasts_s(np.full(200, np.nan), np.arange(200.0), np.zeros(200, np.int64)) == 0.0
