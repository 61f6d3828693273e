"""The scan matcher in rooms whose scans are known exactly, and in places where it has to say no."""

from dataclasses import replace
from math import cos, pi, radians, sin

import numpy as np
import pytest

from robots.estimation.scans.local_map import LocalMap
from robots.estimation.scans.matching import ScanMatch, match
from robots.estimation.scans.points import ScanPoints, scan_points
from robots.scan_config import ScanMatchConfig
from robots.se2 import GaussianPose, Pose2, wrap
from robots.types import LaserScan

CONFIG = ScanMatchConfig()
LASERS = {  # beams, field of view, range; how exact two different scans of a room can be aligned
    "360 degrees": ({"beams": 360, "field_rad": 2 * pi, "range_max_m": 30.0}, 0.002, 0.0015),
    "240 degrees, 4 m": ({"beams": 240, "field_rad": radians(240), "range_max_m": 4.0}, 0.010, 0.003),
    "180 beams": ({"beams": 180, "field_rad": pi, "range_max_m": 30.0}, 0.004, 0.003),
}


def points_of(scan: LaserScan) -> ScanPoints:
    return scan_points(scan, CONFIG.max_range_m)


def mapped(*scans: tuple[Pose2, LaserScan]) -> LocalMap:
    local_map = LocalMap(CONFIG.local_scans, 32.0)
    for pose, scan in scans:
        points = points_of(scan)
        local_map.insert(pose, points.points, points.normals)
    return local_map


def off(pose: Pose2, rng: np.random.Generator) -> Pose2:
    """A start that is wrong by 10 cm and 5 degrees."""
    angle, side = rng.uniform(0, 2 * pi), float(rng.choice([-1.0, 1.0]))
    return Pose2(pose.x + 0.1 * cos(angle), pose.y + 0.1 * sin(angle), pose.theta + side * radians(5.0))


def somewhere(rng: np.random.Generator) -> Pose2:
    return Pose2(float(rng.uniform(-1.5, 1.0)), float(rng.uniform(-1.2, 0.5)), float(rng.uniform(-pi, pi)))


def error(found: ScanMatch | None, true: Pose2) -> tuple[float, float]:
    assert found is not None
    return found.pose.mean.distance(true), abs(wrap(found.pose.mean.theta - true.theta))


@pytest.mark.parametrize("laser", LASERS)
def test_it_finds_the_pose_of_a_noiseless_scan(sweep, room, laser):
    options, exact_m, exact_rad = LASERS[laser]
    rng = np.random.default_rng(0)
    sure = 0
    for _ in range(60):
        there = somewhere(rng)
        here = there @ Pose2(*(float(v) for v in rng.uniform(-0.3, 0.3, 3)))
        local_map = mapped((there, sweep(room, there, **options)))
        found = match(local_map, points_of(sweep(room, here, **options)), off(here, rng), CONFIG)
        moved, turned = error(found, here)
        assert found is not None
        assert found.overlap > 0.7
        assert turned < exact_rad, (there, here)
        if found.pose.covariance.trace() < 0.05**2:  # else a short laser saw a single wall, and it says so
            assert moved < exact_m, (there, here)
            sure += 1
    assert sure > 50


def test_a_scan_matched_with_itself_stays_where_it_is(sweep, room):
    rng = np.random.default_rng(1)
    for _ in range(30):
        here = somewhere(rng)
        scan = sweep(room, here)
        moved, turned = error(match(mapped((here, scan)), points_of(scan), here, CONFIG), here)
        assert moved < 1e-3  # not 0: normals are blurred at the corners
        assert turned < 5e-4


def test_it_looks_around_where_the_start_is_bad(sweep, room):
    """45 cm and 20 degrees: beyond the catchment of plain ICP."""
    rng = np.random.default_rng(2)
    for _ in range(20):
        here = somewhere(rng)
        angle = rng.uniform(0, 2 * pi)
        start = Pose2(here.x + 0.45 * cos(angle), here.y + 0.45 * sin(angle), here.theta + radians(20.0))
        local_map = mapped((here, sweep(room, here)))
        moved, turned = error(match(local_map, points_of(sweep(room, here)), start, CONFIG), here)
        assert moved < 0.005
        assert turned < 0.005


def test_the_answer_moves_with_the_frame(sweep, room):
    there, here = Pose2(0.0, 0.0, 0.2), Pose2(0.2, 0.1, 0.3)
    start = Pose2(0.15, 0.12, 0.33)
    scans = sweep(room, there), sweep(room, here)
    plain = match(mapped((there, scans[0])), points_of(scans[1]), start, CONFIG)
    frame = Pose2(100.0, -40.0, 2.9)
    moved = match(mapped((frame @ there, scans[0])), points_of(scans[1]), frame @ start, CONFIG)
    assert plain is not None
    assert moved is not None
    assert moved.pose.mean.distance(frame @ plain.pose.mean) < 0.002
    carried = (GaussianPose.exact(frame) @ plain.pose).covariance
    np.testing.assert_allclose(moved.pose.covariance, carried, rtol=0.3, atol=3e-7)


