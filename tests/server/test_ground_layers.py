"""How well ground was looked at, a robot's own map, and whether a robot was heard: laws and exact cases."""

from __future__ import annotations

import zlib
from math import pi

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from robots.se2 import Pose2
from robots.team import TeamGrid
from robots.types import SubmapReport
from server.ground_layers import CLEARED, SAFE, SEEN, came_late, coarse, coverage, in_world, own_map


def room(resolution_m: float = 0.05) -> TeamGrid:
    """A room of 8 by 4 m with a wall across at x = 5 m and a door in its upper half."""
    cells = np.zeros((80, 160), np.int8)
    cells[[0, -1], :] = cells[:, [0, -1]] = 100
    cells[:40, 100] = 100
    return TeamGrid(cells, (0.0, 0.0), resolution_m, 1)


def at(classes: np.ndarray, cell_m: float, x_m: float, y_m: float) -> int:
    return int(classes[int(y_m / cell_m), int(x_m / cell_m)])


def test_what_a_robot_was_near_is_safe_and_where_it_looked_is_cleared() -> None:
    classes, cell_m = coverage(room(), [np.array([[2.0, 1.0, 0.0]])], safe_m=3.0)
    assert cell_m == 0.2
    assert at(classes, cell_m, 4.0, 1.0) == CLEARED  # ahead
    assert at(classes, cell_m, 2.0, 3.0) == SAFE  # aside
    assert at(classes, cell_m, 6.0, 1.0) == SEEN  # behind the wall, and too far
    assert at(classes, cell_m, 5.1, 1.0) == 0  # the wall
    turned, _ = coverage(room(), [np.array([[2.0, 1.0, pi]])], safe_m=3.0)
    assert at(turned, cell_m, 4.0, 1.0) == SAFE


@given(st.lists(st.tuples(st.floats(0.5, 7.5), st.floats(0.5, 3.5), st.floats(-pi, pi)), max_size=4))
def test_more_way_never_takes_ground_back(poses: list[tuple[float, float, float]]) -> None:
    way = np.array(poses).reshape(-1, 3)
    all_of_it, _ = coverage(room(), [way], 3.0)
    some, _ = coverage(room(), [way[:-1]], 3.0)
    apart, _ = coverage(room(), [way[:1], way[1:]], 3.0)
    assert (some <= all_of_it).all()
    assert (apart == all_of_it).all()
    assert ((all_of_it > 0) == (coverage(room(), [], 3.0)[0] > 0)).all()


def test_a_thin_wall_stays_closed_in_the_coarse_grid() -> None:
    assert (coarse(room()).cells[: 40 // 4, 100 // 4] == 2).all()


def test_a_robots_own_map_lies_where_its_anchors_are() -> None:
    cells = np.full((10, 20), -20, np.int8)
    cells[0] = 20
    report = SubmapReport(0, 1, Pose2(0.0, 0.0, 0.0), 0.1, 20, 10, zlib.compress(cells.tobytes()))
    unknown = SubmapReport(7, 1, Pose2(0.0, 0.0, 0.0), 0.1, 20, 10, zlib.compress(cells.tobytes()))
    grid = own_map([report, unknown], np.array([[3.0, 1.0, 0.0]]))
    assert grid is not None
    assert np.allclose(grid.origin_m, (3.0, 1.0), atol=0.051)
    assert ((grid.cells == 100).sum(), (grid.cells == 0).sum()) == (20, 180)
    assert own_map([unknown], np.array([[3.0, 1.0, 0.0]])) is None


def test_a_way_is_turned_with_its_anchor() -> None:
    way = np.array([[5, 1.0, 0, 1.0, 0.0, 0.5], [6, 1.2, 3, 9.0, 9.0, 0.0]])
    assert np.allclose(in_world(np.array([[2.0, 2.0, pi / 2]]), way), [[2.0, 3.0, pi / 2 + 0.5]])


@given(st.floats(-1e9, 1e9), st.floats(0.5, 20.0))
def test_what_came_at_once_was_heard_whatever_the_clocks_and_the_speed(offset_s: float, speed: float) -> None:
    stamps = np.arange(0.0, 60.0, 0.2)
    assert not came_late(stamps, stamps / speed + offset_s).any()


def test_a_backlog_was_not_heard_but_for_its_end() -> None:
    stamps = np.arange(0.0, 60.0, 0.2)
    received = stamps + 100.0
    silent = (stamps >= 20.0) & (stamps <= 40.0)
    received[silent] = 140.05  # all of it in one batch
    late = came_late(stamps, received)
    assert not late[~silent].any()
    assert late[silent & (stamps < 34.9)].all()
    assert not came_late(np.zeros(0), np.zeros(0)).any()
