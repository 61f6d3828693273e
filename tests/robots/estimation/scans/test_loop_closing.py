"""Loops at tags seen again: closed to centimetres by the laser; what is not the same place is refused."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from math import hypot, pi

import numpy as np
import pytest

from robots.config import AgentConfig
from robots.estimation.passage import Passage
from robots.estimation.scans.loop_closing import LoopCloser, Sighting
from robots.estimation.scans.points import scan_points
from robots.estimation.tag_graph.slam import TagSlam
from robots.estimation.tag_graph.smoothing import smooth
from robots.scan_config import LoopConfig
from robots.se2 import GaussianPose, Pose2
from robots.types import DistanceTurn, LaserScan, Observation, TagSighting

CONFIG = AgentConfig()
STEP_M = 0.1
CORNERS = ((6.0, 0.0), (6.0, 4.0), (0.0, 4.0), (0.0, 0.0))


@pytest.fixture
def look(sweep, outline) -> Callable[[Pose2], LaserScan]:
    """What a laser of 8 m sees in a ring of corridors with niches, the block inside (1, 1) to (5, 3)."""
    outer = outline(
        (-1, -1), (2, -1), (2, -1.6), (3, -1.6), (3, -1), (7, -1), (7, 1.2), (7.7, 1.2), (7.7, 2.4), (7, 2.4),
        (7, 5), (4.4, 5), (4.4, 5.5), (1.1, 5.5), (1.1, 5), (-1, 5), (-1, 2.5), (-1.8, 2.1), (-1, 1.2),
    )  # fmt: skip
    walls = np.vstack(
        [outer, outline((1, 1), (5, 1), (5, 3), (3.3, 3), (3.3, 2.6), (2.4, 2.6), (2.4, 3), (1, 3))]
    )
    return partial(sweep, walls, range_max_m=8.0, sd_m=0.01, rng=np.random.default_rng(3))


def rounds(count: int) -> Iterator[tuple[Pose2, float, str | None]]:
    """Poses of a drive round the block, the turn that led to each, and the tag under it, one a corner."""
    pose = Pose2()
    yield pose, 0.0, None
    for _ in range(count):
        for name, (x, y) in zip("ABCD", CORNERS, strict=True):
            for _ in range(round(hypot(x - pose.x, y - pose.y) / STEP_M)):
                pose = pose @ Pose2(STEP_M, 0.0, 0.0)
                yield pose, 0.0, None
            yield pose, 0.0, name
            for _ in range(5):
                pose = pose @ Pose2(0.0, 0.0, pi / 10)
                yield pose, pi / 10, None


def drive(slam: TagSlam, look, count: int) -> tuple[list[Pose2], list[Passage]]:
    """Drive with wheels that tell too much and turn aside; return the true poses of the anchors."""
    anchors, passages, before = [Pose2()], [], Pose2()
    for seq, (pose, turn, tag) in enumerate(rounds(count)):
        moved = before.distance(pose)
        odometry = DistanceTurn(1.06 * moved, turn + (0.004 if moved else 0.0))
        tags = (TagSighting(tag),) if tag else ()
        observation = Observation(seq, 0.2 * seq, odometry, scan=look(pose), tag_sightings=tags)
        slam.predict(observation, seq > 0, False)
        slam.match(observation.scan)
        passages.append(slam.pass_tags(observation))
        if passages[-1].anchored:
            anchors.append(pose)
        before = pose
    return anchors, passages


def errors_m(poses: np.ndarray, truths: list[Pose2]) -> np.ndarray:
    return np.array([truth.distance(Pose2.from_array(row)) for truth, row in zip(truths, poses, strict=True)])


def test_the_laser_closes_loops_to_centimetres(look):
    slam = TagSlam(CONFIG, 0.0, None)
    truths, passages = drive(slam, look, 3)
    report = slam.report()
    assert len(report.loop_pairs) >= 4
    assert sum(passage.moved for passage in passages) >= len(report.loop_pairs)
    for (i, j), measured, covariance in zip(
        report.loop_pairs, report.loop_poses, report.loop_covariances, strict=True
    ):
        true = truths[i].between(truths[j])
        assert true.distance(Pose2.from_array(measured)) < 0.04
        assert np.sqrt(covariance[0, 0]) < 0.05
    assert errors_m(report.poses, truths).max() < 0.15


def test_without_the_laser_the_antenna_alone_closes_the_loop(look):
    config = replace(CONFIG, loops=replace(CONFIG.loops, laser=False))
    slam = TagSlam(config, 0.0, None)
    truths, passages = drive(slam, look, 2)
    assert not len(slam.report().loop_pairs)
    assert any(passage.moved for passage in passages)
    assert errors_m(slam.report().poses, truths).max() < 0.3


def test_smoothing_closes_loops_everywhere_and_leaves_the_graph_as_it_is(look):
    slam = TagSlam(CONFIG, 0.0, None)
    truths, _ = drive(slam, look, 2)
    before = slam.report()
    smoothed = slam.smoothed()
    assert len(smoothed.loop_pairs) > len(before.loop_pairs)
    assert errors_m(smoothed.poses, truths).max() < errors_m(before.poses, truths).max() + 0.02
    assert errors_m(smoothed.poses, truths).max() < 0.1
    np.testing.assert_array_equal(slam.report().poses, before.poses)
    np.testing.assert_array_equal(slam.report().loop_pairs, before.loop_pairs)


def test_odometry_alone_notes_tags_and_moves_nothing(look):
    slam = TagSlam(replace(CONFIG, slam="odometry"), 0.0, None)
    _, passages = drive(slam, look, 2)
    assert not any(passage.moved for passage in passages)
    assert slam.report().tag_ids == ("A", "B", "C", "D")
    assert not len(slam.report().loop_pairs)
    np.testing.assert_array_equal(slam.smoothed().poses, slam.report().poses)


class Here:
    """A loop closer that has seen a place round each of two anchors, 20 m of way apart."""

    def __init__(self, look, first: Pose2, second: Pose2, gap_m: tuple[float, float] = (0.0, 0.0)) -> None:
        self.closer = LoopCloser(LoopConfig())
        for vertex, (driven, pose) in enumerate(((10.0, first), (30.0, second))):
            for step in range(-8, 9):
                there = pose @ Pose2(0.25 * step, 0.0, 0.0)
                self.closer.keep(there, driven + 0.25 * step, scan_points(look(there), 8.0))
            self.closer.anchored(vertex, pose, driven)
            place = gap_m if vertex else (0.0, 0.0)
            self.closer.sighted(Sighting(vertex, 0, place, np.diag([0.05**2] * 2), driven))
        self.first, self.second = first, second

    def close(self, error: Pose2, sd_m: float = 0.2, sd_rad: float = 0.1):
        belief = GaussianPose(self.first.between(self.second) @ error, np.diag([sd_m**2, sd_m**2, sd_rad**2]))
        return self.closer.close(40.0, [self.first, self.second], lambda *_: belief)


def test_a_wrong_guess_is_put_right(look):
    here = Here(look, Pose2(3.0, 0.0, 0.0), Pose2(3.05, 0.05, 0.1), gap_m=(-0.05, -0.05))
    loop = here.close(Pose2(0.3, -0.2, 0.2), sd_m=0.3, sd_rad=0.2)
    assert loop is not None
    found = loop.earlier_from_later.mean
    assert found.distance(here.first.between(here.second)) < 0.03


def test_the_other_way_round_is_the_same_place(look):
    here = Here(look, Pose2(3.0, 0.0, 0.0), Pose2(3.0, 0.0, pi))
    loop = here.close(Pose2(0.1, 0.1, -0.1))
    assert loop is not None
    assert abs(abs(loop.earlier_from_later.mean.theta) - pi) < 0.02


def test_a_heading_that_nobody_knows_is_found(look):
    here = Here(look, Pose2(3.0, 0.0, 0.0), Pose2(3.0, 0.0, 2.0))
    loop = here.close(Pose2(0.1, 0.1, -2.2), sd_m=0.3, sd_rad=1.8)
    assert loop is not None
    assert loop.earlier_from_later.mean.theta == pytest.approx(2.0, abs=0.02)


@pytest.mark.parametrize(
    ("second", "gap_m"),
    [(Pose2(3.0, 4.0, 0.0), (0.0, 0.0)), (Pose2(3.05, 0.0, 0.0), (0.6, 0.4))],
    ids=["another place with a tag of the same name", "the tag has been moved"],
)
def test_what_is_not_the_same_place_is_refused(look, second, gap_m):
    here = Here(look, Pose2(3.0, 0.0, 0.0), second, gap_m)
    belief = GaussianPose(Pose2(0.1, 0.0, 0.0), np.diag([0.3**2, 0.3**2, 0.1**2]))
    poses = [here.first, here.first @ belief.mean]
    assert here.closer.close(40.0, poses, lambda *_: belief) is None


def test_a_loop_waits_until_its_surroundings_have_been_seen(look):
    here = Here(look, Pose2(3.0, 0.0, 0.0), Pose2(3.0, 0.0, 0.0))
    belief = GaussianPose(Pose2(), np.diag([0.01, 0.01, 0.01]))
    assert here.closer.close(30.0 + 0.9 * LoopConfig().reach_m, [Pose2(), Pose2()], lambda *_: belief) is None
    assert here.closer.close(30.0 + 1.1 * LoopConfig().reach_m, [Pose2(), Pose2()], lambda *_: belief)


def test_what_is_kept_of_one_spot_is_bounded(look):
    closer = LoopCloser(LoopConfig())
    scan = scan_points(look(Pose2(3.0, 0.0, 0.0)), 8.0)
    closer.anchored(0, Pose2(), 0.0)
    for turn in range(500):
        closer.keep(Pose2(0.0, 0.0, 0.5 * turn), 0.0, scan)
    assert len(closer.surroundings(0).points) <= 41 * len(scan.points)


def test_smoothing_a_graph_without_a_laser_solves_it(graphs):
    slam = TagSlam(CONFIG, 0.0, None)
    report = slam.report()
    assert smooth(report, LoopCloser(LoopConfig()), CONFIG).poses.tolist() == report.poses.tolist()
