"""The correction of one range against dense Kalman filters and finite differences."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.estimation.rslam.range_kernels import (
    ROWS,
    WORK_ROWS,
    age_offset,
    correct,
    innovations,
    settle,
    spread_of,
)

FEW = (1e-9, 20.0)  # outliers: so rare that they do not count


def block_of(mean: np.ndarray, by_scale: np.ndarray, spread: np.ndarray) -> np.ndarray:
    rows = (0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2)
    return np.array([*mean, *by_scale, *(spread[i, j] for i, j in rows)])[:, None]


def some_block(random: np.random.Generator, sd: float) -> np.ndarray:
    root = random.normal(size=(3, 3)) * sd
    place = random.uniform(5.0, 20.0, 2) * random.choice([-1, 1], 2)
    by_scale = random.normal(size=3) * 0.1
    return block_of(np.array([*place, 0.2]) - by_scale, by_scale, root @ root.T + np.eye(3) * sd**2 * 0.1)


def joint_of(blocks: list[np.ndarray], scales: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mean and covariance of (x, y, o) of every node and of the scale, at the end."""
    size = 3 * len(blocks) + 1
    mean, covariance = np.zeros(size), np.zeros((size, size))
    by_scale = np.zeros(size)
    by_scale[-1] = 1.0
    for k, block in enumerate(blocks):
        at = slice(3 * k, 3 * k + 3)
        by_scale[at] = block[3:6, 0]
        mean[at] = block[:3, 0] + by_scale[at] * scales[0, 0]
        xx, xy, yy, xo, yo, oo = block[6:, 0]
        covariance[at, at] = [[xx, xy, xo], [xy, yy, yo], [xo, yo, oo]]
    mean[-1] = scales[0, 0]
    return mean, covariance + scales[1, 0] * np.outer(by_scale, by_scale)


@given(st.integers(0, 2**32 - 1))
def test_nodes_given_the_scale_are_the_joint_kalman_filter(seed):
    random = np.random.default_rng(seed)
    blocks = [some_block(random, 1e-3) for _ in range(3)]  # so sure that the range is as good as linear
    scales = np.array([[1.0], [0.05**2]])
    robot, variance = np.array([[0.5], [-0.3]]), 0.3**2
    for k in (0, 1, 2, 1, 0):
        mean, covariance = joint_of(blocks, scales)
        apart = mean[3 * k : 3 * k + 2] - robot[:, 0]
        d = np.hypot(*apart)
        range_m = mean[-1] * d + mean[3 * k + 2] + random.normal() * 0.3
        row = np.zeros(len(mean))
        row[3 * k : 3 * k + 2], row[3 * k + 2], row[-1] = mean[-1] * apart / d, 1.0, d
        expected_variance = row @ covariance @ row + variance
        innovation = range_m - mean[-1] * d - mean[3 * k + 2]
        gain = covariance @ row / expected_variance
        work = np.empty((WORK_ROWS, 1))
        innovations(blocks[k], scales, robot, range_m, (0.3, 0.0), FEW, work)
        assert work[1, 0] == pytest.approx(expected_variance, rel=1e-3)
        likely = -0.5 * (innovation**2 / expected_variance + np.log(2 * np.pi * expected_variance))
        assert work[2, 0] == pytest.approx(likely, abs=1e-2)
        correct(blocks[k], scales, work, True)
        mean, covariance = mean + gain * innovation, covariance - np.outer(gain, row @ covariance)
        ours, spread = joint_of(blocks, scales)
        assert ours == pytest.approx(mean, rel=1e-3, abs=1e-3)
        assert spread == pytest.approx(covariance, rel=1e-2, abs=1e-6)


@given(st.integers(0, 2**32 - 1))
def test_derivatives_are_those_of_the_measurement(seed):
    random = np.random.default_rng(seed)
    block, scales = some_block(random, 1e-5), np.array([[1.1], [1e-9]])
    robot = random.normal(size=(2, 1))

    def predicted(block: np.ndarray, scale: float) -> float:
        work = np.empty((WORK_ROWS, 1))
        innovations(block, np.array([[scale], [1e-9]]), robot, 0.0, (1.0, 0.0), FEW, work)
        return -float(work[0, 0])

    work = np.empty((WORK_ROWS, 1))
    innovations(block, scales, robot, 0.0, (1.0, 0.0), FEW, work)
    step = 1e-5
    for row, ours in ((0, work[4, 0]), (1, work[5, 0]), (2, 1.0)):
        up, down = block.copy(), block.copy()
        up[row] += step
        down[row] -= step
        assert (predicted(up, 1.1) - predicted(down, 1.1)) / (2 * step) == pytest.approx(ours, abs=1e-5)
    by_scale = (predicted(block, 1.1 + step) - predicted(block, 1.1 - step)) / (2 * step)
    assert by_scale == pytest.approx(work[6, 0], abs=1e-4)


def test_a_range_that_is_far_off_hardly_moves_a_node_and_bounds_what_a_particle_loses():
    block, scales = (
        block_of(np.array([5.0, 0.0, 0.0]), np.zeros(3), np.eye(3) * 0.01),
        np.array([[1.0], [1e-6]]),
    )
    work = np.empty((WORK_ROWS, 1))
    innovations(block, scales, np.zeros((2, 1)), 25.0, (0.2, 0.0), (0.02, 20.0), work)
    assert work[3, 0] < 1e-6
    assert work[2, 0] == pytest.approx(np.log(0.02 / 20.0), abs=1e-6)
    correct(block, scales, work, True)
    assert abs(block[0, 0] + block[3, 0] - 5.0) < 0.2  # not by metres


def test_an_offset_that_fades_forgets_and_keeps_its_prior():
    block = block_of(np.array([5.0, 1.0, 0.4]), np.array([0.0, 0.0, 0.3]), np.eye(3) * 0.01)
    age_offset(block, 0.5, 0.09 * (1.0 - 0.25))
    assert block[2, 0] == pytest.approx(0.2)
    assert block[11, 0] == pytest.approx(0.25 * 0.01 + 0.0675)
    for _ in range(40):
        age_offset(block, 0.5, 0.09 * (1.0 - 0.25))
    assert block[11, 0] == pytest.approx(0.09)


def test_from_exact_ranges_a_node_begins_where_it_is():
    random = np.random.default_rng(3)
    node, antennas = np.array([4.0, 7.0]), random.uniform(-5.0, 5.0, (12, 2, 1))
    ranges = 1.06 * np.hypot(antennas[:, 0, 0] - node[0], antennas[:, 1, 0] - node[1]) + 0.15
    block, scales, fits = np.empty((ROWS, 1)), np.array([[1.0], [0.2**2]]), np.empty(1)
    for _ in range(4):  # the scale is linear in a solution about the last one
        start = (4.5, 6.0)
        settle(block, scales, antennas, ranges, np.tile([0.01, 0.0], (12, 1)), start, 1.0, fits, True)
    mean = spread_of(block, scales, np.ones(1))[0]
    assert scales[0, 0] == pytest.approx(1.06, abs=2e-3)
    assert mean == pytest.approx([4.0, 7.0, 0.15], abs=2e-2)
