"""Following a path: the command for one moment, and whole drives that arrive and touch nothing."""

from dataclasses import replace
from math import atan2, hypot, inf, nan, pi

import numpy as np
import pytest

from robots.config import BodyConfig, MappingConfig, PlanningConfig
from robots.mapping.fused import FusedGrid
from robots.planning.following import follow, free_ahead
from robots.planning.plan_grid import OCCUPIED, PlanGrid, plan_grid
from robots.planning.travel import find_path
from robots.se2 import Pose2
from robots.types import LaserScan

BODY = BodyConfig()


def ground(*walls: tuple[float, float, float, float]) -> PlanGrid:
    """Free ground of 10 m by 8 m with walls, given as x0, y0, x1, y1."""
    cells = np.full((160, 200), -20, np.int16)
    for x0, y0, x1, y1 in walls:
        cells[round(y0 / 0.05) : round(y1 / 0.05), round(x0 / 0.05) : round(x1 / 0.05)] = 40
    fused = FusedGrid(0.05)
    fused.put("map", 0, Pose2(), cells)
    return plan_grid(fused, BODY, PlanningConfig(), MappingConfig(), np.zeros((0, 3)))


OPEN = ground()
AHEAD = np.column_stack([np.linspace(2.0, 6.0, 41), np.full(41, 4.0)])


def scan_of(points: list[tuple[float, float]]) -> LaserScan:
    """A scan whose beams end at points in the base frame, or are far."""
    ranges = np.full(721, inf, np.float32)
    for x, y in points:
        ranges[round((atan2(y, x) + pi) / (2.0 * pi / 720))] = hypot(x, y)
    return LaserScan(ranges, -pi, 2.0 * pi / 720, 8.0)


def test_no_path_no_motion():
    assert follow(np.zeros((0, 2)), Pose2(), OPEN, None, BODY) == (0.0, 0.0)


def test_straight_ahead_at_full_speed():
    speed, turn = follow(AHEAD, Pose2(2.0, 4.0, 0.0), OPEN, None, BODY)
    assert speed == pytest.approx(BODY.max_speed_mps)
    assert turn == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(("heading", "sign"), [(-0.3, 1.0), (0.3, -1.0), (-2.0, 1.0), (2.0, -1.0)])
def test_it_turns_towards_the_path_and_on_the_spot_when_far_off(heading, sign):
    speed, turn = follow(AHEAD, Pose2(2.0, 4.0, heading), OPEN, None, BODY)
    assert turn * sign > 0.0
    assert abs(turn) <= BODY.max_turn_radps
    assert (speed == 0.0) == (abs(heading) > 1.0)
    assert speed < BODY.max_speed_mps


def test_it_slows_down_towards_the_end_and_in_front_of_things():
    assert follow(AHEAD, Pose2(5.9, 4.0, 0.0), OPEN, None, BODY)[0] == pytest.approx(0.15)
    pose = Pose2(2.0, 4.0, 0.0)
    speeds = [follow(AHEAD, pose, OPEN, scan_of([(x, 0.0)]), BODY)[0] for x in (3.0, 0.42, 0.35, 0.26)]
    assert speeds[0] == BODY.max_speed_mps
    assert speeds[0] > speeds[1] > speeds[2] > speeds[3] == 0.0


@pytest.mark.parametrize("seed", range(5))
def test_free_ahead_is_how_far_a_disc_can_be_pushed(seed):
    rng = np.random.default_rng(seed)
    ranges = rng.uniform(0.3, 6.0, 30).astype(np.float32)
    ranges[rng.integers(0, 30, 4)] = [nan, inf, 8.0, 0.01]
    ranges[15] = 4.5  # nearly straight ahead
    scan, half_width = LaserScan(ranges, -2.0, 0.13, 8.0), 0.26
    angles = -2.0 + 0.13 * np.arange(30)
    real = np.isfinite(ranges) & (ranges > 0.02) & (ranges < 7.9)
    x, y = ranges[real] * np.cos(angles[real]), ranges[real] * np.sin(angles[real])
    ahead = x > 0.0
    pushed = np.arange(0.0, 8.0, 0.001)
    touched = (np.hypot(x[ahead, None] - pushed, y[ahead, None]) < half_width).any(axis=0)
    expected = pushed[touched.argmax()] if touched.any() else 8.0
    assert expected < 8.0
    assert free_ahead(scan, half_width) == pytest.approx(expected, abs=0.002)


def test_free_ahead_sees_nothing_behind_beside_or_far():
    assert free_ahead(scan_of([(-0.5, 0.0), (1.0, 0.3), (0.0, 0.27)]), 0.26) == 8.0
    assert free_ahead(scan_of([(0.1, 0.0)]), 0.26) == 0.0


def test_it_cuts_a_corner_only_where_the_straight_way_is_clear():
    """Up and then right: the next points may be aimed at, unless something stands inside the bend."""
    up = [(2.05, 4.05 + 0.1 * k) for k in range(4)]
    path = np.array([*up, *((2.15 + 0.1 * k, 4.35) for k in range(8))])
    pose = Pose2(2.05, 4.05, pi / 2.0)
    _, cutting = follow(path, pose, OPEN, None, BODY)
    steps = OPEN.steps.copy()
    steps[OPEN.cell_of(2.25, 4.25)] = 0
    _, careful = follow(path, pose, replace(OPEN, steps=steps), None, BODY)
    assert cutting == -BODY.max_turn_radps
    assert careful == pytest.approx(-2.5 * atan2(0.2, 0.3))  # the last point before the way is not clear


WALLS = [
    [],
    [(4.0, 0.0, 4.2, 5.0)],
    [(3.0, 0.0, 3.1, 5.5), (6.0, 2.5, 6.1, 8.0)],
    [(4.0, 0.0, 4.2, 3.4), (4.0, 4.4, 4.2, 8.0)],  # a door of one metre
]


@pytest.mark.parametrize("walls", WALLS)
@pytest.mark.parametrize("heading", [0.0, 2.5, -1.8])
def test_a_whole_drive_arrives_and_touches_nothing(walls, heading):
    grid = ground(*walls)
    pose, goal = Pose2(1.0, 2.0, heading), (8.5, 6.0)
    start = grid.cell_of(pose.x, pose.y)
    cells = find_path(grid, start, grid.cell_of(*goal))
    path = np.array([grid.centre_of(int(row), int(column)) for row, column in cells])
    length = np.hypot(*np.diff(path, axis=0).T).sum()
    rows, columns = np.nonzero(grid.cells == OCCUPIED)
    obstacles = np.array([grid.centre_of(r, c) for r, c in zip(rows, columns, strict=True)]).reshape(-1, 2)
    driven, clearance = 0.0, inf
    for _ in range(600):  # two minutes
        if hypot(goal[0] - pose.x, goal[1] - pose.y) < 0.15:
            break
        speed, turn = follow(path, pose, grid, None, BODY)
        for _ in range(4):  # held for a control period
            pose = pose @ Pose2.exp(np.array([speed, 0.0, turn]) * 0.05)
            driven += speed * 0.05
            if len(obstacles):
                distances = np.hypot(obstacles[:, 0] - pose.x, obstacles[:, 1] - pose.y)
                clearance = min(clearance, float(distances.min()))
    else:
        raise AssertionError("did not arrive")
    assert driven < 1.1 * length + 0.3
    assert clearance > BODY.radius_m
