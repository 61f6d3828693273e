"""Pairs of laser scans in buildings, with the true displacement: what matchers are measured on."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import cos, inf, pi, radians, sin
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from robots.se2 import Array, Pose2
from robots.sim.generate import generate
from robots.sim.map_files import load_map
from robots.sim.rays import cast
from robots.sim.world import World
from robots.types import FloatArray32, LaserScan

BEAMS = 360
_CLEARANCE_M = 0.3  # a robot fits
_NEAREST_M, _HITS = 0.3, 80  # something to see: so many beams that come back
_SDS_M = (0.01, 0.02, 0.03)
_REACHES_M = (4.0, 8.0, 12.0, 30.0)


@dataclass(frozen=True, slots=True, eq=False)
class ScanPair:
    """Two scans, the second one's pose seen from the first, and a guess of it that is off."""

    building: str
    reference: LaserScan
    scan: LaserScan
    true: Pose2
    guess: Pose2


def buildings(folder: Path | None) -> dict[str, World]:
    """Return the map_server maps of a folder by name; generated offices and a hall without one."""
    if folder is not None:
        return {path.stem: load_map(path) for path in sorted(folder.glob("*.yaml"))}
    kinds = (("office", 300.0), ("office", 590.0), ("office", 1275.0), ("open", 600.0))
    return {
        f"{kind}:{area:g}": generate(kind, area, np.random.default_rng(seed))
        for seed, (kind, area) in enumerate(kinds)
    }


def pairs(worlds: dict[str, World], count: int, seed: int) -> Iterator[ScanPair]:
    """Yield ``count`` pairs of each building.

    8 cm and 8 degrees apart, the guess off by up to 10 cm and 5 degrees, in every direction alike; noise of
    1, 2 and 3 cm and a reach of 4, 8, 12 and 30 m take turns.
    """
    for number, (name, world) in enumerate(worlds.items()):
        rng = np.random.default_rng((seed, number))
        free = np.argwhere(world.clearance_m > _CLEARANCE_M)
        for k in range(count):
            sd_m, reach_m = _SDS_M[k % 3], _REACHES_M[k // 3 % 4]
            while True:
                first = _somewhere(world, free, rng)
                apart = _polar(0.08, rng, radians(8.0) * rng.choice([-1.0, 1.0]))
                second = first @ apart
                scans = [_sweep(world, pose, sd_m, reach_m, rng) for pose in (first, second)]
                if world.clearance_m[world.cell(second.x, second.y)] > 0.0 and all(map(_says_much, scans)):
                    break
            off = _polar(rng.uniform(0.0, 0.10), rng, rng.uniform(-1.0, 1.0) * radians(5.0))
            guess = Pose2(apart.x + off.x, apart.y + off.y, apart.theta + off.theta)
            yield ScanPair(name, scans[0], scans[1], apart, guess)


def _polar(distance_m: float, rng: np.random.Generator, theta: float) -> Pose2:
    direction = rng.uniform(-pi, pi)
    return Pose2(distance_m * cos(direction), distance_m * sin(direction), float(theta))


def _somewhere(world: World, free: NDArray[np.int64], rng: np.random.Generator) -> Pose2:
    x, y = world.centre(*free[rng.integers(len(free))])
    dx, dy = rng.uniform(-0.5, 0.5, 2) * world.resolution_m
    return Pose2(x + dx, y + dy, float(rng.uniform(-pi, pi)))


def _sweep(world: World, pose: Pose2, sd_m: float, reach_m: float, rng: np.random.Generator) -> LaserScan:
    increment = 2.0 * pi / BEAMS
    angles: Array = np.arange(BEAMS, dtype=np.float64) * increment - pi
    exact = cast(world, pose.x, pose.y, angles + pose.theta, reach_m)
    noisy = np.maximum(exact + sd_m * rng.standard_normal(BEAMS), 0.05)
    ranges: FloatArray32 = np.where(noisy < reach_m, noisy, inf).astype(np.float32)
    return LaserScan(ranges, -pi, increment, reach_m)


def _says_much(scan: LaserScan) -> bool:
    seen = np.isfinite(scan.ranges_m)
    return bool(seen.sum() >= _HITS and scan.ranges_m.min() > _NEAREST_M)
