"""A drive through one world: what the robot's sensors say beside what truly happened.

World, robot and driver come from one seed, so worlds of different seeds share neither floor nor gains.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import atan2, pi, sqrt
from typing import Any

import numpy as np

from robots.se2 import Array, Pose2, wrap
from robots.sim.body import ACCELERATION_MPS2, TURN_ACCELERATION_RADPS2
from robots.sim.physics.build import RADIUS_M, STEP_S, TRACK_M, WHEELS, Build, draw_build, model_xml
from robots.sim.physics.driver import PERIOD_S, Driver
from robots.sim.physics.floor import Floor, draw_floor
from robots.types import Command, ImuReading, WheelEncoders

_CONTROL_S = 0.01  # friction, gravity and the motors' ramps are renewed so often
_SETTLE_S = 0.3


class PhysicsError(RuntimeError):
    """The physical simulation cannot run; the message says what to install or do."""


@dataclass(frozen=True, slots=True)
class Sample:
    """What the agent gets at one observation: ``command`` is the one that was in force until now."""

    stamp_s: float
    odometry: WheelEncoders
    imu: ImuReading
    command: Command


@dataclass(frozen=True, slots=True, eq=False)
class Drive:
    """n observations about 20 times a second.

    ``stamps_s`` (n,), ``rolled_m`` (n, 4) as the encoders report, ``yaws_rad`` (n,) as the inertial unit
    does, ``commands`` (n, 2) in force before each observation. Truth: ``poses`` (n + 1, 3) of the base on the
    floor, from before the first observation on; ``true_rolled_m`` (n, 4) of the wheels' rims.
    """

    stamps_s: Array
    rolled_m: Array
    yaws_rad: Array
    commands: Array
    poses: Array
    true_rolled_m: Array

    def samples(self) -> Iterator[Sample]:
        """Yield the observations as an agent gets them."""
        for stamp, rolled, yaw, (speed, turn) in zip(
            self.stamps_s.tolist(),
            self.rolled_m.tolist(),
            self.yaws_rad.tolist(),
            self.commands.tolist(),
            strict=True,
        ):
            yield Sample(stamp, WheelEncoders(*rolled), ImuReading(yaw), Command(speed, turn))


def drive_world(seed: int, seconds: float) -> Drive:
    """Return a drive through the world of a seed.

    Raises:
        PhysicsError: MuJoCo is not installed, or the simulation broke down.
    """
    floor, build, driver, sensors = (np.random.default_rng([seed, k]) for k in range(4))
    return drive(draw_floor(floor), draw_build(build), Driver(driver), seconds, sensors)


def drive(floor: Floor, build: Build, driver: Driver, seconds: float, rng: np.random.Generator) -> Drive:
    """Return a drive of a robot over a floor. Raises PhysicsError as ``drive_world`` does."""
    machine = _Machine(floor, build)
    stamps, rolled, yaws, commands, poses, true_rolled = [], [], [], [], [machine.pose()], []
    sensed = _Sensors(build, rng)
    clock_s = due_s = 0.0
    command = in_force = (0.0, 0.0)
    while clock_s < seconds:
        steps = int(rng.choice((4, 5, 5, 5, 6)))  # the robot's own clock is not exact, its stamps are
        angles = machine.angles()
        for _ in range(steps):
            if clock_s >= due_s - 1e-9:
                command = driver.decide(machine.pose())
                due_s += PERIOD_S
            machine.advance(command)
            clock_s += _CONTROL_S
        poses.append(machine.pose())
        true_rolled.append((machine.angles() - angles) * RADIUS_M)
        stamps.append(clock_s)
        rolled.append(sensed.encoders(machine.angles()))
        yaws.append(sensed.yaw(poses[-1].theta, steps * _CONTROL_S))
        commands.append(in_force)
        in_force = command
    return Drive(
        np.array(stamps),
        np.array(rolled),
        np.array(yaws),
        np.array(commands),
        np.array([pose.as_array() for pose in poses]),
        np.array(true_rolled),
    )


def ramp(now: float, wanted: float, step: float) -> float:
    """Return a velocity one step nearer to the one that is wanted."""
    return now + min(step, max(-step, wanted - now))


class _Machine:
    """The simulated robot."""

    def __init__(self, floor: Floor, build: Build) -> None:
        try:
            import mujoco
        except ImportError:
            raise PhysicsError(
                "the physical simulation needs MuJoCo; install it by pip install 'waymark[physics]'"
            ) from None
        self._mujoco: Any = mujoco
        self._floor = floor
        self._factor = build.turn_factor
        self._model = mujoco.MjModel.from_xml_string(model_xml(build))
        self._data = mujoco.MjData(self._model)
        self._base = int(self._model.joint("base").qposadr[0])
        self._wheels = [int(self._model.joint(name).qposadr[0]) for name in WHEELS]
        self._geoms = [self._model.geom(name).id for name in WHEELS]
        self._bad = int(mujoco.mjtWarning.mjWARN_BADQACC)
        self._velocity = 0.0, 0.0
        for _ in range(round(_SETTLE_S / _CONTROL_S)):
            self.advance((0.0, 0.0))

    def advance(self, command: tuple[float, float]) -> None:
        """Run the motors for ``_CONTROL_S``; the command is reached by a ramp, as in ``robots.sim.body``."""
        speed = ramp(self._velocity[0], command[0], ACCELERATION_MPS2 * _CONTROL_S)
        turn = ramp(self._velocity[1], command[1], TURN_ACCELERATION_RADPS2 * _CONTROL_S)
        self._velocity = speed, turn
        aside = turn * self._factor * TRACK_M / 2.0
        left, right = (speed - aside) / RADIUS_M, (speed + aside) / RADIUS_M
        self._data.ctrl[:] = left, right, left, right
        self._model.geom_friction[self._geoms, 0] = self._floor.friction(
            self._data.geom_xpos[self._geoms, :2]
        )
        x, y = self._data.qpos[self._base : self._base + 2]
        self._model.opt.gravity[:] = self._floor.gravity(x, y)
        self._mujoco.mj_step(self._model, self._data, nstep=round(_CONTROL_S / STEP_S))
        if self._data.warning[self._bad].number > 0:
            raise PhysicsError("the physical simulation became unstable")

    def pose(self) -> Pose2:
        """Return where the base is on the floor."""
        x, y, _, w, i, j, k = self._data.qpos[self._base : self._base + 7]
        return Pose2(float(x), float(y), atan2(2.0 * (w * k + i * j), 1.0 - 2.0 * (j * j + k * k)))

    def angles(self) -> Array:
        """Return how far each wheel has turned, (4,), in radians."""
        angles: Array = self._data.qpos[self._wheels]
        return angles


class _Sensors:
    """Encoders that count ticks and a yaw that drifts."""

    def __init__(self, build: Build, rng: np.random.Generator) -> None:
        self._build = build
        self._rng = rng
        self._ticks: Array | None = None
        self._drift_rad = 0.0

    def encoders(self, angles: Array) -> Array:
        """Return the distances rolled since the last reading, (4,), from the wheels' angles in radians."""
        ticks = np.floor(angles / (2.0 * pi) * self._build.ticks_per_turn)
        before = self._ticks if self._ticks is not None else ticks
        self._ticks = ticks
        per_tick_m = 2.0 * pi * RADIUS_M / self._build.ticks_per_turn
        return (ticks - before) * per_tick_m * self._build.encoder_gains

    def yaw(self, theta_rad: float, dt_s: float) -> float:
        z = self._rng.standard_normal(2)
        self._drift_rad += self._build.yaw_drift_sd_rad * sqrt(dt_s) * float(z[0])
        return wrap(theta_rad + self._drift_rad + self._build.yaw_sd_rad * float(z[1]))
