"""SLAM over tags: what is seen from afar, what meets, and a robot that somebody puts down elsewhere."""

from dataclasses import replace
from functools import partial
from math import atan2, cos, hypot, pi, sin

import numpy as np
import pytest

from robots.config import AgentConfig
from robots.estimation.contradiction import share_seen_through
from robots.estimation.scans.points import scan_points
from robots.estimation.tag_graph.slam import TagSlam
from robots.evaluation import consistency
from robots.se2 import Pose2, wrap
from robots.types import DistanceTurn, ImuReading, LaserScan, Observation, RobotSighting, TagSighting

CONFIG = AgentConfig()
LANDMARKS = {f"L{k}": (4.0 * cos(k), 3.0 * sin(k)) for k in range(7)}


def seen_from(pose: Pose2, place: tuple[float, float]) -> tuple[float, float]:
    x, y = pose.inverse().transform_point(*place)
    return hypot(x, y), atan2(y, x)


def there(name: str, seq: int) -> tuple[str, tuple[float, float]]:
    return name, LANDMARKS[name]


def circle(slam: TagSlam, steps: int, rng: np.random.Generator | None = None, what=there) -> list[Pose2]:
    """Drive a circle among landmarks, one of which is in sight each second step; return the true anchors.

    ``what`` says under which name, and where, a landmark is seen at a step.
    """
    pose, anchors = Pose2(), [Pose2()]
    ranging = slam._config.ranging
    for seq in range(steps):
        moved = DistanceTurn(0.08, 0.03)
        if seq:
            pose = pose @ Pose2(0.08, 0.0, 0.03)
        name, place = what(f"L{seq // 2 % 7}", seq)
        range_m, bearing = seen_from(pose, place)
        if rng is not None:
            z = rng.standard_normal(4)
            noise = CONFIG.odometry
            rolled = 0.08 + 0.03 * CONFIG.body.track_width_m / 2.0
            turn_sd = hypot(noise.turn_sd_per_sqrt_m * 0.08**0.5, noise.turn_sd_per_sqrt_rad * 0.03**0.5)
            moved = DistanceTurn(
                0.08 + noise.distance_sd_per_sqrt_m * rolled**0.5 * z[0], 0.03 + turn_sd * z[1]
            )
            range_m += (ranging.range_sd_m + ranging.range_sd_per_m * range_m) * z[2]
            bearing += ranging.bearing_sd_rad * z[3]
        sightings = (TagSighting(name, b"", range_m, wrap(bearing)),) if seq % 2 == 0 else ()
        observation = Observation(seq, 0.1 * seq, moved, tag_sightings=sightings)
        slam.predict(observation, seq > 0, False)
        if slam.pass_tags(observation).anchored:
            anchors.append(pose)
    return anchors


def test_tags_seen_from_afar_are_exact_without_noise():
    slam = TagSlam(CONFIG, 0.0, None)
    anchors = circle(slam, 300)
    report = slam.report()
    assert len(report.poses) == len(anchors) > 30
    np.testing.assert_allclose(report.poses[:, :2], [(pose.x, pose.y) for pose in anchors], atol=1e-6)
    for name, place in LANDMARKS.items():
        assert slam.tag_place(name) == pytest.approx(place, abs=1e-6)


def test_tags_seen_from_afar_hold_a_drifting_robot_and_say_how_well():
    errors, covariances = [], []
    for seed in range(12):
        slam = TagSlam(CONFIG, 0.0, None)
        truth = circle(slam, 300, np.random.default_rng(seed))[-1]
        belief = slam.report().poses[-1]
        errors.append([belief[0] - truth.x, belief[1] - truth.y, wrap(belief[2] - truth.theta)])
        covariances.append(slam._graph.last_covariance)
    assert np.sqrt(np.mean(np.square(errors), axis=0))[:2].max() < 0.35
    assert 0.3 < consistency(np.array(errors), np.array(covariances)).average < 6.0


def moved(name: str, seq: int) -> tuple[str, tuple[float, float]]:
    x, y = LANDMARKS[name]
    return name, (x - 2.0, y + 1.0) if name == "L3" and seq > 200 else (x, y)


