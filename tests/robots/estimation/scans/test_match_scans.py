"""One scan against another: exactness, consistency, and scans no robot should send."""

from dataclasses import replace
from math import cos, inf, nan, pi, radians, sin

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robots.estimation.scans.matching import ScanMatch, match_scans, reference_of
from robots.scan_config import ScanMatchConfig
from robots.se2 import Pose2, wrap
from robots.types import LaserScan

CONFIG = ScanMatchConfig()


def scan_of(ranges, start: float = -pi, increment: float | None = None, far_m: float = 30.0) -> LaserScan:
    values = np.asarray(ranges, np.float32)
    step = 2 * pi / max(len(values), 1) if increment is None else increment
    return LaserScan(values, start, step, far_m)


def error(found: ScanMatch | None, true: Pose2) -> np.ndarray:
    assert found is not None
    e = found.pose.mean.as_array() - true.as_array()
    e[2] = wrap(float(e[2]))
    return e


def trials(sweep, room, count: int, seed: int, **options):
    """Pairs 8 cm and 8 degrees apart with a start off by up to 10 cm and 5 degrees: scans, truth, guess."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        there = Pose2(*(float(v) for v in rng.uniform((-1.5, -1.2, -pi), (1.0, 0.5, pi))))
        angle, off = rng.uniform(-pi, pi, 2)
        true = Pose2(0.08 * cos(angle), 0.08 * sin(angle), radians(8.0) * float(rng.choice([-1, 1])))
        distance, turn = float(rng.uniform(0, 0.1)), float(rng.uniform(-1, 1)) * radians(5.0)
        guess = Pose2(true.x + distance * cos(off), true.y + distance * sin(off), true.theta + turn)
        poses = there, there @ true
        yield *(sweep(room, pose, rng=rng, **options) for pose in poses), true, guess


def test_without_noise_it_is_exact_within_millimetres(sweep, room):
    for reference, scan, true, guess in trials(sweep, room, 40, 0):
        e = error(match_scans(reference, scan, guess, CONFIG), true)
        assert np.hypot(e[0], e[1]) < 0.004
        assert abs(e[2]) < 0.002


@pytest.mark.parametrize("sd_m", [0.01, 0.03])
def test_its_covariance_is_honest(sweep, room, sd_m):
    squared = []
    for reference, scan, true, guess in trials(sweep, room, 120, 1, sd_m=sd_m):
        found = match_scans(reference, scan, guess, CONFIG)
        e = error(found, true)
        squared.append(e @ np.linalg.solve(found.pose.covariance, e))
    assert 0.35 * 3 < np.mean(squared) < 1.6 * 3


def test_a_prepared_reference_gives_the_same_bits(sweep, room):
    for reference, scan, _, guess in trials(sweep, room, 5, 2, sd_m=0.02):
        prepared = reference_of(reference, CONFIG)
        found = [match_scans(r, scan, guess, CONFIG) for r in (reference, prepared, prepared)]
        assert len({match.pose.mean for match in found}) == 1
        assert len({match.pose.covariance.tobytes() for match in found}) == 1


def test_along_a_bare_corridor_it_stays_at_the_guess_and_says_so(sweep, corridor):
    rng = np.random.default_rng(3)
    for _ in range(20):
        scans = [
            sweep(corridor, Pose2(x, 0.1, 0.0), range_max_m=8.0, sd_m=0.02, rng=rng) for x in (0.0, 0.08)
        ]
        found = match_scans(*scans, Pose2(0.15, 0.03, 0.02), CONFIG)
        assert found is not None
        assert abs(found.pose.mean.x - 0.15) < 0.03  # nothing is known about it: the guess is as good as any
        assert abs(found.pose.mean.y) < 0.02
        assert found.pose.covariance[0, 0] > 0.3**2
        assert found.pose.covariance[1, 1] < 0.1**2


def test_a_crowd_that_moves_does_not_drag_it(sweep, room):
    """Five people round the robot have walked on by 20 cm between the scans."""
    rng = np.random.default_rng(4)
    moved = []
    for _ in range(40):
        there, true = (
            Pose2(float(rng.uniform(-1, 0.5)), float(rng.uniform(-1, 0.3)), 0.0),
            Pose2(0.08, 0.0, 0.1),
        )
        people = rng.uniform((-2.5, -1.7), (3.0, 0.7), (5, 2))
        people = people[np.hypot(*(people - (there.x, there.y)).T) > 0.6]
        walked = people + 0.2 * np.array([cos(1.0), sin(1.0)])
        scans = (
            sweep(room, there, people, sd_m=0.01, rng=rng),
            sweep(room, there @ true, walked, sd_m=0.01, rng=rng),
        )
        found = match_scans(*scans, Pose2(), CONFIG)
        e = error(found, true)
        moved.append(np.hypot(e[0], e[1]))
    assert np.median(moved) < 0.01
    assert max(moved) < 0.08


def test_glass_that_comes_back_far_is_no_wall(sweep, room):
    for reference, scan, true, guess in trials(sweep, room, 10, 5, sd_m=0.01):
        ranges = scan.ranges_m.copy()
        ranges[40:110] = inf
        ranges[200:230] = scan.range_max_m
        e = error(match_scans(reference, replace(scan, ranges_m=ranges), guess, CONFIG), true)
        assert np.hypot(e[0], e[1]) < 0.03


BAD = {
    "empty": scan_of([]),
    "one beam": scan_of([2.0]),
    "all far": scan_of(np.full(360, 30.0)),
    "not finite": scan_of(np.tile([nan, inf, -inf], 120)),
    "negative": scan_of(np.full(360, -2.0)),
    "zero": scan_of(np.zeros(360)),
    "no increment": scan_of(np.full(360, 2.0), increment=0.0),
    "angle not a number": scan_of(np.full(360, 2.0), start=nan),
    "increment not finite": scan_of(np.full(360, 2.0), increment=inf),
    "reach not a number": scan_of(np.full(360, 2.0), far_m=nan),
    "huge": scan_of(np.full(360, 3e38), far_m=inf),
    "noise": scan_of(np.random.default_rng(6).uniform(0.1, 29.0, 360)),
}


@pytest.mark.parametrize("name", BAD)
def test_scans_that_say_nothing_are_refused_or_sanely_unsure(sweep, room, name):
    good = sweep(room, Pose2())
    for pair in ((good, BAD[name]), (BAD[name], good), (BAD[name], BAD[name])):
        found = match_scans(*pair, Pose2(), CONFIG)
        if found is not None:
            assert np.isfinite(found.pose.covariance).all()
            assert np.linalg.eigvalsh(found.pose.covariance).min() > 0.0
    assert match_scans(good, BAD[name], Pose2(), CONFIG) is None


def test_all_ranges_equal_say_little_about_the_heading():
    ring = scan_of(np.full(360, 2.0))
    found = match_scans(ring, ring, Pose2(0.05, 0.0, 0.05), CONFIG)
    assert found is not None
    assert abs(found.pose.mean.x) < 0.01
    assert found.pose.covariance[2, 2] > radians(2.0) ** 2
    assert abs(found.pose.mean.theta) < 3.0 * found.pose.covariance[2, 2] ** 0.5


@pytest.mark.parametrize("beams", [4096, 30000])
def test_many_beams_are_matched_as_well(sweep, room, beams):
    scans = [sweep(room, pose, beams=beams) for pose in (Pose2(), Pose2(0.08, 0.0, 0.1))]
    e = error(match_scans(*scans, Pose2(), CONFIG), Pose2(0.08, 0.0, 0.1))
    assert np.abs(e).max() < 0.005


def test_a_guess_that_is_no_pose_is_refused(sweep, room):
    scan = sweep(room, Pose2())
    for guess in (Pose2(nan, 0.0, 0.0), Pose2(0.0, inf, 0.0), Pose2(0.0, 0.0, nan), Pose2(1e12, 0.0, 0.0)):
        assert match_scans(scan, scan, guess, CONFIG) is None


@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.floats(width=32), min_size=0, max_size=80),
    st.floats(-10, 10),
    st.floats(-0.5, 0.5),
    st.floats(0.0, 100.0),
)
def test_whatever_a_scanner_sends_it_survives(ranges, start, increment, far_m):
    scan = LaserScan(np.array(ranges, np.float32), start, increment, far_m)
    found = match_scans(scan, scan, Pose2(0.01, 0.0, 0.01), CONFIG)
    if found is not None:
        assert np.isfinite(found.pose.mean.as_array()).all()
        assert np.linalg.eigvalsh(found.pose.covariance).min() > 0.0
