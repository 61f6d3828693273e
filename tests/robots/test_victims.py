"""Heat readings become victims when they agree, stay put on their anchor, and stray ones do not."""

from itertools import pairwise
from math import atan2, hypot, pi

import numpy as np
import pytest

from robots.config import VictimConfig
from robots.se2 import Pose2, wrap
from robots.types import HeatReading
from robots.victims import VictimTracker

CONFIG = VictimConfig()
START = [Pose2(0.0, 0.0, 0.0)]


def reading(pose: Pose2, x: float, y: float, confidence: float = 0.8, noise=(0.0, 0.0)) -> HeatReading:
    bearing = wrap(atan2(y - pose.y, x - pose.x) - pose.theta)
    return HeatReading(bearing + noise[0], hypot(x - pose.x, y - pose.y) + noise[1], confidence)


def round_about(x: float, y: float, count: int, rng: np.random.Generator) -> list[Pose2]:
    """Poses round a place, looking anywhere."""
    angles, distances = rng.uniform(-pi, pi, count), rng.uniform(1.0, 3.0, count)
    return [
        Pose2(x + d * np.cos(a), y + d * np.sin(a), float(t))
        for a, d, t in zip(angles, distances, rng.uniform(-pi, pi, count), strict=True)
    ]


def test_a_lone_false_alarm_is_no_victim():
    tracker = VictimTracker("r1", CONFIG)
    here = Pose2(1.0, 0.0, 0.5)
    for stamp, (x, y) in enumerate([(3.0, 0.0), (3.0, 4.0), (-2.0, -3.0), (0.0, 8.0)]):
        for _ in range(CONFIG.min_sightings - 1):
            assert tracker.see(reading(here, x, y), float(stamp), here, 0, START) is None
    assert tracker.victims() == ()


def test_enough_readings_of_one_place_are_one_victim_and_are_told_at_once():
    tracker = VictimTracker("r1", CONFIG)
    seen = [
        tracker.see(reading(pose, 4.0, 1.0), 10.0 + k, pose, 0, START)
        for k, pose in enumerate(round_about(4.0, 1.0, 5, np.random.default_rng(0)))
    ]
    assert [estimate is not None for estimate in seen] == [False, False, True, True, True]
    (victim,) = tracker.victims()
    assert victim is seen[-1]
    assert victim.victim_id == "r1-V1"
    assert victim.sightings == 5
    assert (victim.first_seen_s, victim.last_seen_s) == (10.0, 14.0)
    np.testing.assert_allclose(victim.position_m, [4.0, 1.0], atol=1e-9)


def test_noisy_readings_converge_to_the_place_and_the_covariance_covers_the_error():
    squared = []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        tracker = VictimTracker("r1", CONFIG)
        for pose in round_about(2.0, -1.0, 25, rng):
            noise = rng.normal(0.0, [CONFIG.bearing_sd_rad, CONFIG.range_sd_m])
            estimate = tracker.see(reading(pose, 2.0, -1.0, noise=noise), 0.0, pose, 0, START)
        assert estimate is not None
        first = max(tracker.victims(), key=lambda v: v.sightings)
        error = first.position_m - (2.0, -1.0)
        assert hypot(*error) < 0.35
        squared.append(error @ np.linalg.inv(first.covariance) @ error)
    assert np.mean(squared) < 2.0  # at most what two degrees of freedom give


@pytest.mark.parametrize("heading", [0.0, 0.8, -2.5])
def test_the_estimate_is_the_information_weighted_mean(heading):
    """Readings from square directions, by hand: each is good where the other is poor, whatever the anchor."""
    tracker, anchors = VictimTracker("r1", CONFIG), [Pose2(0.4, -0.2, heading)]
    west, south = Pose2(-3.0, 0.0, 0.0), Pose2(0.0, -3.0, pi / 2.0)
    tracker.see(HeatReading(0.0, 3.3, 0.8), 0.0, west, 0, anchors)  # at (0.3, 0)
    tracker.see(HeatReading(0.0, 3.6, 0.8), 1.0, south, 0, anchors)  # at (0, 0.6)
    estimate = tracker.see(HeatReading(0.0, 3.3, 0.8), 2.0, west, 0, anchors)
    along = CONFIG.range_sd_m**2
    near, far = (CONFIG.bearing_sd_rad * 3.3) ** 2, (CONFIG.bearing_sd_rad * 3.6) ** 2
    x = (2.0 * 0.3 / along + 0.0 / far) / (2.0 / along + 1.0 / far)
    y = (2.0 * 0.0 / near + 0.6 / along) / (2.0 / near + 1.0 / along)
    np.testing.assert_allclose(anchors[0].transform(estimate.position_m[None])[0], [x, y], atol=1e-9)


