"""Which submap is written, when they are drawn anew, and what is reported when."""

import numpy as np
import pytest

from robots.config import MappingConfig
from robots.mapping.map_keeper import MapKeeper
from robots.mapping.submap import unpack
from robots.se2 import Pose2
from robots.types import LaserScan

CONFIG = MappingConfig(resolution_m=0.1)


def scan_of(distance: float) -> LaserScan:
    """A wall straight ahead, and nothing else in sight."""
    return LaserScan(np.full(1, distance, np.float32), 0.0, 0.1, 8.0)


def keeper_with_two_submaps() -> MapKeeper:
    """The first sees a wall 2.03 m ahead of (0, 0), the second one 1.03 m ahead of (0, 5), facing y."""
    keeper = MapKeeper(CONFIG)
    keeper.begin(0, Pose2(), Pose2(0.02, 0.02), 0.0)
    keeper.add_scan(Pose2(0.02, 0.02), scan_of(2.03))
    keeper.anchored(1, Pose2(0.0, 5.0, np.pi / 2), Pose2(9.0, 9.0, 0.5), 3.0)
    keeper.add_scan(Pose2(9.0, 9.0, 0.5), scan_of(1.03))
    return keeper


def occupied(keeper: MapKeeper) -> list[tuple[float, float]]:
    rows, columns = np.nonzero(keeper.fused.cells == CONFIG.hit_logodds)
    x0, y0 = keeper.fused.origin
    return sorted((x0 + (c + 0.5) * 0.1, y0 + (r + 0.5) * 0.1) for r, c in zip(rows, columns, strict=True))


def test_submaps_are_drawn_where_their_anchors_are():
    keeper = keeper_with_two_submaps()
    keeper.draw([Pose2(0.01, 0.01), Pose2(0.02, 5.0, np.pi / 2)])
    assert occupied(keeper) == [pytest.approx((0.05, 6.05), abs=0.11), pytest.approx((2.05, 0.05))]


def test_what_was_seen_since_the_last_drawing_is_drawn_when_another_submap_has_begun():
    keeper = MapKeeper(CONFIG)
    keeper.begin(0, Pose2(), Pose2(0.02, 0.02), 0.0)
    keeper.draw([Pose2(0.01, 0.01)])
    keeper.add_scan(Pose2(0.02, 0.02), scan_of(2.03))
    keeper.begin(1, Pose2(0.0, 5.0), Pose2(9.0, 9.0), 3.0)
    keeper.draw([Pose2(0.01, 0.01), Pose2(0.0, 5.0)])
    assert occupied(keeper) == [pytest.approx((2.05, 0.05))]


def test_a_submap_that_creeps_is_drawn_anew():
    keeper = keeper_with_two_submaps()
    for step in range(40):
        keeper.draw([Pose2(0.01 + 0.008 * step, 0.01), Pose2(0.02, 5.0, np.pi / 2)])
    assert occupied(keeper)[1] == pytest.approx((2.35, 0.05))


def test_behind_what_beams_came_back_from_all_is_sure():
    keeper = MapKeeper(CONFIG)
    keeper.begin(0, Pose2(), Pose2(), 0.0)
    for _ in range(3):  # far beams clear half as much
        keeper.add_scan(Pose2(0.02, 0.02), LaserScan(np.array([2.0, 8.0], np.float32), 0.0, np.pi / 2, 8.0))
    keeper.draw([Pose2(0.01, 0.01)])
    x0, y0 = keeper.fused.origin
    unsure = (np.argwhere(keeper.fused.unsure(CONFIG.miss_logodds)) + 0.5) * 0.1 + (y0, x0)
    assert len(unsure) > 60
    assert (np.abs(unsure[:, 1]) < 0.1).all()
    assert unsure[:, 0].min() > 0.0
    keeper.begin(1, Pose2(), Pose2(), 3.0)
    keeper.add_scan(Pose2(0.02, 0.02, np.pi / 2), scan_of(5.0))  # seen from a second submap
    keeper.draw([Pose2(0.01, 0.01), Pose2(0.01, 0.01)])
    left = (np.argwhere(keeper.fused.unsure(CONFIG.miss_logodds)) + 0.5) * 0.1 + (y0, x0)
    assert left[:, 0].min() > 4.9


