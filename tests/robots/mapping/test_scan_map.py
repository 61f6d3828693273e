"""Scans written straight into one grid come to what a submap of them holds."""

import numpy as np
import pytest

from robots.config import MappingConfig
from robots.mapping.scan_map import ScanMap
from robots.mapping.submap import Submap
from robots.se2 import Pose2
from robots.types import LaserScan

CONFIG = MappingConfig(resolution_m=0.1)
ANGLES = np.linspace(-2.0, 2.0, 181)
SCAN = LaserScan((2.0 + np.sin(3.0 * ANGLES)).astype(np.float32), -2.0, float(ANGLES[1] - ANGLES[0]), 4.0)
POSES = [Pose2(0.03, 0.02, 0.1), Pose2(0.42, -0.31, 0.7), Pose2(1.21, 0.47, -2.0)]


def cells_by_place(cells, origin) -> dict[tuple[int, int], int]:
    row0, column0 = round(origin[1] / 0.1), round(origin[0] / 0.1)
    return {(int(r) + row0, int(c) + column0): int(cells[r, c]) for r, c in np.argwhere(cells != 0)}


def test_it_holds_what_a_submap_of_the_same_scans_holds():
    flat = ScanMap(CONFIG, (-8.04, -7.01), (8.0, 9.0))
    submap = Submap(0, Pose2(), CONFIG)
    for pose in POSES:
        flat.add_scan(pose, SCAN)
        submap.add_scan(pose, SCAN)
    expected = cells_by_place(submap.cells, (submap.origin_x, submap.origin_y))
    assert len(expected) > 500
    assert cells_by_place(flat.cells, flat.origin) == expected


def test_seen_from_elsewhere_it_is_the_same_map():
    shared = ScanMap(CONFIG, (-8.0, -8.0), (8.0, 8.0))
    other = shared.seen_from(1.0, -0.5)
    direct = ScanMap(CONFIG, (-8.0, -8.0), (8.0, 8.0))
    for pose in POSES:
        direct.add_scan(pose, SCAN)
        other.add_scan(Pose2(pose.x - 1.0, pose.y + 0.5, pose.theta), SCAN)
    assert np.array_equal(shared.cells, direct.cells)
    assert other.origin == pytest.approx((-9.0, -7.5))
    wider = other.covering(np.array([-12.0, 0.0]), np.array([0.0, 9.1]), 2)
    assert wider.origin == pytest.approx((-12.0, -7.5), abs=0.2)
    row, column = (round((a - b) / 0.1) for a, b in zip(other.origin[::-1], wider.origin[::-1], strict=True))
    rows, columns = other.cells.shape
    assert np.array_equal(wider.cells[row : row + rows, column : column + columns], other.cells)
    assert other.changes.revision == shared.changes.revision == len(POSES)


def test_all_that_changed_lies_in_the_rectangle_told():
    flat = ScanMap(CONFIG, (-3.0, -3.0), (3.0, 3.0))  # scans reach beyond its border
    for pose in POSES:
        before, revision = flat.cells.copy(), flat.changes.revision
        flat.add_scan(pose, SCAN)
        flat.add_free(pose, 0.2)
        flat.add_obstacle(pose.x + 0.5, pose.y, 0.1)
        top, left, bottom, right = flat.changes.since(revision)
        changed = np.argwhere(before != flat.cells)
        assert len(changed)
        assert (changed >= (top, left)).all()
        assert (changed < (bottom, right)).all()
    assert flat.changes.since(flat.changes.revision) == (0, 0, 0, 0)
    assert flat.changes.since(flat.changes.revision + 1) is None


def test_it_is_sure_of_what_beams_crossed_that_came_back_alone():
    wall = ScanMap(CONFIG, (-5.0, -5.0), (5.0, 5.0))
    ranges = np.where(ANGLES < 0.0, 2.0, 4.0).astype(np.float32)  # nothing comes back from the left
    for _ in range(3):
        wall.add_scan(Pose2(), LaserScan(ranges, -2.0, float(ANGLES[1] - ANGLES[0]), 4.0))
    free = wall.cells <= -CONFIG.miss_logodds
    unsure = wall.unsure(CONFIG.miss_logodds)
    y = (np.argwhere(unsure)[:, 0] + 0.5) * 0.1 + wall.origin[1]
    assert unsure.sum() > 500
    assert (free & ~unsure).sum() > 100
    assert (y > -0.1).mean() > 0.99  # beams that came back clip the corners of a few cells
    larger = wall.covering(np.array([-9.0, -9.0]), np.array([9.0, 9.0]), 2)
    assert larger.unsure(CONFIG.miss_logodds).sum() == unsure.sum()
    shared = wall.seen_from(1.0, 1.0)
    assert (shared.unsure(CONFIG.miss_logodds) == unsure).all()
