"""A submap holds what was seen from its anchor, grows as needed and leaves the process whole."""

import zlib
from dataclasses import replace
from math import inf, pi

import numpy as np
import pytest

from robots.config import MappingConfig
from robots.mapping.submap import Submap, unpack
from robots.se2 import Pose2
from robots.types import LaserScan, SubmapReport

CONFIG = MappingConfig(resolution_m=0.1)
CENTRE = Pose2(0.05, 0.05)  # in the middle of a cell


def scan(ranges, angle_min=-2.0, increment=0.1, range_max=8.0) -> LaserScan:
    return LaserScan(np.asarray(ranges, np.float32), angle_min, increment, range_max)


def value_at(report: SubmapReport, anchor: Pose2, x: float, y: float) -> int:
    """Log-odds of a report at a point of the frame that the anchor pose is in."""
    frame = anchor @ report.anchor_from_grid
    u, v = frame.inverse().transform_point(x, y)
    row, column = int(np.floor(v / report.resolution_m)), int(np.floor(u / report.resolution_m))
    inside = 0 <= row < report.height and 0 <= column < report.width
    return int(unpack(report)[row, column]) if inside else 0


@pytest.mark.parametrize("heading", [0.0, 0.7, -2.3, pi])
def test_what_was_hit_stands_where_it_was_hit(heading):
    anchor = Pose2(3.0, -2.0, heading)
    submap = Submap(4, anchor, CONFIG)
    base = Pose2(0.83, 0.44, -0.5)  # in the anchor's frame
    ranges = np.linspace(1.0, 5.0, 41)
    submap.add_scan(base, scan(ranges))
    report = submap.report()
    assert (report.anchor, report.version) == (4, 1)
    world = anchor @ base
    for k, r in enumerate(ranges.astype(np.float32)):
        angle = world.theta - 2.0 + 0.1 * k
        end = world.x + float(r) * np.cos(angle), world.y + float(r) * np.sin(angle)
        middle = world.x + 0.5 * float(r) * np.cos(angle), world.y + 0.5 * float(r) * np.sin(angle)
        assert value_at(report, anchor, *end) == CONFIG.hit_logodds
        assert value_at(report, anchor, *middle) == -CONFIG.miss_logodds


def test_the_grid_is_parallel_to_the_map_it_was_begun_in():
    anchor = Pose2(1.0, 2.0, 0.9)
    submap = Submap(0, anchor, CONFIG)
    assert (anchor @ submap.anchor_from_grid).theta == pytest.approx(0.0, abs=1e-12)


def test_the_report_is_the_grid_cut_to_what_is_known():
    submap = Submap(0, Pose2(), CONFIG)
    submap.add_scan(CENTRE, scan([1.0, 2.0, 3.0], -0.3, 0.3))
    report = submap.report()
    cells = unpack(report)
    assert cells.dtype == np.int8
    assert cells.shape == (report.height, report.width)
    for edge in (cells[0], cells[-1], cells[:, 0], cells[:, -1]):
        assert edge.any()
    row = round((report.anchor_from_grid.y - submap.origin_y) / 0.1)
    column = round((report.anchor_from_grid.x - submap.origin_x) / 0.1)
    whole = np.zeros_like(submap.cells)
    whole[row : row + report.height, column : column + report.width] = cells
    np.testing.assert_array_equal(whole, submap.cells)


def test_an_empty_submap_is_an_empty_report():
    report = Submap(2, Pose2(), CONFIG).report()
    assert (report.width, report.height, report.version) == (0, 0, 0)
    assert unpack(report).shape == (0, 0)


def test_growing_keeps_what_was_written():
    at = [(0.03, 0.04, 0.31), (30.07, 2.01, 1.02), (-25.02, -40.06, 2.03), (1.04, 0.53, -1.01)]
    places = [Pose2(*pose) for pose in at]
    grown, roomy = Submap(0, Pose2(), CONFIG), Submap(0, Pose2(), CONFIG)
    roomy._cover(0.0, 0.0, 80.0)
    for place in places:
        for submap in (grown, roomy):
            submap.add_scan(place, scan(np.linspace(1.0, 6.0, 30)))
    first, second = grown.report(), roomy.report()
    np.testing.assert_array_equal(unpack(first), unpack(second))
    assert first.anchor_from_grid.x == pytest.approx(second.anchor_from_grid.x)
    assert first.anchor_from_grid.y == pytest.approx(second.anchor_from_grid.y)
    assert grown.cells.shape != roomy.cells.shape


def test_every_beam_finds_room():
    submap = Submap(0, Pose2(), CONFIG)
    submap.add_scan(Pose2(6.3, -6.3, 0.0), scan([inf] * 63, -pi, 0.1))
    cells, low, left = submap.cells, submap.origin_y, submap.origin_x
    known = np.argwhere(cells != 0) * 0.1 + (low, left)
    assert known.min(axis=0) == pytest.approx([-6.3 - 8.0, 6.3 - 8.0], abs=0.15)
    assert known.max(axis=0) == pytest.approx([-6.3 + 7.9, 6.3 + 7.9], abs=0.15)


def test_every_change_is_a_new_version():
    submap = Submap(0, Pose2(), CONFIG)
    versions = [submap.version]
    for change in (
        lambda: submap.add_free(CENTRE, 0.25),
        lambda: submap.add_scan(CENTRE, scan([1.0])),
        lambda: submap.add_obstacle(Pose2(0.5, 0.0), 0.1),
    ):
        change()
        versions.append(submap.version)
    assert versions == [0, 1, 2, 3]


def test_the_ground_under_the_robot_is_free_and_nothing_beyond():
    submap = Submap(0, Pose2(), CONFIG)
    submap.add_free(CENTRE, 0.25)
    report = submap.report()
    assert value_at(report, Pose2(), 0.05, 0.05) <= -CONFIG.miss_logodds
    rows, columns = np.indices((report.height, report.width))
    origin = report.anchor_from_grid
    x, y = origin.x + (columns + 0.5) * 0.1, origin.y + (rows + 0.5) * 0.1
    assert np.hypot(x - 0.05, y - 0.05)[unpack(report) < 0].max() < 0.25 * 2**0.5


def test_a_felt_obstacle_is_occupied():
    submap = Submap(0, Pose2(0.0, 0.0, 1.0), CONFIG)
    submap.add_free(CENTRE, 0.5)
    submap.add_obstacle(Pose2(0.4, 0.0), 0.1)
    report = submap.report()
    assert value_at(report, Pose2(), 0.4, 0.0) == CONFIG.limit_logodds
    assert value_at(report, Pose2(), -0.1, 0.0) < 0
    assert (unpack(report) == CONFIG.limit_logodds).sum() == 5  # a disc of radius one cell


def test_damaged_reports_are_refused():
    submap = Submap(7, Pose2(), CONFIG)
    submap.add_scan(CENTRE, scan([1.0, 2.0]))
    report = submap.report()
    with pytest.raises(ValueError, match=r"submap 7: damaged cells"):
        unpack(replace(report, cells=report.cells[:-5]))
    with pytest.raises(ValueError, match=r"submap 7: damaged cells"):
        unpack(replace(report, cells=b"rubbish"))
    with pytest.raises(ValueError, match=rf"submap 7: \d+ cells, expected {report.width + 1} x"):
        unpack(replace(report, width=report.width + 1))
    with pytest.raises(ValueError, match=r"submap 7: 3 cells, expected"):
        unpack(replace(report, cells=zlib.compress(b"abc")))