def cloned(name: str, seq: int) -> tuple[str, tuple[float, float]]:
    return "L2" if name == "L5" else name, LANDMARKS[name]


def misread(name: str, seq: int) -> tuple[str, tuple[float, float]]:
    return "L0" if seq in (150, 222) else name, LANDMARKS[name]


@pytest.mark.parametrize("what", [moved, cloned, misread])
def test_a_tag_that_is_not_what_it_claims_does_not_bend_the_map(what):
    slam = TagSlam(CONFIG, 0.0, None)
    anchors = circle(slam, 400, np.random.default_rng(5), what)
    report = slam.report()
    errors = np.hypot(*(report.poses[:, :2] - [(pose.x, pose.y) for pose in anchors]).T)
    assert errors.max() < 0.4
    for name in {"L1", "L4", "L6"}:
        assert slam.tag_place(name) == pytest.approx(LANDMARKS[name], abs=0.4)


def test_many_sightings_from_one_pose_count_as_one():
    slam = TagSlam(CONFIG, 0.0, None)
    spreads = []
    for seq in range(50):
        observation = Observation(seq, 0.1 * seq, tag_sightings=(TagSighting("L1", b"", 3.0, 0.2),))
        slam.predict(observation, seq > 0, False)
        slam.pass_tags(observation)
        report = slam.report()
        spreads.append([*report.range_sds_m, *report.bearing_sds_rad])
    assert slam.report().range_pairs.tolist() == [[0, 0]]
    np.testing.assert_array_equal(spreads[0], spreads[-1])


def test_a_robot_that_is_met_is_noted_at_the_newest_anchor():
    slam = TagSlam(CONFIG, 0.0, None)
    for seq, met in enumerate(((), (), (RobotSighting("r2", 2.0, pi / 2),))):
        observation = Observation(seq, 0.5 * seq, DistanceTurn(1.0, 0.0), robot_sightings=met)
        slam.predict(observation, seq > 0, False)
        slam.pass_tags(observation)
    report = slam.report()
    assert report.meeting_robots == ("r2",)
    assert report.meeting_stamps_s.tolist() == [1.0]
    assert report.poses[report.meeting_poses[0]] == pytest.approx([2.0, 0.0, 0.0])
    np.testing.assert_allclose(report.meeting_offsets, [[0.0, 2.0]], atol=1e-9)
    assert np.linalg.eigvalsh(report.meeting_covariances[0])[0] > 0.0


@pytest.fixture
def rooms(sweep, outline):
    """Two rooms of one building, 20 m apart, that look nothing like each other."""
    first = outline((-3, -2), (4, -2), (4, 1), (1.5, 1), (1.5, 3.5), (-2, 3.5), (-3, 1.5))
    second = outline((17, -4), (24, -4), (24, 4), (22, 4), (22, 2.5), (20.5, 2.5), (20.5, 4), (17, 1))
    return partial(
        sweep, np.vstack([first, second]), range_max_m=12.0, sd_m=0.01, rng=np.random.default_rng(1)
    )


class Carried:
    """A robot that maps two rooms, and is then lifted from one into the other without a word."""

    def __init__(self, look, imu: bool, laser: bool = True) -> None:
        self.pose, self.seq, self._look, self._imu, self._laser = Pose2(), 0, look, imu, laser
        self.slam = TagSlam(CONFIG, 0.0, ImuReading(0.0) if imu else None)
        self.lost: list[int] = []

    def go(self, steps: int, speed_m: float = 0.1, turn_rad: float = 0.0, tag: str | None = None) -> None:
        for _ in range(steps):
            self.pose = self.pose @ Pose2(speed_m, 0.0, turn_rad)
            self._step(DistanceTurn(speed_m, turn_rad))
        if tag:
            self._step(DistanceTurn(0.0, 0.0), tag)

    def lift(self, to: Pose2) -> None:
        self.pose = to

    def _step(self, odometry: DistanceTurn, tag: str | None = None) -> None:
        scan = self._look(self.pose) if self._laser else None
        tags = (TagSighting(tag),) if tag else ()
        imu = ImuReading(self.pose.theta) if self._imu else None
        observation = Observation(self.seq, 0.2 * self.seq, odometry, imu, scan, tag_sightings=tags)
        self.slam.predict(observation, self.seq > 0, False)
        if scan is not None:
            self.slam.match(scan)
        if self.slam._tracker.lost:
            self.lost.append(self.seq)
        self.slam.pass_tags(observation)
        self.seq += 1


