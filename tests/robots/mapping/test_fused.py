"""Drawing submaps into one grid: where they come to lie, and when a drawing is kept."""

import numpy as np
import pytest

from robots.mapping.fused import FusedGrid
from robots.se2 import Pose2

WALL = np.array([[0, 0, 0, 0], [9, 9, 9, 9], [0, 0, 0, 0]], np.int16)


def value_at(grid: FusedGrid, x: float, y: float) -> int:
    row = int(np.floor((y - grid.origin[1]) / grid.resolution_m))
    column = int(np.floor((x - grid.origin[0]) / grid.resolution_m))
    inside = 0 <= row < grid.cells.shape[0] and 0 <= column < grid.cells.shape[1]
    return int(grid.cells[row, column]) if inside else 0


def test_cells_lie_where_the_pose_puts_their_corner():
    grid = FusedGrid(0.5)
    grid.put("a", 0, Pose2(2.0, -3.0), WALL)
    assert [value_at(grid, x, -2.25) for x in (1.75, 2.25, 3.75, 4.25)] == [0, 9, 9, 0]
    assert [value_at(grid, 2.25, y) for y in (-2.75, -2.25, -1.75)] == [0, 9, 0]


def test_a_quarter_turn_turns_the_wall():
    grid = FusedGrid(0.5)
    grid.put("a", 0, Pose2(2.0, -3.0, np.pi / 2.0), WALL)
    assert [value_at(grid, 1.25, y) for y in (-3.25, -2.75, -1.25, -0.75)] == [0, 9, 9, 0]
    assert grid.cells.sum() == WALL.sum()


def test_growing_keeps_every_drawing_in_its_place():
    grid = FusedGrid(0.1)
    places = [(0.0, 0.0), (40.0, -3.0), (-35.0, 20.0), (2.0, 60.0), (-1.0, -50.0)]
    for key, (x, y) in enumerate(places):
        grid.put(key, 0, Pose2(x, y), np.full((2, 2), key + 1, np.int8))
    for key, (x, y) in enumerate(places):
        assert value_at(grid, x + 0.05, y + 0.05) == key + 1
        assert value_at(grid, x + 0.15, y + 0.15) == key + 1
    assert np.count_nonzero(grid.cells) == 4 * len(places)


def test_many_submaps_over_each_other_do_not_overflow():
    grid = FusedGrid(0.1)
    for key in range(2000):
        grid.put(key, 0, Pose2(), np.full((3, 3), 40, np.int16))
    assert grid.cells.max() == 80_000


def test_a_drawing_stays_until_it_moved_farther_than_the_tolerance_at_its_far_corner():
    cells = np.ones((3, 200), np.int16)  # 20 m long
    grid = FusedGrid(0.1)
    grid.put("a", 0, Pose2(), cells)
    assert not grid.put("a", 0, Pose2(0.009, 0.0), cells)
    assert not grid.put("a", 0, Pose2(0.0, 0.0, 0.0004), cells)
    assert grid.put("a", 0, Pose2(0.0, 0.0, 0.01), cells)  # 20 cm at the far corner
    assert value_at(grid, 19.95, 0.45) == 1
    assert grid.put("a", 0, Pose2(0.5, 0.0, 0.01), cells)


def test_small_moves_add_up():
    cells = np.ones((3, 3), np.int16)
    grid = FusedGrid(0.1)
    grid.put("a", 0, Pose2(), cells)
    changed = [grid.put("a", 0, Pose2(0.004 * k, 0.0), cells) for k in range(1, 6)]
    assert changed == [False, False, True, False, False]


def test_a_new_version_is_drawn_in_place():
    grid = FusedGrid(0.1)
    grid.put("a", 0, Pose2(), np.full((2, 2), 5, np.int16))
    assert grid.put("a", 1, Pose2(), np.full((2, 3), 7, np.int16))
    assert value_at(grid, 0.05, 0.05) == 7
    assert grid.cells.sum() == 42


def test_an_empty_version_takes_the_drawing_away():
    grid = FusedGrid(0.1)
    empty = np.zeros((0, 0), np.int16)
    assert not grid.put("a", 0, Pose2(), empty)
    grid.put("a", 1, Pose2(), np.full((2, 2), 5, np.int16))
    assert grid.put("a", 2, Pose2(), empty)
    assert not grid.cells.any()
    grid.drop("a")
    assert not grid.cells.any()


def test_dropping_what_is_not_there_changes_nothing():
    grid = FusedGrid(0.1)
    grid.put("a", 0, Pose2(), WALL)
    before = grid.cells.copy()
    grid.drop("b")
    np.testing.assert_array_equal(grid.cells, before)


def test_origin_is_a_whole_number_of_cells():
    grid = FusedGrid(0.05)
    grid.put("a", 0, Pose2(1.234, -7.77, 0.4), WALL)
    for value in grid.origin:
        assert value / 0.05 == pytest.approx(round(value / 0.05))
