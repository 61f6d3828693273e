"""The robot as built: no two are alike. Mass, balance, motors, wheels and sensors are drawn per world.

Motors are direct-current motors under a voltage that goes with the commanded speed: their torque falls with
the speed, so a loaded wheel is slow and a wheel that has lost its grip runs ahead. A stiff velocity servo
would hide both.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import radians
from xml.etree import ElementTree as Xml

import numpy as np

from robots.config import BodyConfig
from robots.se2 import Array
from robots.sim.physics.floor import ARENA_M, GRAVITY_MPS2

WHEELS = ("front_left", "front_right", "rear_left", "rear_right")
RADIUS_M = 0.08
WHEELBASE_M = 0.30
TRACK_M = BodyConfig().track_width_m
STEP_S = 0.0025
_WALL_M = 0.2
_CRATE_FRICTION = 0.4
_TYRE_N_PER_M, _TYRE_NS_PER_M = 10_000.0, 300.0  # rigid wheels would hop when they scrub sideways


@dataclass(frozen=True, slots=True, eq=False)
class Build:
    """One robot and its arena.

    ``motor_gains`` and ``encoder_gains`` (4,) in the order of ``WHEELS``: what each wheel makes of its
    voltage and what its encoder makes of its rolling. ``stiffness`` is the torque a motor loses per rad/s
    (N m s / rad), ``torque_nm`` the most it has. ``obstacles`` (n, 3): x, y and half side (m) of what is
    fixed; ``crates`` (m, 3): x, y, mass (kg) of what can be pushed.
    """

    mass_kg: float
    centre_m: tuple[float, float, float]
    stiffness: float
    torque_nm: float
    drag_nm: float
    motor_gains: Array
    encoder_gains: Array
    turn_factor: float
    ticks_per_turn: int
    yaw_sd_rad: float
    yaw_drift_sd_rad: float
    obstacles: Array
    crates: Array


def draw_build(rng: np.random.Generator) -> Build:
    """Return a robot of the size of Kleiner's: 12 to 20 kg, 8 cm wheels, gains that spread by 5 to 10 %."""
    spread = rng.uniform(0.05, 0.10)
    return Build(
        mass_kg=float(rng.uniform(12.0, 20.0)),
        centre_m=(
            float(rng.uniform(-0.04, 0.04)),
            float(rng.uniform(-0.03, 0.03)),
            float(rng.uniform(0.08, 0.16)),
        ),
        stiffness=float(rng.uniform(1.0, 2.5)),
        torque_nm=float(rng.uniform(4.0, 6.0)),
        drag_nm=float(rng.uniform(0.05, 0.2)),
        motor_gains=1.0 + rng.uniform(-spread, spread, 4),
        encoder_gains=1.0 + rng.uniform(-spread, spread, 4),
        turn_factor=float(rng.uniform(1.0, 1.5)),
        ticks_per_turn=int(2.0 ** rng.uniform(9.0, 12.0)),
        yaw_sd_rad=radians(float(rng.uniform(0.03, 0.2))),
        yaw_drift_sd_rad=radians(float(rng.uniform(0.02, 0.2))),
        obstacles=_strewn(rng, 7, 0.1, 0.3),
        crates=_strewn(rng, 3, 2.0, 10.0),
    )


def _strewn(rng: np.random.Generator, count: int, low: float, high: float) -> Array:
    angles, ways = rng.uniform(-np.pi, np.pi, count), rng.uniform(1.2, ARENA_M / 2.0 - 0.4, count)
    return np.column_stack([ways * np.cos(angles), ways * np.sin(angles), rng.uniform(low, high, count)])


