"""The slip detector: laws of its features, and what it must never say."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.estimation.slip.detector import SlipDetector
from robots.estimation.slip.features import (
    canonical,
    differences,
)
from robots.estimation.slip.noise import WalkNoise
from robots.se2 import wrap
from robots.sim.wheels import Wheels
from robots.snapshot import freeze, thaw
from robots.types import Command, Displacement, ImuReading, WheelEncoders

TRACK_M = 0.4
SPEED = st.floats(-1.0, 1.0)
FOUR = st.tuples(SPEED, SPEED, SPEED, SPEED)
Motion = tuple[float, float]  # speed, turn rate


def mirrored(wheels):
    front_left, front_right, rear_left, rear_right = wheels
    return front_right, front_left, rear_right, rear_left


def from_the_rear(wheels):
    front_left, front_right, rear_left, rear_right = wheels
    return -rear_right, -rear_left, -front_right, -front_left


class Robot:
    """Drives as told on firm floor, or with its wheels spinning, and asks its detector."""

    def __init__(self, kind="extended", hz=20.0, level=0, mirror=False, imu=True):
        self.detector = SlipDetector(kind)
        self.dt = 1.0 / hz
        self.stamp, self.yaw = 0.0, 0.0
        self.wheels = Wheels(level, TRACK_M, np.random.default_rng(5))
        self.mirror, self.imu = mirror, imu
        self.detector.observe(0.0, None, ImuReading(0.0) if imu else None, None)

    def drive(self, seconds: float, motion: Motion, extra=(0.0, 0.0, 0.0, 0.0), grip=1.0) -> list[bool]:
        """Drive; ``extra`` is what each wheel turns faster, in m/s, ``grip`` the share the floor gives."""
        said = []
        for _ in range(round(seconds / self.dt)):
            self.stamp += self.dt
            self.yaw = wrap(self.yaw + motion[1] * grip * self.dt)
            reading = self.wheels.read(*motion, self.dt, grip)
            rolled = (
                np.array([getattr(reading, name) for name in reading.__slots__]) + np.array(extra) * self.dt
            )
            imu, command = ImuReading(self.yaw), Command(*motion)
            if self.mirror:
                rolled = mirrored(rolled)
                imu, command = ImuReading(-self.yaw), Command(motion[0], -motion[1])
            said.append(
                self.detector.observe(
                    self.stamp, WheelEncoders(*map(float, rolled)), imu if self.imu else None, command
                )
            )
        return said


# Features


@given(FOUR)
def test_differences_of_mirrored_wheels_are_mirrored(wheels):
    left, right, front, rear = differences(wheels)
    assert differences(mirrored(wheels)) == (right, left, -front, -rear)


@given(FOUR)
def test_a_motion_its_mirror_image_and_its_reverse_are_one(wheels):
    seen = canonical(wheels)
    forward, across = sum(seen), seen[1] + seen[3] - seen[0] - seen[2]
    assert forward >= -1e-12
    assert across >= -1e-12
    if min(abs(forward), abs(across)) > 1e-9:  # else either view is as good
        assert canonical(mirrored(wheels)) == seen
        assert canonical(from_the_rear(wheels)) == seen


def test_the_whole_detector_sees_a_mirrored_drive_alike():
    one, other = Robot(), Robot(mirror=True)
    for robot in (one, other):
        robot.drive(4.0, (0.3, 0.6))
        robot.drive(1.0, (0.4, 0.2), extra=(0.2, 0.0, 0.0, 0.1))
    np.testing.assert_allclose(other.detector.values()[1], one.detector.values()[1], atol=1e-9)


@pytest.mark.parametrize("hz", [10.0, 40.0, 50.0])
def test_features_do_not_depend_on_how_often_is_observed(hz):
    usual, other = Robot(), Robot(hz=hz)
    for robot in (usual, other):
        robot.drive(25.0, (0.3, 0.5))  # long enough to know that its encoders are exact
        robot.drive(0.6, (0.3, 0.5), extra=(0.1, 0.0, -0.05, 0.0))
    for ours, theirs in zip(usual.detector.values(), other.detector.values(), strict=True):
        np.testing.assert_allclose(theirs, ours, atol=1e-6)


def test_the_window_forgets_what_is_older_than_0_3_s():
    robot = Robot()
    robot.drive(25.0, (0.3, 0.0))
    fresh = robot.detector.values()[1]
    robot.drive(0.2, (0.3, 0.0), extra=(0.3, 0.0, 0.0, 0.0))
    assert robot.detector.values()[1] != pytest.approx(fresh, abs=1e-3)
    robot.drive(0.35, (0.3, 0.0))
    assert robot.detector.values()[1] == pytest.approx(fresh, abs=1e-9)


# Verdicts


@given(st.lists(st.tuples(*[st.floats(-0.019, 0.019)] * 4), min_size=1, max_size=12), SPEED, SPEED)
def test_wheels_that_stand_still_never_slip(velocities, speed, turn):
    detector = SlipDetector()
    detector.observe(0.0, None, ImuReading(0.0), None)
    for k, wheels in enumerate(velocities):
        reading = WheelEncoders(*(0.05 * v for v in wheels))
        assert not detector.observe(0.05 * (k + 1), reading, ImuReading(0.3 * k * turn), Command(speed, turn))


@pytest.mark.parametrize("level", range(6))
def test_firm_floor_is_hardly_ever_taken_for_slippery(level):
    rng = np.random.default_rng(level)
    robot = Robot(level=level)
    said = []
    for _ in range(150):
        motion = [(0.5, 0.0), (0.3, 0.5), (0.0, 1.2), (0.0, 0.0), (-0.2, 0.3)][int(rng.integers(5))]
        said += robot.drive(0.8, motion)
    assert np.mean(said) < 0.05


def test_wheels_that_spin_apart_are_noticed_by_the_basic_tree():
    robot = Robot("basic")
    robot.drive(10.0, (0.3, 0.0))
    assert not any(robot.drive(1.0, (0.3, 0.0)))
    assert np.mean(robot.drive(1.0, (0.3, 0.0), extra=(0.05, 0.3, 0.25, 0.1))) > 0.5


@pytest.mark.parametrize("motion", [(0.45, 0.5), (0.4, -0.6)])
def test_in_a_turn_a_slippery_floor_is_noticed_by_the_extended_tree(motion):
    """The body turns less than wheels and command say."""
    robot = Robot()
    robot.drive(10.0, motion)
    assert np.mean(robot.drive(1.0, motion)) < 0.05
    assert np.mean(robot.drive(2.0, motion, grip=0.3)) > 0.5
    robot.drive(0.4, motion)
    assert np.mean(robot.drive(1.0, motion)) < 0.05


def test_without_gyro_or_command_the_basic_tree_decides():
    robot, basic = Robot(imu=False), Robot("basic", imu=False)
    for motion, extra in (((0.3, 0.2), (0.0,) * 4), ((0.3, 0.0), (0.3, 0.0, 0.0, 0.2))):
        assert robot.drive(2.0, motion, extra) == basic.drive(2.0, motion, extra)
        assert robot.detector.values()[1] is None
    detector = SlipDetector()
    for k in range(20):
        detector.observe(0.05 * k, WheelEncoders(0.01, 0.01, 0.01, 0.01), ImuReading(0.0), None)
    assert detector.values()[0] is not None
    assert detector.values()[1] is None


def test_it_is_a_function_of_what_it_saw_and_survives_a_snapshot():
    one, other = Robot(level=1), Robot(level=1)
    one.drive(5.0, (0.4, 0.1))
    other.drive(5.0, (0.4, 0.1))
    other.detector = thaw(freeze(other.detector), SlipDetector)
    pattern = [(0.3, 0.4, (0.3, 0.0, 0.0, 0.0)), (0.4, 0.0, (0.0,) * 4), (0.0, 1.0, (0.0, 0.2, 0.0, 0.3))]
    for speed, turn, extra in pattern:
        assert one.drive(1.0, (speed, turn), extra) == other.drive(1.0, (speed, turn), extra)
    assert freeze(one.detector) == freeze(other.detector)


# Input as it comes


def test_what_rolled_while_the_clock_stood_still_is_not_lost():
    whole, parts = SlipDetector(), SlipDetector()
    for detector in (whole, parts):
        detector.observe(0.0, None, ImuReading(0.0), Command())
    for k in range(1, 9):
        stamp, command = 0.05 * k, Command(0.3, 0.0)
        whole.observe(stamp, WheelEncoders(0.02, 0.01, 0.02, 0.01), ImuReading(0.0), command)
        parts.observe(stamp - 0.05, WheelEncoders(0.015, 0.005, 0.015, 0.005), ImuReading(0.0), command)
        parts.observe(stamp, WheelEncoders(0.005, 0.005, 0.005, 0.005), ImuReading(0.0), command)
        assert parts.values()[0] == pytest.approx(whole.values()[0])


@pytest.mark.parametrize("step", [-3.0, 0.6, 100.0], ids=["reversed", "gap", "long gap"])
def test_after_a_gap_or_a_reversed_stamp_it_begins_anew(step):
    robot = Robot()
    robot.drive(5.0, (0.3, 0.0), extra=(0.4, 0.0, 0.0, 0.4))
    robot.stamp += step
    said = robot.drive(0.05, (0.3, 0.0), extra=(0.4, 0.0, 0.0, 0.4))
    assert said == [False]
    assert robot.detector.values() == (None, None)
    robot.drive(1.0, (0.3, 0.0))
    assert robot.detector.values()[1] is not None


def test_other_odometry_than_four_wheels_says_nothing():
    detector = SlipDetector()
    for k in range(10):
        assert not detector.observe(0.05 * k, Displacement(0.5, 0.1, 1.0), ImuReading(0.0), Command())
    assert detector.values() == (None, None)


@pytest.mark.parametrize("huge", [1e300, -1e300, 1.7e308])
def test_absurd_distances_are_survived(huge):
    detector = SlipDetector()
    for k in range(10):
        reading = WheelEncoders(huge, -huge, huge, 0.01)
        assert detector.observe(0.05 * k, reading, ImuReading(0.0), Command(0.2, 0.0)) in (False, True)
    for k in range(10, 60):
        reading = WheelEncoders(0.01, 0.01, 0.01, 0.01)
        detector.observe(0.05 * k, reading, ImuReading(0.0), Command(0.2, 0.0))
    assert not detector.slipping


# Noise


@pytest.mark.parametrize("walk", [0.01, 0.05])
@pytest.mark.parametrize("hz", [10.0, 20.0, 50.0])
def test_a_random_walk_is_learnt_whatever_the_rate(walk, hz):
    rng, noise, dt = np.random.default_rng(1), WalkNoise(), 1.0 / hz
    learnt = []
    for _ in range(4000):
        rolled = 0.4 * dt
        noise.observe((rolled + walk * np.sqrt(rolled) * rng.standard_normal()) / dt, rolled, dt)
        learnt.append(noise.walk)
    assert np.median(learnt[1000:]) == pytest.approx(walk, rel=0.15)


def test_a_slippery_patch_does_not_count_as_noise():
    rng, noise, dt = np.random.default_rng(2), WalkNoise(), 0.05
    for k in range(4000):
        spin = 0.2 * rng.standard_normal() if k % 400 < 100 else 0.0
        noise.observe(0.4 + 0.01 * rng.standard_normal() + spin, 0.02, dt)
    assert noise.velocity_sd_mps(0.02, dt) < 0.03
