"""Votes for the place of a node."""

import numpy as np
import pytest

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
