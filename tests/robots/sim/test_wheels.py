from itertools import pairwise
from math import degrees, radians, sqrt

import numpy as np
import pytest

from robots.se2 import Pose2, wrap
from robots.sim.wheels import NOISE_LEVELS, Imu, Wheels
from robots.sim.world import World

DT = 0.05
TRACK = 0.4


def drive(wheels: Wheels, metres: float, turn: float = 0.0, grip: float = 1.0) -> tuple[float, float]:
    """Distance and heading from the wheels after driving at 0.5 m/s."""
    distance = heading = 0.0
    for _ in range(round(metres / 0.5 / DT)):
        reading = wheels.read(0.5, turn, DT, grip)
        left = (reading.front_left_m + reading.rear_left_m) / 2
        right = (reading.front_right_m + reading.rear_right_m) / 2
        distance += (left + right) / 2
        heading += (right - left) / TRACK
    return distance, heading


def test_without_noise_the_wheels_give_the_true_path():
    wheels = Wheels(0, TRACK, np.random.default_rng(0))
    pose, truth = Pose2(), Pose2()
    for k in range(2000):
        speed, turn = (0.5, 0.0) if k % 100 < 50 else (0.3 * (-1) ** k, 1.5)
        reading = wheels.read(speed, turn, DT, 1.0)
        assert reading.front_left_m == reading.rear_left_m
        distance = (reading.front_left_m + reading.front_right_m) / 2
        angle = (reading.front_right_m - reading.front_left_m) / TRACK
        pose = pose @ Pose2.exp(np.array([distance, 0.0, angle]))
        truth = truth @ Pose2.exp(np.array([speed * DT, 0.0, turn * DT]))
    assert pose.as_array() == pytest.approx(truth.as_array(), abs=1e-9)


@pytest.mark.parametrize("level", [1, 2, 3, 4, 5])
def test_errors_follow_the_model(level):
    noise = NOISE_LEVELS[level]
    for metres in (1.0, 4.0):
        runs = np.array(
            [drive(Wheels(level, TRACK, np.random.default_rng([level, k])), metres) for k in range(300)]
        )
        walk, gain = sqrt(metres), metres
        distance_sd = sqrt(
            (noise.shared_gain**2 + noise.wheel_gain**2 / 4) * gain**2
            + (noise.shared_walk**2 + noise.wheel_walk**2 / 4) * walk**2
        )
        heading_sd = sqrt(noise.wheel_gain**2 * gain**2 + noise.wheel_walk**2 * walk**2) / TRACK
        assert runs[:, 0].mean() == pytest.approx(metres, abs=4 * distance_sd / sqrt(300))
        assert runs[:, 0].std() == pytest.approx(distance_sd, rel=0.15)
        assert runs[:, 1].std() == pytest.approx(heading_sd, rel=0.15)


def test_levels_grow_and_the_third_is_about_ten_percent():
    sds = [
        np.std([drive(Wheels(k, TRACK, np.random.default_rng(s)), 1.0)[0] for s in range(200)])
        for k in range(6)
    ]
    assert sds[0] == pytest.approx(0.0, abs=1e-12)
    assert all(b > 1.4 * a for a, b in pairwise(sds))
    assert sds[3] == pytest.approx(0.10, abs=0.025)


def test_slipping_wheels_count_too_much_and_differ():
    wheels = Wheels(0, TRACK, np.random.default_rng(1))
    firm, loose = wheels.read(0.5, 0.0, DT, 1.0), wheels.read(0.5, 0.0, DT, 0.3)
    values = [loose.front_left_m, loose.front_right_m, loose.rear_left_m, loose.rear_right_m]
    assert firm.front_left_m == firm.rear_right_m == 0.025
    assert min(values) >= 0.025
    assert max(values) - min(values) > 0.002
    assert len(set(values)) == 4


def test_yaw_is_biased_slowly_and_within_bounds(hall):
    errors = []
    for seed in range(40):
        imu = Imu(hall, False, np.random.default_rng(seed))
        readings = [imu.read(5.0, 3.0, 3.1, DT).yaw_rad for _ in range(400)]
        errors.append([wrap(value - 3.1) for value in readings])
    bias = np.mean(errors, axis=1)
    assert degrees(bias.std()) == pytest.approx(1.0, abs=0.35)
    assert np.abs(bias).max() < radians(3.2)
    white = np.diff(errors, axis=1).std() / sqrt(2.0)
    assert degrees(white) == pytest.approx(0.2, abs=0.03)


def test_an_exact_imu_is_exact(hall):
    reading = Imu(hall, True, np.random.default_rng(0)).read(5.0, 3.0, -2.0, DT)
    assert (reading.yaw_rad, reading.roll_rad, reading.pitch_rad) == (-2.0, 0.0, 0.0)


def test_ramps_tilt(hall):
    slope = np.zeros((*hall.cells.shape, 2), np.float32)
    slope[:, 100:, 0] = np.tan(0.2)  # rises along x
    imu = Imu(
        World(hall.cells, hall.origin_m, hall.resolution_m, slope=slope), True, np.random.default_rng(0)
    )
    flat, up = imu.read(2.0, 3.0, 0.0, DT), imu.read(8.0, 3.0, 0.0, DT)
    across = imu.read(8.0, 3.0, np.pi / 2, DT)
    assert (flat.roll_rad, flat.pitch_rad) == (0.0, 0.0)
    assert (up.roll_rad, up.pitch_rad) == pytest.approx((0.0, -0.2), abs=1e-6)  # nose up
    assert (across.roll_rad, across.pitch_rad) == pytest.approx((-0.2, 0.0), abs=1e-6)  # right side up


def test_many_ticks_at_once_read_as_one_after_the_other():
    rng = np.random.default_rng(4)
    speeds, turns = rng.uniform(-0.5, 0.5, 200), rng.uniform(-1.5, 1.5, 200)
    grips = rng.uniform(0.3, 1.0, 200)
    one, many = (Wheels(4, TRACK, np.random.default_rng(9)) for _ in range(2))
    readings = many.read_all(speeds, turns, DT, grips)
    for k, row in enumerate(readings):
        single = one.read(float(speeds[k]), float(turns[k]), DT, float(grips[k]))
        assert (single.front_left_m, single.front_right_m, single.rear_left_m, single.rear_right_m) == tuple(
            row.tolist()
        )
    headings = np.cumsum(turns)
    first, second = (Imu(None, False, np.random.default_rng(2)) for _ in range(2))
    yaws = second.yaws(headings, DT)
    singles = [first.read(0.0, 0.0, float(heading), DT).yaw_rad for heading in headings]
    assert yaws == pytest.approx(singles, abs=1e-12)
