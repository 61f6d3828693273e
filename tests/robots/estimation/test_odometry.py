"""Dead reckoning: eq. (1) and (2) of Kleiner 2006, exact arcs, and whether its covariance tells the truth."""

from collections.abc import Callable
from dataclasses import replace
from math import cos, pi, sin

import numpy as np
import pytest

from robots.config import AgentConfig, BodyConfig, OdometryConfig
from robots.estimation.odometry import motion_covariance, motion_mean, predict, wheel_motion
from robots.estimation.tracking import PoseTracker
from robots.evaluation import consistency
from robots.se2 import GaussianPose, Pose2, wrap, wrap_array
from robots.sim.wheels import Imu, Wheels, data_sheet
from robots.sim.world import World
from robots.types import Displacement, DistanceTurn, ImuReading, Odometry, WheelEncoders

BODY = BodyConfig()
NOISE = OdometryConfig()
TICK_S = 0.05
Pattern = list[tuple[float, float]]


def random_belief(rng: np.random.Generator) -> GaussianPose:
    root = 0.2 * rng.standard_normal((3, 3))
    x, y, theta = (float(v) for v in rng.uniform(-3, 3, 3))
    return GaussianPose(Pose2(x, y, theta), root @ root.T)


def differences(function: Callable[[np.ndarray], np.ndarray], at: np.ndarray) -> np.ndarray:
    h, columns = 1e-6, []
    for unit in np.eye(len(at)):
        step = function(at + h * unit) - function(at - h * unit)
        step[2] = wrap(float(step[2]))
        columns.append(step / (2 * h))
    return np.column_stack(columns)


@pytest.mark.parametrize("seed", range(5))
def test_the_covariance_goes_through_the_jacobians_of_eq_2(seed):
    rng = np.random.default_rng(seed)
    before = random_belief(rng)
    mean = Pose2(float(rng.uniform(-1, 1)), float(rng.uniform(-0.2, 0.2)), float(rng.uniform(-1, 1)))
    motion = GaussianPose(mean, motion_covariance(mean, NOISE, 0.2, None))
    after = predict(before, motion)
    by_pose = differences(
        lambda x: (Pose2.from_array(x) @ mean).as_array(), before.mean.as_array()
    )  # nabla F_l
    by_motion = differences(
        lambda u: (before.mean @ Pose2.from_array(u)).as_array(), mean.as_array()
    )  # nabla F_u
    expected = by_pose @ before.covariance @ by_pose.T + by_motion @ motion.covariance @ by_motion.T
    np.testing.assert_allclose(after.covariance, expected, atol=1e-8)
    assert np.array_equal(after.covariance, after.covariance.T)


@pytest.mark.parametrize("seed", range(3))
def test_distance_and_turn_are_the_printed_eq_1(seed):
    rng = np.random.default_rng(seed)
    before = random_belief(rng)
    d, alpha = (float(v) for v in rng.uniform(-2, 2, 2))
    mean = motion_mean(DistanceTurn(d, alpha), None, BODY)
    after = predict(before, GaussianPose(mean, np.zeros((3, 3)))).mean
    x, y, theta = before.mean.as_array()
    assert after.x == pytest.approx(x + cos(theta) * d, abs=1e-12)
    assert after.y == pytest.approx(y + sin(theta) * d, abs=1e-12)
    assert after.theta == pytest.approx(wrap(theta + alpha), abs=1e-12)


def on_the_circle(pose: Pose2, speed: float, turn: float, seconds: float) -> Pose2:
    """The true pose after driving a circle: its centre lies left of the robot by the radius."""
    if turn == 0.0:
        return Pose2(
            pose.x + speed * seconds * cos(pose.theta), pose.y + speed * seconds * sin(pose.theta), pose.theta
        )
    radius = speed / turn
    centre = pose.x - radius * sin(pose.theta), pose.y + radius * cos(pose.theta)
    theta = pose.theta + turn * seconds
    return Pose2(centre[0] + radius * sin(theta), centre[1] - radius * cos(theta), wrap(theta))


def test_encoders_without_noise_integrate_to_the_true_path():
    rng = np.random.default_rng(1)
    wheels = Wheels(0, BODY.track_width_m, rng)
    true = believed = Pose2(1.0, -2.0, 3.0)
    for _ in range(400):
        speed, turn = float(rng.uniform(-0.5, 0.5)), float(rng.choice([0.0, 1e-7, rng.uniform(-1.5, 1.5)]))
        for _ in range(5):
            true = on_the_circle(true, speed, turn, TICK_S) if abs(turn) > 1e-6 else true @ Pose2.exp(
                np.array([speed * TICK_S, 0.0, turn * TICK_S])
            )  # fmt: skip
            reading = wheels.read(speed, turn, TICK_S, 1.0)
            believed = believed @ motion_mean(reading, None, BODY)
    assert believed.distance(true) < 1e-9
    assert wrap(believed.theta - true.theta) == pytest.approx(0.0, abs=1e-9)


