"""Votes for the place of a node."""

import numpy as np
import pytest

from robots.config import RangeSlamConfig
from robots.estimation.rslam.nodes import Node
from robots.estimation.rslam.places import vote

NODE = np.array([3.0, 8.0])


def by_metre(count: int, sd_m: float) -> np.ndarray:
    return np.column_stack([np.full(count, sd_m), np.zeros(count)])


def ranges_to(antennas: np.ndarray, scale: float = 1.0) -> np.ndarray:
    return scale * np.hypot(*(antennas - NODE).T)


def test_round_a_corner_there_is_one_place():
    antennas = np.array([[float(x), 0.0] for x in range(6)] + [[5.0, float(y)] for y in range(1, 6)])
    (found,) = vote(antennas, ranges_to(antennas, 1.05), by_metre(11, 0.05), (1.0, 0.05), 0.1)
    assert (found.x_m, found.y_m) == pytest.approx(tuple(NODE), abs=1.0)
    assert found.share > 0.95


def test_on_a_straight_way_there_are_two():
    antennas = np.array([[x * 0.8, 0.0] for x in range(12)])
    found = vote(antennas, ranges_to(antennas), by_metre(12, 0.05), (1.0, 0.02), 0.1)
    assert sorted(np.sign(each.y_m) for each in found) == [-1.0, 1.0]
    assert [each.share for each in found] == pytest.approx([0.5, 0.5], abs=0.05)


@pytest.mark.parametrize("count", [1, 3])
def test_from_about_one_point_it_is_left_open(count):
    antennas = np.array([[0.05 * k, 0.0] for k in range(count)])
    assert vote(antennas, ranges_to(antennas), by_metre(count, 0.2), (1.0, 0.05), 0.1) == ()


def test_ranges_that_cannot_be_true_together_have_no_place():
    antennas = np.array([[0.0, 0.0], [100.0, 0.0], [0.0, 100.0], [100.0, 100.0]])
    assert vote(antennas, np.full(4, 5.0), by_metre(4, 0.1), (1.0, 0.05), 0.1) == ()


def test_a_node_waits_for_its_place_while_signals_leave_it_too_wide_for_a_filter() -> None:
    """Where signals pin a place badly, Gauss-Newton runs off: that was once taken for one known place."""
    scales, weights = np.array([np.ones(20), np.full(20, 1e-3)]), np.full(20, 0.05)
    placed = 0
    for seed in range(80):
        random, node = np.random.default_rng(seed), Node()
        true, middle = random.uniform([-30.0, -30.0], [30.0, 30.0]), np.zeros(2)
        heading, here = 0.0, np.zeros(2)
        for step in range(150):
            heading += 0.1 * random.standard_normal()
            here = here + 0.5 * np.array([np.cos(heading), np.sin(heading)])
            middle += (here - middle) / (step + 1)
            heard_m = float(np.hypot(*(true - here)) * np.exp(0.45 * random.standard_normal()))
            antennas = here[:, None] + 0.02 * step * random.standard_normal((2, 20))
            if node.gathered.add(heard_m, (0.0, 0.45), antennas, weights):
                node.place(scales, weights, RangeSlamConfig())
            if node.is_placed:
                break
        placed += node.is_placed
        for block in node.blocks:
            away = np.hypot(*(block[:2] + block[3:5] - middle[:, None]))
            assert np.median(np.sqrt((block[6] + block[8]) / 2.0) / away) < 0.45
    assert placed > 20
