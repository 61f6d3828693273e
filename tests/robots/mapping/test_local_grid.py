"""The grid that goes along with the robot."""

import numpy as np

from robots.config import MappingConfig
from robots.mapping.local_grid import RESOLUTION_M, LocalGrid
from robots.se2 import Pose2
from robots.types import LaserScan

BEAMS = np.linspace(-np.pi, np.pi, 720, endpoint=False)


def corridor_scan(pose: Pose2, reach_m=4.0) -> LaserScan:
    """What a laser sees all round in a corridor along x whose walls are at y = -1 and y = 1."""
    directions = BEAMS + pose.theta
    with np.errstate(divide="ignore"):
        ranges = np.where(
            np.sin(directions) > 0, (1.0 - pose.y) / np.sin(directions), (-1.0 - pose.y) / np.sin(directions)
        )
    return LaserScan(np.minimum(ranges, reach_m).astype(np.float32), -np.pi, 2 * np.pi / 720, reach_m)


def grid_at(*poses: Pose2, side_m=4.0) -> LocalGrid:
    grid = LocalGrid(side_m, MappingConfig(), 0.22)
    for pose in poses:
        for _ in range(3):
            grid.see(pose, corridor_scan(pose))
    return grid


def cell(grid: LocalGrid, x: float, y: float) -> int:
    left, low = grid.origin
    return int(grid.cells[int((y - low) // RESOLUTION_M), int((x - left) // RESOLUTION_M)])


def test_it_holds_a_square_round_the_robot_and_a_ring_of_the_unknown():
    grid = grid_at(Pose2(10.0, 0.0, 0.0))
    assert grid.cells.shape == (108, 108)
    np.testing.assert_allclose(grid.origin, (7.84, -2.16), atol=0.16)
    assert not grid.cells[0].any()
    assert not grid.cells[:, -1].any()
    assert cell(grid, 11.5, 0.5) < 0
    assert cell(grid, 11.5, 1.02) > 0
    assert cell(grid, 11.5, 1.5) == 0


def test_what_it_leaves_behind_is_forgotten_and_what_it_keeps_stays_where_it_lies():
    poses = [Pose2(0.2 * k, 0.0, 0.0) for k in range(8)]
    grid = grid_at(*poses)
    blind = LaserScan(np.zeros(0, np.float32), 0.0, 0.01, 4.0)
    before = {x: (cell(grid, x, 0.3), cell(grid, x, 1.02)) for x in (1.02, 2.02, 2.98)}
    grid.see(Pose2(1.7, 0.0, 0.0), blind)
    assert {x: (cell(grid, x, 0.3), cell(grid, x, 1.02)) for x in (1.02, 2.02, 2.98)} == before
    for k in range(30):
        grid.see(Pose2(1.7 + 0.3 * k, 0.0, 0.0), blind)
    assert not grid.cells.any()


def test_when_the_map_moves_under_it_what_is_round_the_robot_stays_round_it():
    grid = grid_at(Pose2(0.0, 0.0, 0.0))
    before = grid.cells.copy()
    grid.see(Pose2(2.0, 0.8, 0.0), LaserScan(np.zeros(0, np.float32), 0.0, 0.01, 4.0))
    np.testing.assert_array_equal(grid.cells, before)
    assert cell(grid, 2.5, 1.82) > 0


def test_what_was_felt_is_written_where_the_laser_sees_nothing():
    pose = Pose2(0.0, 0.0, 0.0)
    grid = grid_at(pose)
    assert cell(grid, 0.3, 0.0) < 0
    grid.add_felt(pose, 0.22, corridor_scan(pose))
    assert cell(grid, 0.3, 0.0) > 0
    assert cell(grid, 0.3, 0.3) < 0
    near_wall = Pose2(0.0, 0.6, np.pi / 2)
    grid = grid_at(near_wall)
    before = grid.cells.copy()
    grid.add_felt(near_wall, 0.22, corridor_scan(near_wall))
    np.testing.assert_array_equal(grid.cells, before)