def test_four_wheels_are_two_sides():
    distance, turn = wheel_motion(WheelEncoders(0.09, 0.21, 0.11, 0.19), 0.4)
    assert distance == pytest.approx(0.15)
    assert turn == pytest.approx(0.25)


FORMS: dict[str, Odometry] = {
    "wheels": WheelEncoders(0.1, 0.2, 0.1, 0.2),
    "distance_turn": DistanceTurn(0.15, 0.25),
    "displacement": Displacement(0.15, 0.02, 0.25),
}


@pytest.mark.parametrize("form", FORMS)
def test_the_inertial_unit_replaces_the_turn_of_every_form(form):
    assert motion_mean(FORMS[form], None, BODY).theta == pytest.approx(0.25)
    for turn in (0.0, -0.4):
        assert motion_mean(FORMS[form], turn, BODY).theta == pytest.approx(turn, abs=1e-12)
    by_wheels = motion_covariance(Pose2(0.15, 0.0, 0.25), NOISE, 0.2, None)
    by_imu = motion_covariance(Pose2(0.15, 0.0, 0.25), NOISE, 0.2, 0.001)
    assert by_imu[2, 2] == pytest.approx(1e-6)
    assert by_wheels[2, 2] > 100 * by_imu[2, 2]
    assert np.array_equal(by_wheels[:2, :2], by_imu[:2, :2])


def test_wheels_follow_the_inertial_units_arc():
    """Half a turn over half a metre: the arc's chord, not the way rolled."""
    moved = motion_mean(WheelEncoders(0.5, 0.5, 0.5, 0.5), pi / 2, BODY)
    radius = 0.5 / (pi / 2)
    assert (moved.x, moved.y) == pytest.approx((radius, radius))


def test_without_odometry_only_the_inertial_unit_turns():
    assert motion_mean(None, None, BODY) == Pose2()
    assert motion_mean(None, 0.3, BODY) == Pose2(0.0, 0.0, 0.3)


def test_variances_grow_linearly_so_the_rate_of_odometry_does_not_matter():
    whole = motion_covariance(Pose2(1.0, 0.0, 0.0), NOISE, 0.2, None)
    tenth = motion_covariance(Pose2(0.1, 0.0, 0.0), NOISE, 0.2, None)
    np.testing.assert_allclose(10.0 * tenth, whole)
    on_the_spot = motion_covariance(Pose2(0.0, 0.0, 1.0), NOISE, 0.2, None)
    np.testing.assert_allclose(10.0 * motion_covariance(Pose2(0.0, 0.0, 0.1), NOISE, 0.2, None), on_the_spot)
    assert on_the_spot[2, 2] == pytest.approx(NOISE.turn_sd_per_sqrt_rad**2)
    assert not motion_covariance(Pose2(), NOISE, 0.2, None).any()  # standing still nothing is lost


def test_slip_makes_the_distance_uncertain_and_a_turn_of_the_wheels():
    variance, motion = NOISE.slip_sd_per_sqrt_s**2 * 0.3, Pose2(0.1, 0.0, 0.1)
    by_wheels = motion_covariance(motion, NOISE, 0.2, None, 0.3) - motion_covariance(motion, NOISE, 0.2, None)
    np.testing.assert_allclose(by_wheels, np.diag([variance, 0.0, variance / 0.2**2]))
    by_gyro = motion_covariance(motion, NOISE, 0.2, 0.01, 0.3) - motion_covariance(motion, NOISE, 0.2, 0.01)
    np.testing.assert_allclose(by_gyro, np.diag([variance, 0.0, 0.0]))


@pytest.mark.parametrize("parts", [1, 5, 40])
def test_how_uncertain_slip_makes_does_not_depend_on_how_often_is_observed(parts):
    tracker = PoseTracker(AgentConfig(), 0.0)
    tracker.predict(0.0, None, ImuReading(0.0), False)
    for k in range(parts):
        tracker.predict(2.0 * (k + 1) / parts, WheelEncoders(*[0.8 / parts] * 4), ImuReading(0.0), True)
    since = tracker.anchor_from_base
    assert since.mean == Pose2()
    assert since.covariance[0, 0] == pytest.approx(NOISE.slip_sd_per_sqrt_s**2 * 2.0)