def test_the_map_follows_the_graph():
    keeper = keeper_with_two_submaps()
    keeper.draw([Pose2(0.01, 0.01), Pose2(0.02, 5.01, np.pi / 2)])
    keeper.draw([Pose2(-3.01, 1.01), Pose2(0.01, 0.01)])
    assert occupied(keeper) == [pytest.approx((-0.95, 1.05), abs=0.11), pytest.approx((1.05, 0.05), abs=0.11)]
    fresh = keeper_with_two_submaps()
    fresh.draw([Pose2(-3.01, 1.01), Pose2(0.01, 0.01)])
    assert occupied(keeper) == occupied(fresh)


def test_anchors_close_behind_each_other_share_a_submap():
    keeper = MapKeeper(CONFIG)
    keeper.begin(0, Pose2(), Pose2(), 0.0)
    keeper.anchored(1, Pose2(), Pose2(), 2.4)
    assert [report.anchor for report in keeper.all_reports()] == [0]
    keeper.anchored(2, Pose2(), Pose2(), 2.6)
    keeper.anchored(3, Pose2(), Pose2(), 5.0)
    keeper.anchored(4, Pose2(), Pose2(), 5.2)
    assert [report.anchor for report in keeper.all_reports()] == [0, 2, 4]


def test_reports_come_when_something_is_new_and_not_too_often():
    keeper = MapKeeper(CONFIG)
    keeper.begin(0, Pose2(), Pose2(), 0.0)
    keeper.add_scan(Pose2(), scan_of(2.0))
    assert [(r.anchor, r.version) for r in keeper.take_reports(0.0)] == [(0, 1)]
    keeper.add_scan(Pose2(), scan_of(2.0))
    assert keeper.take_reports(0.5) == ()  # too soon
    assert [(r.anchor, r.version) for r in keeper.take_reports(1.0)] == [(0, 2)]
    assert keeper.take_reports(2.5) == ()  # nothing new
    keeper.add_scan(Pose2(), scan_of(2.0))
    keeper.begin(1, Pose2(), Pose2(), 4.0)
    assert [(r.anchor, r.version) for r in keeper.take_reports(2.6)] == [(0, 3)]  # finished: at once
    keeper.add_scan(Pose2(), scan_of(2.0))
    assert [(r.anchor, r.version) for r in keeper.take_reports(9.0)] == [(1, 1)]


def test_all_reports_hold_everything_reported_or_not():
    keeper = keeper_with_two_submaps()
    keeper.take_reports(0.0)
    reports = keeper.all_reports()
    assert [report.anchor for report in reports] == [0, 1]
    assert all((unpack(report) == CONFIG.hit_logodds).sum() == 1 for report in reports)


@pytest.mark.parametrize(("seen_m", "written"), [(3.0, True), (0.3, False)])
def test_a_bump_writes_an_obstacle_only_where_the_laser_sees_none(seen_m, written):
    keeper = MapKeeper(CONFIG)
    keeper.begin(0, Pose2(), Pose2(), 0.0)
    keeper.add_free(Pose2(), 0.2)
    keeper.add_obstacle(Pose2(0.02, 0.02), 0.2, scan_of(seen_m))
    keeper.draw([Pose2()])
    assert ((keeper.fused.cells == CONFIG.limit_logodds).sum() > 0) == written


def test_without_a_scan_a_bump_always_counts():
    keeper = MapKeeper(CONFIG)
    keeper.begin(0, Pose2(), Pose2(), 0.0)
    keeper.add_obstacle(Pose2(0.02, 0.02), 0.2, None)
    keeper.draw([Pose2()])
    rows, columns = np.nonzero(keeper.fused.cells == CONFIG.limit_logodds)
    x = keeper.fused.origin[0] + (columns.mean() + 0.5) * 0.1
    assert x == pytest.approx(0.02 + 0.2 + 0.08, abs=0.06)  # right ahead of the body
    assert len(rows) == 5