@pytest.mark.parametrize("sd_m", [0.0, 0.01])
@pytest.mark.parametrize("heading", [0.0, 0.7, 2.5])
def test_along_a_bare_corridor_nothing_is_known(sweep, corridor, sd_m, heading):
    rng = np.random.default_rng(3)
    there, here = Pose2(0.0, 0.0, heading), Pose2(0.3, 0.05, heading - 0.1)
    options = {"range_max_m": 8.0, "sd_m": sd_m, "rng": rng}
    local_map = mapped((there, sweep(corridor, there, **options)))
    found = match(local_map, points_of(sweep(corridor, here, **options)), off(here, rng), CONFIG)
    assert found is not None
    sd = np.sqrt(np.diag(found.pose.covariance))
    assert sd[0] > 1.0  # along it
    assert sd[1] < 0.03  # across it
    assert sd[2] < 0.01
    assert abs(found.pose.mean.y - here.y) < 0.01
    assert abs(wrap(found.pose.mean.theta - here.theta)) < 0.01


def test_in_a_corridor_that_is_not_along_an_axis_the_covariance_lies_along_it(sweep, corridor):
    turn = Pose2(0.0, 0.0, 0.6)
    walls = np.hstack([turn.transform(corridor[:, :2]), turn.transform(corridor[:, 2:])])
    there = Pose2(0.0, 0.0, 1.0)
    scan = sweep(walls, there, range_max_m=8.0)
    found = match(mapped((there, scan)), points_of(scan), there, CONFIG)
    assert found is not None
    spread, directions = np.linalg.eigh(found.pose.covariance[:2, :2])
    assert spread[1] > 1000.0 * spread[0]
    assert abs(directions[:, 1] @ (cos(0.6), sin(0.6))) > 0.999


def test_one_end_wall_is_enough_to_know_the_place_along_a_corridor(sweep, corridor):
    walls = np.vstack([corridor, [5.0, -1.0, 5.0, 1.0]])
    there = Pose2(0.0, 0.0, 0.0)
    scan = sweep(walls, there, range_max_m=8.0)
    found = match(mapped((there, scan)), points_of(scan), there, CONFIG)
    assert found is not None
    assert np.sqrt(found.pose.covariance[0, 0]) < 0.05


def test_with_noise_it_is_not_surer_of_itself_than_it_may_be(sweep, room):
    """One noisy scan against one noisy scan.

    The covariance is meant for a map whose own errors it shares from scan to scan, so in a perfect room it is
    about five times too large in each direction (average NEES 0.13 of 3): bound above, and not absurd below.
    """
    rng = np.random.default_rng(4)
    squared = []
    for _ in range(100):
        there = somewhere(rng)
        here = there @ Pose2(0.15, 0.0, 0.1)
        local_map = mapped((there, sweep(room, there, sd_m=0.01, rng=rng)))
        found = match(local_map, points_of(sweep(room, here, sd_m=0.01, rng=rng)), off(here, rng), CONFIG)
        assert found is not None
        e = found.pose.mean.as_array() - here.as_array()
        e[2] = wrap(float(e[2]))
        squared.append(e @ np.linalg.solve(found.pose.covariance, e))
    assert 0.01 * 3 < np.mean(squared) < 1.5 * 3


def test_scans_that_say_nothing_are_refused(sweep, room):
    here = Pose2()
    local_map = mapped((here, sweep(room, here)))
    all_far = points_of(LaserScan(np.full(360, 30.0, np.float32), -pi, 2 * pi / 360, 30.0))
    assert all_far.far_fraction == 1.0
    assert match(local_map, all_far, here, CONFIG) is None
    not_finite = points_of(LaserScan(np.full(360, np.nan, np.float32), -pi, 2 * pi / 360, 30.0))
    assert not_finite.far_fraction == 1.0
    assert match(local_map, not_finite, here, CONFIG) is None
    good = points_of(sweep(room, here))
    assert match(local_map, good, here, CONFIG) is not None
    assert match(local_map, replace(good, far_fraction=CONFIG.max_far_fraction + 0.01), here, CONFIG) is None
    few = ScanPoints(good.points[: CONFIG.min_points - 1], good.normals[: CONFIG.min_points - 1], 0.5)
    assert match(local_map, few, here, CONFIG) is None
    assert match(LocalMap(25, 30.0), good, here, CONFIG) is None
    none_at_all = points_of(LaserScan(np.zeros(0, np.float32), 0.0, 0.0, 4.0))
    assert match(local_map, none_at_all, here, CONFIG) is None


def test_far_readings_are_counted_up_to_the_threshold_of_the_paper(sweep, room):
    """Most of the room is beyond the laser's reach; the threshold decides, not the matcher's luck."""
    here = Pose2(-1.0, 0.0, 0.0)
    scan = sweep(room, here, range_max_m=2.2)
    points = points_of(scan)
    assert points.far_fraction == pytest.approx(np.mean(scan.ranges_m >= 2.199), abs=1e-9)
    assert 0.4 < points.far_fraction < 0.8
    local_map = mapped((here, scan))
    assert match(local_map, points, here, replace(CONFIG, max_far_fraction=points.far_fraction)) is not None
    assert match(local_map, points, here, replace(CONFIG, max_far_fraction=0.3)) is None


