"""What the four encoders and the inertial unit tell of the true motion.

Encoders, per observation and wheel i that rolled r metres in truth:
    reading = r * (1 + G + g_i) + sqrt(|r|) * (C + c_i) + spin
G, g_i: gains drawn once per run (normal; G shared by the four wheels); C, c_i: normal each time, so that
the sum over a path is a random walk growing with sqrt(distance). The shared parts spoil the distance, the
wheels' own parts the heading. At level 3 distance is off by about 10 % and heading by about 6 degrees over a
metre. On a slippery floor the wheels roll as commanded while the body moves less, and each spins by its own
amount on top.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import atan, cos, exp, pi, radians, sin, sqrt

import numpy as np
from numba import njit

from robots.config import OdometryConfig
from robots.se2 import Array, wrap, wrap_array
from robots.sim.world import World
from robots.types import ImuReading, WheelEncoders


@dataclass(frozen=True, slots=True)
class NoiseLevel:
    """Standard deviations of the encoder model: gains are ratios, walks metres per square root of a metre."""

    shared_gain: float
    wheel_gain: float
    shared_walk: float
    wheel_walk: float


NOISE_LEVELS = (
    NoiseLevel(0.0, 0.0, 0.0, 0.0),
    NoiseLevel(0.01, 0.005, 0.02, 0.005),
    NoiseLevel(0.03, 0.015, 0.05, 0.015),
    NoiseLevel(0.05, 0.03, 0.09, 0.03),
    NoiseLevel(0.08, 0.06, 0.15, 0.06),
    NoiseLevel(0.12, 0.12, 0.30, 0.12),
)

_SPIN = 0.6  # standard deviation of a wheel's extra spin, as a share of what the floor takes away


def data_sheet(level: int, track_width_m: float, way_m: float = 4.0) -> OdometryConfig:
    """Return the noise that a manufacturer would state for wheels of a level.

    An agent models errors that grow with the square root of the way; a gain grows with the way itself, so it
    is spread over ``way_m``, the distance between two tags.
    """
    noise = NOISE_LEVELS[level]
    distance = noise.shared_walk**2 + noise.wheel_walk**2 / 4.0
    distance += (noise.shared_gain**2 + noise.wheel_gain**2 / 4.0) * way_m
    turn_m = (noise.wheel_gain**2 * way_m + noise.wheel_walk**2) / track_width_m**2
    arm_m = track_width_m / 2.0
    turn_rad = (noise.wheel_walk**2 * arm_m + noise.wheel_gain**2 * arm_m**2 * pi / 2.0) / track_width_m**2
    return OdometryConfig(
        distance_sd_per_sqrt_m=sqrt(distance),
        turn_sd_per_sqrt_m=sqrt(turn_m),
        turn_sd_per_sqrt_rad=sqrt(turn_rad),
    )


class Wheels:
    """The encoders of one robot."""

    def __init__(self, level: int, track_width_m: float, rng: np.random.Generator) -> None:
        self._noise = NOISE_LEVELS[level]
        self._track_m = track_width_m
        self._rng = rng
        gains = rng.standard_normal(5)
        self._gains = 1.0 + self._noise.shared_gain * gains[0] + self._noise.wheel_gain * gains[1:]

    def read(self, speed_mps: float, turn_radps: float, dt_s: float, grip: float) -> WheelEncoders:
        """Return the encoders after a tick in which the wheels ran at this speed and turn rate."""
        row = self.read_all(np.array([speed_mps]), np.array([turn_radps]), dt_s, np.array([grip]))[0]
        return WheelEncoders(*row.tolist())

    def read_all(self, speeds_mps: Array, turns_radps: Array, dt_s: float, grips: Array) -> Array:
        """Return the encoders, (n, 4), after each of n ticks; what ``read`` would say one after the other.

        Columns: front left, front right, rear left, rear right.
        """
        noise = self._noise
        readings: Array = _readings(
            speeds_mps,
            turns_radps * (self._track_m / 2.0),
            dt_s,
            grips,
            self._rng.standard_normal((len(speeds_mps), 9)),
            self._gains,
            noise.shared_walk,
            noise.wheel_walk,
        )
        return readings


@njit(cache=True)
def _readings(
    speeds: Array, asides: Array, dt_s: float, grips: Array, z: Array, gains: Array, shared: float, own: float
) -> Array:
    """The encoder model; ``asides`` is what the turn adds to the speed of the right wheels, ``z`` (n, 9)."""
    readings = np.empty((len(speeds), 4))
    for k in range(len(speeds)):
        for wheel in range(4):
            rolled = (speeds[k] + (asides[k] if wheel % 2 else -asides[k])) * dt_s
            walk = shared * z[k, 0] + own * z[k, 1 + wheel]
            spin = abs(z[k, 5 + wheel]) * _SPIN * (1.0 - grips[k]) * rolled
            readings[k, wheel] = rolled * gains[wheel] + sqrt(abs(rolled)) * walk + spin
    return readings


_BIAS_SD_RAD = radians(1.0)
_BIAS_LIMIT_RAD = radians(3.0)
_BIAS_TIME_S = 120.0
_WHITE_SD_RAD = radians(0.2)


class Imu:
    """An inertial unit: yaw with a slow bounded bias (Ornstein-Uhlenbeck) and white noise, roll, pitch.

    Without a world the floor is level. ``off_rad``: by which its north lies beside the true one, always.
    """

    def __init__(
        self, world: World | None, exact: bool, rng: np.random.Generator, off_rad: float = 0.0
    ) -> None:
        self.off_rad = off_rad
        self._world = world
        self._scale = 0.0 if exact else 1.0
        self._rng = rng
        self._bias_rad = _BIAS_SD_RAD * float(rng.standard_normal())

    def read(self, x_m: float, y_m: float, theta_rad: float, dt_s: float) -> ImuReading:
        """Return the reading at a true pose, ``dt_s`` after the one before."""
        z = self._rng.standard_normal(4)
        self._bias_rad = self._next_bias(float(z[0]), dt_s)
        white = self._scale * _WHITE_SD_RAD
        roll, pitch = self._tilt(x_m, y_m, theta_rad)
        return ImuReading(
            wrap(theta_rad + self.off_rad + self._scale * self._bias_rad + white * float(z[1])),
            roll + white * float(z[2]),
            pitch + white * float(z[3]),
        )

    def yaws(self, thetas_rad: Array, dt_s: float) -> Array:
        """Return the yaw of each of n readings one after the other, (n,), at true headings, (n,)."""
        z = self._rng.standard_normal((len(thetas_rad), 4))
        biases = np.empty(len(z))
        for k, draw in enumerate(z[:, 0].tolist()):
            biases[k] = self._bias_rad = self._next_bias(draw, dt_s)
        return wrap_array(
            thetas_rad + self.off_rad + self._scale * biases + self._scale * _WHITE_SD_RAD * z[:, 1]
        )

    def _next_bias(self, draw: float, dt_s: float) -> float:
        keep = exp(-dt_s / _BIAS_TIME_S)
        bias = keep * self._bias_rad + _BIAS_SD_RAD * sqrt(1.0 - keep * keep) * draw
        return min(max(bias, -_BIAS_LIMIT_RAD), _BIAS_LIMIT_RAD)

    def _tilt(self, x_m: float, y_m: float, theta_rad: float) -> tuple[float, float]:
        """Return roll (positive with the left side up) and pitch (positive with the nose down)."""
        if self._world is None or self._world.slope is None:
            return 0.0, 0.0
        by_x, by_y = self._world.slope[self._world.cell(x_m, y_m)]
        c, s = cos(theta_rad), sin(theta_rad)
        return atan(float(-s * by_x + c * by_y)), -atan(float(c * by_x + s * by_y))
