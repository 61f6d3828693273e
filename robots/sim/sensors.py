"""The sensors a robot looks round with: laser, sonar and infrared rings, thermal camera."""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2, hypot, inf, pi, radians

import numpy as np

from robots.se2 import Array, Pose2, wrap
from robots.sim.rays import SMOKE_DEPTH_M, cast, in_sight
from robots.sim.world import GLASS, WALL, Cells, World
from robots.types import FloatArray32, HeatReading, LaserScan, RangeReading


@dataclass(frozen=True, slots=True)
class LaserConfig:
    """A laser range finder at the centre of the base, looking ahead."""

    field_of_view_rad: float = radians(240.0)
    beams: int = 240
    range_max_m: float = 4.0
    sd_m: float = 0.01


@dataclass(frozen=True, slots=True)
class HeatConfig:
    """A thermal camera: how far and wide it looks, how well it measures and how often it is wrong."""

    range_max_m: float = 3.0
    cone_rad: float = radians(60.0)
    detection: float = 0.6  # probability per look at a visible victim
    range_sd: float = 0.05  # of the range
    bearing_sd_rad: float = radians(2.0)
    false_alarms_per_s: float = 0.005


def far_reading(range_max_m: float) -> np.float32:
    """Return what a laser reports where nothing comes back: the smallest float32 not below its range."""
    value = np.float32(range_max_m)
    return value if float(value) >= range_max_m else np.nextafter(value, np.float32(inf))


class Laser:
    """The laser of one robot. It marks the cells it truly saw in ``seen``, uint8 (h, w)."""

    def __init__(self, world: World, config: LaserConfig, rng: np.random.Generator) -> None:
        self._world = world
        self._config = config
        self._rng = rng
        self._increment_rad = config.field_of_view_rad / max(1, config.beams - 1)
        self._angles = (
            np.arange(config.beams, dtype=np.float64) * self._increment_rad - config.field_of_view_rad / 2.0
        )
        self._far = far_reading(config.range_max_m)

    def scan(self, pose: Pose2, others_m: Array, radius_m: float, seen: Cells) -> LaserScan:
        """Return a sweep from a true pose.

        Other robots at ``others_m``, (k, 2), are discs of ``radius_m``.
        """
        config = self._config
        ranges = cast(
            self._world,
            pose.x,
            pose.y,
            self._angles + pose.theta,
            config.range_max_m,
            discs_m=others_m,
            disc_radius_m=radius_m,
            seen=seen,
        )
        if config.sd_m > 0.0:
            ranges = ranges + config.sd_m * self._rng.standard_normal(ranges.size)
        noisy = np.round(np.maximum(ranges, 0.001), 3)
        measured: FloatArray32 = np.where(noisy >= config.range_max_m, self._far, noisy).astype(np.float32)
        return LaserScan(measured, float(self._angles[0]), self._increment_rad, config.range_max_m)


@dataclass(frozen=True, slots=True)
class _RingKind:
    range_max_m: float
    cone_rad: float
    sd_m: float
    stops: int
    loses: int
    smoke_depth_m: float


_SONAR = _RingKind(3.0, radians(30.0), 0.03, WALL | GLASS, 0, inf)  # glass and smoke are nothing to sound
_INFRARED = _RingKind(0.8, radians(4.0), 0.02, WALL, GLASS, SMOKE_DEPTH_M)