ROOMS = {
    "long": ((-1.0, -1.0), (1.0, -1.0), (1.0, 6.0), (-1.0, 6.0)),
    "small": ((-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)),
    "triangle": ((-3.0, -2.0), (4.0, 0.0), (-1.0, 5.0)),
}


@pytest.mark.parametrize("other", ROOMS)
def test_a_scan_of_another_room_is_refused(sweep, outline, room, other):
    rng = np.random.default_rng(5)
    for _ in range(20):
        pose = Pose2(float(rng.uniform(-0.5, 0.5)), float(rng.uniform(-0.5, 0.5)), float(rng.uniform(-3, 3)))
        elsewhere = points_of(sweep(outline(*ROOMS[other]), pose))
        assert match(mapped((pose, sweep(room, pose))), elsewhere, pose, CONFIG) is None


def test_a_correction_larger_than_odometry_can_be_wrong_is_refused(sweep, room):
    here = Pose2(0.0, 0.0, 0.0)
    scan = points_of(sweep(room, here))
    local_map = mapped((here, sweep(room, here)))
    strict = replace(CONFIG, max_correction_m=0.05, max_correction_rad=radians(2.0))
    assert match(local_map, scan, Pose2(0.04, 0.0, 0.0), strict) is not None
    assert match(local_map, scan, Pose2(0.06, 0.0, 0.0), strict) is None
    assert match(local_map, scan, Pose2(0.0, 0.0, radians(1.5)), strict) is not None
    assert match(local_map, scan, Pose2(0.0, 0.0, radians(3.0)), strict) is None


def test_robots_that_drive_along_do_not_drag_it(sweep, room):
    """Three others keep their places relative to this one, as if nobody moved; the walls say otherwise."""
    rng = np.random.default_rng(6)
    dragged = []
    for _ in range(60):
        there = somewhere(rng)
        here = there @ Pose2(0.15, 0.0, 0.05)
        others = rng.uniform((-1.5, -1.5), (1.2, 0.8), (3, 2))
        others = others[np.hypot(*(others - (there.x, there.y)).T) > 0.7]
        along = others + np.array([here.x - there.x, here.y - there.y])
        local_map = mapped((there, sweep(room, there, others)))
        moved, turned = error(match(local_map, points_of(sweep(room, here, along)), there, CONFIG), here)
        dragged.append(moved)
        assert turned < 0.01
    assert max(dragged) < 0.05  # of the 15 cm driven, with a robot right before a wall
    assert np.median(dragged) < 0.002


def test_a_free_standing_thing_is_left_out_and_a_pillar_at_a_wall_is_not(sweep, room):
    here = Pose2()
    empty = points_of(sweep(room, here))
    beside = points_of(sweep(room, here, np.array([[1.2, -0.8]])))
    near = np.hypot(beside.points[:, 0] - 1.2, beside.points[:, 1] + 0.8) < 0.3
    assert not near.any()
    assert len(beside.points) < len(empty.points)
    at_wall = points_of(sweep(room, here, np.array([[1.2, -1.9]])))
    assert (np.hypot(at_wall.points[:, 0] - 1.2, at_wall.points[:, 1] + 1.9) < 0.3).any()


def test_normals_stand_on_the_walls_and_look_at_the_sensor(sweep, outline):
    square = outline((-2.0, -2.0), (2.0, -2.0), (2.0, 2.0), (-2.0, 2.0))
    points = points_of(sweep(square, Pose2(0.3, -0.2, 0.4)))
    in_room = Pose2(0.3, -0.2, 0.4).transform(points.points)
    known = np.hypot(*points.normals.T) > 0.0
    away_from_corners = np.abs(np.abs(in_room[:, 0]) - np.abs(in_room[:, 1])) > 0.5
    assert (known | ~away_from_corners).all()
    np.testing.assert_allclose(np.hypot(*points.normals[known].T), 1.0, atol=1e-9)
    assert (np.einsum("ni,ni->n", points.normals, points.points)[known] < 0.0).all()
    turned = Pose2(0.0, 0.0, 0.4).transform(points.normals)
    on_x_walls = away_from_corners & (np.abs(in_room[:, 0]) > 1.999)
    np.testing.assert_allclose(np.abs(turned[on_x_walls, 0]), 1.0, atol=1e-4)


def test_the_local_map_forgets_its_oldest_scan(sweep, room):
    local_map = LocalMap(2, 32.0)
    scan = points_of(sweep(room, Pose2()))
    local_map.insert(Pose2(), scan.points, scan.normals)
    local_map.insert(Pose2(), scan.points, scan.normals)
    assert len(local_map) == 2
    far_away = Pose2(15.0, 0.0, 0.0)
    for _ in range(2 + 5):  # forgotten points are removed every five insertions
        local_map.insert(far_away, scan.points, scan.normals)
    assert len(local_map) == 2
    assert local_map.points[:, 0].min() > 11.0  # nothing of the first place is left
    local_map.clear()
    assert len(local_map) == len(local_map.points) == 0
