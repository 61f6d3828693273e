"""Motion of the base between two observations, from whatever odometry the robot has.

Kleiner 2006 eq. (1) and (2). A motion is a Gaussian pose ``previous_from_base`` in the frame of the previous
base.
"""

from __future__ import annotations

from math import sqrt

import numpy as np

from robots.config import BodyConfig, OdometryConfig
from robots.se2 import Array, GaussianPose, Pose2, compose_jacobians
from robots.types import DistanceTurn, Odometry, WheelEncoders


def wheel_motion(wheels: WheelEncoders, track_width_m: float) -> tuple[float, float]:
    """Return distance (m) and turn (rad) of a differentially steered body from its four wheels."""
    left = (wheels.front_left_m + wheels.rear_left_m) / 2.0
    right = (wheels.front_right_m + wheels.rear_right_m) / 2.0
    return (left + right) / 2.0, (right - left) / track_width_m


def motion_mean(odometry: Odometry | None, turn_rad: float | None, body: BodyConfig) -> Pose2:
    """Return the mean motion ``previous_from_base``.

    Wheels follow an exact arc. (d, alpha) moves along the old heading and then turns, as eq. (1) is printed.
    ``turn_rad`` is the turn measured by the inertial unit; where given it replaces the wheels' (Kleiner
    2006).
    """
    if odometry is None:
        return Pose2(0.0, 0.0, turn_rad or 0.0)
    if isinstance(odometry, WheelEncoders):
        distance, turn = wheel_motion(odometry, body.track_width_m)
        turn = turn if turn_rad is None else turn_rad
        return Pose2.exp(np.array([distance, 0.0, turn]))
    if isinstance(odometry, DistanceTurn):
        return Pose2(odometry.distance_m, 0.0, odometry.turn_rad if turn_rad is None else turn_rad)
    return Pose2(odometry.dx_m, odometry.dy_m, odometry.dtheta_rad if turn_rad is None else turn_rad)


def motion_covariance(
    motion: Pose2,
    noise: OdometryConfig,
    wheel_arm_m: float,
    turn_sd_rad: float | None,
    slipping_s: float = 0.0,
) -> Array:
    """Return Sigma_u of eq. (2) as (3, 3) in the previous base frame.

    Variances grow linearly with the motion. ``wheel_arm_m`` is half the track width. ``turn_sd_rad`` is the
    deviation of a turn measured by the inertial unit, None where the wheels measured it. Over ``slipping_s``
    seconds in which the wheels slip the travelled distance becomes less certain; so does the turn where the
    wheels measured it, but not the inertial unit's (Kleiner 2006).
    """
    distance = sqrt(motion.x**2 + motion.y**2)
    rolled = distance + abs(motion.theta) * wheel_arm_m  # wheels roll, and err, in turns on the spot too
    along = noise.distance_sd_per_sqrt_m**2 * rolled
    across = noise.lateral_sd_per_sqrt_m**2 * distance
    slip = noise.slip_sd_per_sqrt_s**2 * slipping_s
    along += slip
    if turn_sd_rad is None:
        turn = noise.turn_sd_per_sqrt_m**2 * distance + noise.turn_sd_per_sqrt_rad**2 * abs(motion.theta)
        turn += slip / wheel_arm_m**2  # either side slips by itself, with twice the variance of their mean
    else:
        turn = turn_sd_rad**2
    return np.diag([along, across, turn])


def predict(belief: GaussianPose, motion: GaussianPose) -> GaussianPose:
    """Move a belief by a motion: eq. (1) for the mean, eq. (2) with both Jacobians for the covariance."""
    by_pose, by_motion = compose_jacobians(belief.mean, motion.mean)  # nabla F_l, nabla F_u
    covariance = by_pose @ belief.covariance @ by_pose.T + by_motion @ motion.covariance @ by_motion.T  # (2)
    return GaussianPose(belief.mean @ motion.mean, (covariance + covariance.T) / 2.0)  # (1)