# Consistency: the simulator's wheels and inertial unit against what the tracker says of its own error.


def straight(way_m: float, _: np.random.Generator) -> Pattern:
    return [(0.5, 0.0)] * round(way_m / (0.5 * TICK_S))


def arc(way_m: float, _: np.random.Generator) -> Pattern:
    return [(0.5, 0.4)] * round(way_m / (0.5 * TICK_S))


def exploring(way_m: float, rng: np.random.Generator) -> Pattern:
    """Stretches of up to 2 m with turns on the spot between them, as a robot in an office drives."""
    ticks: Pattern = []
    driven = 0.0
    while driven < way_m:
        count = max(1, int(min(rng.uniform(0.5, 2.0), way_m - driven) / (0.4 * TICK_S)))
        ticks += [(0.4, 0.15 * float(rng.standard_normal()))] * count
        driven += count * 0.4 * TICK_S
        turn = float(rng.uniform(-1.6, 1.6))
        ticks += [(0.0, float(np.sign(turn)) * 1.2)] * max(1, int(abs(turn) / (1.2 * TICK_S)))
    return ticks


PATTERNS = {"straight": straight, "arc": arc, "exploring": exploring}
FLAT = World(np.zeros((4, 4), np.uint8), (0.0, 0.0), 0.05)


def dead_reckon(
    config: AgentConfig, level: int, imu: bool, pattern: str, way_m: float, runs: int
) -> tuple[np.ndarray, np.ndarray]:
    """Errors (runs, 3) of the pose since a restart, and the covariances the tracker gives them."""
    errors, covariances = [], []
    for run in range(runs):
        streams = [np.random.default_rng([run, k]) for k in range(3)]
        wheels = Wheels(level, config.body.track_width_m, streams[0])
        unit = Imu(FLAT, level == 0, streams[1]) if imu else None
        true = Pose2()

        def look(truth: Pose2, unit: Imu | None = unit) -> ImuReading | None:
            return unit.read(0.0, 0.0, truth.theta, TICK_S) if unit is not None else None

        tracker = PoseTracker(config, 0.0)
        tracker.predict(0.0, None, look(true), False)
        tracker.restart()
        for tick, (speed, turn) in enumerate(PATTERNS[pattern](way_m, streams[2])):
            true = on_the_circle(true, speed, turn, TICK_S)
            reading = wheels.read(speed, turn, TICK_S, 1.0)
            tracker.predict((tick + 1) * TICK_S, reading, look(true), False)
        since = tracker.anchor_from_base
        error = since.mean.as_array() - true.as_array()
        error[2] = wrap(float(error[2]))
        errors.append(error)
        covariances.append(since.covariance)
    return np.array(errors), np.array(covariances)


@pytest.mark.parametrize("pattern", PATTERNS)
@pytest.mark.parametrize("imu", [False, True], ids=["wheels", "imu"])
def test_dead_reckoning_between_two_tags_knows_its_error(pattern, imu):
    """Level 3 over 4 m, the usual way between two tags.

    The model's errors are white, the simulator's are half a gain that stays for the whole run: no diagonal
    noise is consistent at every length at once. The bounds are those of the average of chi-square with three
    degrees of freedom, widened by a factor of two either way.
    """
    nees = consistency(*dead_reckon(AgentConfig(), 3, imu, pattern, 4.0, 60))
    assert 0.5 * nees.lower < nees.average < 2.0 * nees.upper, nees


def told(level: int) -> AgentConfig:
    return replace(AgentConfig(), odometry=data_sheet(level, BODY.track_width_m))


@pytest.mark.parametrize("level", [1, 5])
@pytest.mark.parametrize("imu", [False, True], ids=["wheels", "imu"])
def test_told_the_right_noise_it_is_consistent_at_every_level(level, imu):
    nees = consistency(*dead_reckon(told(level), level, imu, "exploring", 4.0, 40))
    assert 0.4 * nees.lower < nees.average < 1.2 * nees.upper, nees


@pytest.mark.parametrize("imu", [False, True], ids=["wheels", "imu"])
def test_without_noise_there_is_no_error(imu):
    errors, covariances = dead_reckon(AgentConfig(), 0, imu, "exploring", 4.0, 3)
    errors[:, 2] = wrap_array(errors[:, 2])
    assert np.abs(errors).max() < 1e-9
    assert np.linalg.eigvalsh(covariances)[:, 0].min() > 0.0