def model_xml(build: Build) -> str:
    """Return the MJCF model of a robot in its arena, standing in the middle.

    The wheels' friction outranks the floor's: a patch takes no more than setting that of the wheels on it.
    """
    root = Xml.Element("mujoco")
    Xml.SubElement(
        root, "option", timestep=str(STEP_S), integrator="implicitfast", cone="elliptic", impratio="10"
    )
    world = Xml.SubElement(root, "worldbody")
    Xml.SubElement(world, "geom", type="plane", size="10 10 1", friction="0.5")
    half = ARENA_M / 2.0 + _WALL_M
    for x, y in ((half, 0.0), (-half, 0.0), (0.0, half), (0.0, -half)):
        size = (_WALL_M, half, 0.3) if x else (half, _WALL_M, 0.3)
        Xml.SubElement(world, "geom", type="box", pos=_text(x, y, 0.3), size=_text(*size))
    for x, y, side in build.obstacles:
        Xml.SubElement(world, "geom", type="box", pos=_text(x, y, 0.2), size=_text(side, side, 0.2))
    for x, y, mass in build.crates:  # they slide over the floor against dry friction and do not tip
        crate = Xml.SubElement(world, "body", pos=_text(x, y, 0.16))
        for axis in ("1 0 0", "0 1 0"):
            loss = _CRATE_FRICTION * GRAVITY_MPS2 * mass
            Xml.SubElement(crate, "joint", type="slide", axis=axis, frictionloss=_text(loss))
        Xml.SubElement(crate, "geom", type="box", size="0.15 0.15 0.15", mass=_text(mass), friction="0.3")
    _add_robot(root, world, build)
    return Xml.tostring(root, encoding="unicode")


def _add_robot(root: Xml.Element, world: Xml.Element, build: Build) -> None:
    base = Xml.SubElement(world, "body", name="base", pos=_text(0.0, 0.0, RADIUS_M))
    Xml.SubElement(base, "freejoint", name="base")
    wheel_kg = 0.4
    mass = build.mass_kg - 4.0 * wheel_kg
    inertia = (mass * 0.02, mass * 0.02, mass * 0.03)  # a box of 0.45 x 0.40 x 0.2 m
    x, y, z = build.centre_m
    Xml.SubElement(
        base, "inertial", pos=_text(x, y, z - RADIUS_M), mass=_text(mass), diaginertia=_text(*inertia)
    )
    Xml.SubElement(base, "geom", type="box", pos="0 0 0.08", size="0.24 0.17 0.07", friction="0.3")
    motors = Xml.SubElement(root, "actuator")
    for name, gain in zip(WHEELS, build.motor_gains, strict=True):
        ahead = WHEELBASE_M / 2.0 if name.startswith("front") else -WHEELBASE_M / 2.0
        left = TRACK_M / 2.0 if name.endswith("left") else -TRACK_M / 2.0
        axle = Xml.SubElement(base, "body", pos=_text(ahead, left, 0.0))
        Xml.SubElement(axle, "inertial", pos="0 0 0", mass="0.1", diaginertia="1e-4 1e-4 1e-4")
        Xml.SubElement(
            axle,
            "joint",
            type="slide",
            axis="0 0 1",
            stiffness=_text(_TYRE_N_PER_M),
            damping=_text(_TYRE_NS_PER_M),
        )
        wheel = Xml.SubElement(axle, "body", name=name)
        Xml.SubElement(
            wheel,
            "joint",
            name=name,
            axis="0 1 0",
            armature="0.005",
            damping="0.01",
            frictionloss=_text(build.drag_nm),
        )
        Xml.SubElement(
            wheel,
            "geom",
            name=name,
            type="ellipsoid",
            size=_text(RADIUS_M, 0.02, RADIUS_M),
            mass=_text(wheel_kg),
            priority="1",
        )
        # torque = stiffness * (gain * wanted speed - speed): the droop of a motor under constant voltage
        Xml.SubElement(
            motors,
            "general",
            joint=name,
            gainprm=_text(build.stiffness * gain),
            biastype="affine",
            biasprm=_text(0.0, 0.0, -build.stiffness),
            forcerange=_text(-build.torque_nm, build.torque_nm),
        )


def _text(*numbers: float) -> str:
    return " ".join(f"{number:.6g}" for number in numbers)