@pytest.mark.parametrize("imu", [True, False], ids=["imu", "wheels"])
def test_a_robot_put_down_elsewhere_notices_and_recovers_at_the_next_known_tag(rooms, imu):
    robot = Carried(rooms, imu)
    robot.go(10, tag="A")
    robot.go(10, turn_rad=0.3)
    robot.go(10, tag="B")
    robot.go(16, turn_rad=0.2)
    robot.go(10)
    assert not robot.lost
    robot.lift(Pose2(20.0, -1.0, 0.4))
    robot.go(20, turn_rad=0.12)
    assert len(robot.lost) == 1
    spread = robot.slam.belief.covariance
    assert np.sqrt(spread[0, 0]) > 5.0  # it says that it does not know
    robot.lift(Pose2(-0.5, 0.0, 0.0))
    robot.go(15, tag="A")  # at (1, 0), where it was
    assert len(robot.lost) == 2
    here = robot.slam.pose
    assert hypot(here.x - robot.pose.x, here.y - robot.pose.y) < 0.25
    robot.go(24, turn_rad=0.26)  # round and back over it: the surroundings are matched
    robot.go(24, turn_rad=0.26)
    here = robot.slam.pose
    assert hypot(here.x - robot.pose.x, here.y - robot.pose.y) < 0.25
    assert abs(wrap(here.theta - robot.pose.theta)) < 0.15


def test_a_new_room_contradicts_nothing_and_another_place_does(rooms):
    surface = np.concatenate([
        pose.transform(scan_points(rooms(pose), 12.0).points)
        for pose in (Pose2(0.0, 0.0, 0.0), Pose2(1.0, 0.0, 0.5), Pose2(0.0, 1.0, 2.0))
    ])  # fmt: skip
    assert share_seen_through(rooms(Pose2(0.5, 0.0, 1.0)), Pose2(0.5, 0.0, 1.0), surface) < 0.1
    assert share_seen_through(rooms(Pose2(20.0, -1.0, 0.4)), Pose2(0.5, 0.0, 1.0), surface) > 0.5
    assert share_seen_through(rooms(Pose2(0.5, 0.0, 1.0)), Pose2(0.5, 0.0, 1.0), surface[:10]) == 0.0


@pytest.mark.parametrize(
    "ranges", [np.full(360, np.nan), np.full(360, 12.0), np.zeros(360), np.zeros(0), np.ones(1)]
)
def test_an_odd_scan_is_no_sign_of_another_place(ranges):
    scan = LaserScan(ranges.astype(np.float32), -pi, 2 * pi / 360, 12.0)
    surface = np.random.default_rng(0).uniform(-3.0, 3.0, (100, 2))
    assert 0.0 <= share_seen_through(scan, Pose2(), surface) <= 1.0
    assert share_seen_through(replace(scan, angle_increment_rad=0.0), Pose2(), surface) == 0.0


@pytest.mark.parametrize("moved", [False, True], ids=["same place", "carried"])
def test_after_minutes_of_silence_the_first_scans_tell_whether_it_was_carried(rooms, moved):
    robot = Carried(rooms, imu=False)
    robot.go(10, tag="A")
    robot.go(20, turn_rad=0.15)
    robot.seq += 3000  # ten minutes in which nobody heard of it
    if moved:
        robot.lift(Pose2(20.0, -1.0, 0.4))
    before = robot.slam.pose
    robot.go(6)
    assert len(robot.lost) == moved
    after = robot.slam.pose
    assert hypot(after.x - before.x, after.y - before.y) == pytest.approx(0.6, abs=0.05)