class Ring:
    """Sonars and infrared sensors spread evenly round one robot, the first looking ahead."""

    def __init__(self, world: World, sonars: int, infrareds: int, rng: np.random.Generator) -> None:
        self._world = world
        self._counts = (sonars, infrareds)
        self._rng = rng

    def read(self, pose: Pose2, others_m: Array, radius_m: float) -> tuple[RangeReading, ...]:
        """Return one reading of each; a range at ``range_max_m`` means no echo."""
        sonars, infrareds = self._counts
        return tuple(
            [self._sonar(pose, 2.0 * pi * i / sonars, others_m, radius_m) for i in range(sonars)]
            + [self._infrared(pose, 2.0 * pi * i / infrareds, others_m, radius_m) for i in range(infrareds)]
        )

    def _sonar(self, pose: Pose2, bearing_rad: float, others_m: Array, radius_m: float) -> RangeReading:
        range_m = self._nearest(_SONAR, pose, bearing_rad, others_m, radius_m)
        return RangeReading("sonar", wrap(bearing_rad), range_m, _SONAR.range_max_m, _SONAR.cone_rad)

    def _infrared(self, pose: Pose2, bearing_rad: float, others_m: Array, radius_m: float) -> RangeReading:
        range_m = self._nearest(_INFRARED, pose, bearing_rad, others_m, radius_m)
        return RangeReading("infrared", wrap(bearing_rad), range_m, _INFRARED.range_max_m, _INFRARED.cone_rad)

    def _nearest(
        self, kind: _RingKind, pose: Pose2, bearing_rad: float, others_m: Array, radius_m: float
    ) -> float:
        angles = pose.theta + bearing_rad + kind.cone_rad * np.linspace(-0.5, 0.5, 7)
        ranges = cast(
            self._world,
            pose.x,
            pose.y,
            angles,
            kind.range_max_m,
            stops=kind.stops,
            loses=kind.loses,
            smoke_depth_m=kind.smoke_depth_m,
            discs_m=others_m,
            disc_radius_m=radius_m,
        )
        noisy = float(ranges.min()) + kind.sd_m * float(self._rng.standard_normal())
        return round(min(max(noisy, 0.02), kind.range_max_m), 3)


class ThermalCamera:
    """The thermal camera of one robot, looking ahead."""

    def __init__(self, world: World, config: HeatConfig, rng: np.random.Generator) -> None:
        self._world = world
        self._config = config
        self._rng = rng

    def look(self, pose: Pose2, victims_m: Array, dt_s: float) -> tuple[HeatReading, ...]:
        """Return what looks warm: victims, (v, 2), in the cone and in sight, and false alarms.

        A look draws the same number of random values whatever there is to see.
        """
        config = self._config
        draws = self._rng.random((len(victims_m) + 1, 3))
        noise = self._rng.standard_normal((len(victims_m), 2))
        readings = []
        for k, (x, y) in enumerate(victims_m):
            distance = hypot(x - pose.x, y - pose.y)
            bearing = wrap(atan2(y - pose.y, x - pose.x) - pose.theta)
            visible = 0.05 < distance <= config.range_max_m and abs(bearing) <= config.cone_rad / 2.0
            if not visible or draws[k, 0] >= config.detection:
                continue
            if in_sight(self._world, (pose.x, pose.y), (float(x), float(y))):
                range_m = max(0.05, distance * (1.0 + config.range_sd * float(noise[k, 0])))
                off = config.bearing_sd_rad * float(noise[k, 1])
                readings.append(HeatReading(wrap(bearing + off), range_m, 0.55 + 0.4 * float(draws[k, 1])))
        if draws[-1, 0] < config.false_alarms_per_s * dt_s:
            readings.append(self._false_alarm(pose, float(draws[-1, 1]), float(draws[-1, 2])))
        return tuple(readings)

    def _false_alarm(self, pose: Pose2, aside: float, away: float) -> HeatReading:
        """Return a warm thing that is no victim (a radiator, a lamp), never behind a wall; draws in 0..1."""
        bearing = self._config.cone_rad * (aside - 0.5)
        angle = np.array([pose.theta + bearing])
        reach = float(cast(self._world, pose.x, pose.y, angle, self._config.range_max_m, loses=0)[0])
        range_m = max(0.05, min(reach, self._config.range_max_m) * (0.3 + 0.7 * away))
        return HeatReading(bearing, range_m, 0.2 + 0.4 * away)


def others_near(poses: Array, index: int, reach_m: float) -> Array:
    """Return the positions, (k, 2), of the other robots within reach of one, of all poses (n, 3)."""
    near = np.hypot(poses[:, 0] - poses[index, 0], poses[:, 1] - poses[index, 1]) < reach_m
    near[index] = False
    return np.ascontiguousarray(poses[near, :2])
