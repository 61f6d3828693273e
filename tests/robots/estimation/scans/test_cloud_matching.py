"""Clouds of simulated buildings: the same place is found, what looks alike is told apart or flagged."""

from math import pi, radians

import numpy as np
import pytest

from robots.estimation.scans.cloud_matching import Cloud, CloudMatch, Window, match_clouds
from robots.estimation.scans.points import scan_points
from robots.se2 import Pose2, wrap

HALF_TURN = Window(0.6, pi)


def cloud_of(sweep, walls, anchor: Pose2, poses: list[Pose2], rng=None, sd_m: float = 0.01) -> Cloud:
    """What scans from ``poses`` saw of the walls, in the frame of ``anchor``; half of it, at random."""
    points, normals = [], []
    for pose in poses:
        scan = scan_points(sweep(walls, pose, range_max_m=8.0, sd_m=sd_m if rng else 0.0, rng=rng), 30.0)
        anchor_from_base = anchor.between(pose)
        points.append(anchor_from_base.transform(scan.points))
        normals.append(Pose2(0.0, 0.0, anchor_from_base.theta).transform(scan.normals))
    every, facing = np.concatenate(points), np.concatenate(normals)
    keep = slice(None) if rng is None else np.sort(rng.permutation(len(every))[: len(every) // 2])
    return Cloud(every[keep], facing[keep])


def round_about(anchor: Pose2, rng: np.random.Generator, count: int = 12) -> list[Pose2]:
    return [anchor @ Pose2(*(float(v) for v in rng.uniform(-0.6, 0.6, 2)), float(rng.uniform(-pi, pi)))
            for _ in range(count)]  # fmt: skip


def error(found: CloudMatch | None, true: Pose2) -> np.ndarray:
    assert found is not None
    e = found.pose.mean.as_array() - true.as_array()
    e[2] = wrap(float(e[2]))
    return e


@pytest.mark.parametrize("window", [Window(), HALF_TURN], ids=["near", "any heading"])
def test_the_same_place_is_found_within_a_centimetre(sweep, room, window):
    rng = np.random.default_rng(0)
    squared = []
    for _ in range(15):
        here = Pose2(float(rng.uniform(-1, 0.5)), float(rng.uniform(-1, 0)), float(rng.uniform(-pi, pi)))
        there = here @ Pose2(*(float(v) for v in rng.uniform(-0.4, 0.4, 2)), float(rng.uniform(-pi, pi)))
        target = cloud_of(sweep, room, here, round_about(here, rng), rng)
        source = cloud_of(sweep, room, there, round_about(there, rng), rng)
        true = here.between(there)
        off = rng.uniform(-1, 1, 3) * (0.5, 0.5, min(window.turn_rad, pi) * 0.9)
        found = match_clouds(target, source, Pose2.from_array(true.as_array() + off), window)
        e = error(found, true)
        assert np.hypot(e[0], e[1]) < 0.01
        assert abs(e[2]) < radians(0.3)
        assert found.overlap > 0.9
        assert found.rms_m < 0.02
        assert found.margin > 0.2
        squared.append(e @ np.linalg.solve(found.pose.covariance, e))
    assert np.mean(squared) < 1.5 * 3


def test_without_noise_it_is_exact(sweep, room):
    rng = np.random.default_rng(1)
    here, there = Pose2(-0.5, 0.0, 0.3), Pose2(0.1, -0.3, 2.0)
    poses = round_about(here, rng)
    target, source = cloud_of(sweep, room, here, poses), cloud_of(sweep, room, there, poses)
    true = here.between(there)
    e = error(match_clouds(target, source, true @ Pose2(0.3, -0.3, 0.4), Window()), true)
    assert np.abs(e).max() < 2e-3


def test_another_room_does_not_overlap(sweep, room, outline):
    rng = np.random.default_rng(2)
    square = outline((-1.6, -1.6), (1.6, -1.6), (1.6, 1.6), (-1.6, 1.6))
    narrow = outline((-1.0, -2.5), (1.0, -2.5), (1.0, 2.5), (-1.0, 2.5))
    for other in (square, narrow):
        for _ in range(4):
            here = Pose2(0.0, -0.4, float(rng.uniform(-pi, pi)))
            found = match_clouds(
                cloud_of(sweep, room, here, round_about(here, rng), rng),
                cloud_of(sweep, other, Pose2(), round_about(Pose2(), rng), rng),
                Pose2(),
                HALF_TURN,
            )
            assert found is None or found.overlap < 0.7


def test_a_square_room_looks_alike_from_four_sides(sweep, outline):
    rng = np.random.default_rng(3)
    square = outline((-1.6, -1.6), (1.6, -1.6), (1.6, 1.6), (-1.6, 1.6))
    clouds = [cloud_of(sweep, square, Pose2(), round_about(Pose2(), rng), rng) for _ in range(2)]
    any_heading = match_clouds(*clouds, Pose2(0.1, 0.1, 0.2), HALF_TURN)
    assert any_heading is not None
    assert any_heading.margin < 0.05
    known_heading = match_clouds(*clouds, Pose2(0.1, 0.1, 0.2), Window())
    assert known_heading is not None
    assert known_heading.margin > 0.2
    assert np.abs(error(known_heading, Pose2())).max() < 0.01


def test_along_a_bare_corridor_it_claims_nothing(sweep, corridor):
    rng = np.random.default_rng(4)
    here = Pose2(0.0, 0.1, 0.0)
    clouds = [cloud_of(sweep, corridor, here, round_about(here, rng), rng) for _ in range(2)]
    found = match_clouds(*clouds, Pose2(0.4, 0.1, 0.05), Window())
    assert found is not None
    assert found.margin < 0.05 or found.pose.covariance[0, 0] > 0.25**2
    assert found.pose.covariance[1, 1] < 0.05**2


def test_bad_clouds_are_refused(sweep, room):
    rng = np.random.default_rng(5)
    good = cloud_of(sweep, room, Pose2(), round_about(Pose2(), rng), rng)
    nothing = Cloud(np.zeros((0, 2)), np.zeros((0, 2)))
    not_finite = Cloud(np.full((500, 2), np.nan), np.full((500, 2), np.inf))
    one_place = Cloud(np.ones((500, 2)), np.tile([0.0, 1.0], (500, 1)))
    far = Cloud(good.points + 1e9, good.normals)
    flat = Cloud(good.points, np.zeros_like(good.normals))
    for bad in (nothing, not_finite, one_place, far, flat):
        assert match_clouds(good, bad, Pose2(), Window()) is None
        assert match_clouds(bad, good, Pose2(), Window()) is None
    with pytest.raises(ValueError, match="one normal for each point"):
        match_clouds(good, Cloud(good.points, good.normals[:5]), Pose2(), Window())
    spoilt = Cloud(
        np.vstack([good.points, [[np.nan, 0.0], [1e300, 0.0]]]), np.vstack([good.normals, np.eye(2)])
    )
    assert np.abs(error(match_clouds(good, spoilt, Pose2(0.2, 0.0, 0.1), Window()), Pose2())).max() < 1e-2


def test_the_same_clouds_give_the_same_bits(sweep, room):
    rng = np.random.default_rng(6)
    clouds = [cloud_of(sweep, room, Pose2(), round_about(Pose2(), rng), rng) for _ in range(2)]
    first, second = (match_clouds(*clouds, Pose2(0.2, 0.1, 0.3), Window()) for _ in range(2))
    assert first is not None
    assert second is not None
    assert first.pose.mean == second.pose.mean
    assert (first.pose.covariance == second.pose.covariance).all()
    assert (first.overlap, first.rms_m, first.margin) == (second.overlap, second.rms_m, second.margin)