def test_the_place_never_becomes_surer_than_ten_centimetres():
    tracker = VictimTracker("r1", CONFIG)
    pose = Pose2(0.0, 0.0, 0.3)
    for k in range(200):
        estimate = tracker.see(reading(pose, 2.0, 0.5), float(k), pose, 0, START)
    assert np.linalg.eigvalsh(estimate.covariance)[0] == pytest.approx(0.01)
    assert estimate.confidence == pytest.approx(1.0, abs=1e-6)


def test_confidence_grows_with_each_reading_and_stays_a_probability():
    tracker = VictimTracker("r1", VictimConfig(min_sightings=1))
    pose = Pose2()
    values = [
        tracker.see(reading(pose, 2.0, 0.0, 0.6), float(k), pose, 0, START).confidence for k in range(12)
    ]
    assert all(0.0 < a < b < 1.0 for a, b in pairwise(values))


def test_two_places_are_two_victims_and_readings_go_to_the_nearer():
    tracker = VictimTracker("r1", CONFIG)
    pose = Pose2(0.0, 0.0, 0.0)
    apart = CONFIG.same_within_m
    for k in range(4):
        for x in (3.0, 3.0 + 1.1 * apart):
            tracker.see(reading(pose, x, 0.0), float(k), pose, 0, START)
    tracker.see(reading(pose, 3.0 + 0.6 * apart, 0.0), 9.0, pose, 0, START)
    near, far = tracker.victims()
    assert (near.victim_id, far.victim_id) == ("r1-V1", "r1-V2")
    assert (near.sightings, far.sightings) == (4, 5)
    np.testing.assert_allclose(near.position_m, [3.0, 0.0], atol=1e-9)


def test_a_victim_follows_its_anchor_when_the_graph_moves():
    tracker = VictimTracker("r1", CONFIG)
    anchors = [Pose2(), Pose2(5.0, 2.0, 0.8)]
    pose = anchors[1] @ Pose2(1.0, 0.0, -0.3)
    for k in range(4):
        tracker.see(reading(pose, 7.0, 3.0), float(k), pose, 1, anchors)
    (before,) = tracker.victims()
    assert before.anchor == 1
    np.testing.assert_allclose(anchors[1].transform(before.position_m[None])[0], [7.0, 3.0], atol=1e-9)

    moved_by = Pose2(-3.0, 4.0, 1.9)  # far more than same_within_m
    moved = [anchors[0], moved_by @ anchors[1]]
    there = moved_by.transform_point(7.0, 3.0)
    later = moved_by @ pose
    seen = tracker.see(reading(later, *there), 9.0, later, 1, moved)
    (after,) = tracker.victims()
    assert seen is after
    assert after.sightings == 5
    np.testing.assert_allclose(after.position_m, before.position_m, atol=1e-9)
    np.testing.assert_allclose(moved[1].transform(after.position_m[None])[0], there, atol=1e-9)


def test_covariance_is_kept_in_the_frame_of_the_anchor():
    """Seen along the world's x axis from an anchor turned a quarter: uncertain along the anchor's y axis."""
    tracker = VictimTracker("r1", VictimConfig(min_sightings=1, range_sd_m=0.5, bearing_sd_rad=0.01))
    anchors = [Pose2(), Pose2(0.0, 0.0, pi / 2.0)]
    pose = Pose2(0.0, 0.0, 0.2)
    victim = tracker.see(reading(pose, 4.0, 0.0), 0.0, pose, 1, anchors)
    np.testing.assert_allclose(victim.covariance, np.diag([(0.01 * 4.0) ** 2, 0.25]), atol=1e-9)
    np.testing.assert_allclose(victim.position_m, [0.0, -4.0], atol=1e-9)
