"""Drives of the mission simulator's robots, beside the physical ones: other floors, other encoders.

``robots.sim`` knows no forces: wheels do what they are told, nothing scrubs, slippery floor gives a share of
the motion, encoders err by random walks (``robots.sim.wheels``). Trees that learnt from physics alone take
such noise for slippage; with some of these drives among their lessons they do not.
"""

from __future__ import annotations

from math import hypot, radians

import numpy as np

from robots.se2 import Pose2, wrap
from robots.sim.body import ACCELERATION_MPS2, TURN_ACCELERATION_RADPS2
from robots.sim.physics.build import TRACK_M
from robots.sim.physics.drive import Drive, ramp
from robots.sim.physics.driver import PERIOD_S, Driver
from robots.sim.scenario import ODOMETRY_HZ
from robots.sim.wheels import NOISE_LEVELS, Wheels

_TICK_S = 1.0 / ODOMETRY_HZ
_YAW_SD_RAD = radians(0.2)
_PATCHES = 6
_PATCH_LOW, _PATCH_HIGH = (-3.5, -3.5, 0.4, 0.2), (3.5, 3.5, 1.25, 0.6)  # x, y, radius, grip


def drive_kinematic(
    seed: int, seconds: float, level: int | None = None, slippery: bool | None = None
) -> Drive:
    """Return a drive at a level of noise, on a floor that is slippery or not; None draws them."""
    own, driving, wheels, yaws = (np.random.default_rng([seed, 10 + k]) for k in range(4))
    drawn_level, drawn_slippery = int(own.integers(len(NOISE_LEVELS))), bool(own.random() < 0.5)
    encoders = Wheels(drawn_level if level is None else level, TRACK_M, wheels)
    count = _PATCHES if (drawn_slippery if slippery is None else slippery) else 0
    patches = own.uniform(_PATCH_LOW, _PATCH_HIGH, (count, 4)).tolist()
    driver, pose = Driver(driving), Pose2()
    speed = turn = 0.0
    command = (0.0, 0.0)
    readings, headings, commands, poses, rolled = [], [], [], [pose.as_array()], []
    for tick in range(round(seconds / _TICK_S)):
        if tick % round(PERIOD_S / _TICK_S) == 0:
            command = driver.decide(pose)
        speed = ramp(speed, command[0], ACCELERATION_MPS2 * _TICK_S)
        turn = ramp(turn, command[1], TURN_ACCELERATION_RADPS2 * _TICK_S)
        grip = next((g for x, y, r, g in patches if hypot(pose.x - x, pose.y - y) < r), 1.0)
        pose = pose @ Pose2.exp(np.array([speed, 0.0, turn]) * _TICK_S * grip)
        aside = turn * TRACK_M / 2.0
        reading = encoders.read(speed, turn, _TICK_S, grip)
        readings.append(
            [reading.front_left_m, reading.front_right_m, reading.rear_left_m, reading.rear_right_m]
        )
        rolled.append(np.array([speed - aside, speed + aside] * 2) * _TICK_S)
        headings.append(wrap(pose.theta + _YAW_SD_RAD * float(yaws.standard_normal())))
        commands.append(command)
        poses.append(pose.as_array())
    stamps = np.array([_TICK_S * (tick + 1) for tick in range(len(headings))])
    return Drive(
        stamps, np.array(readings), np.array(headings), np.array(commands), np.array(poses), np.array(rolled)
    )
