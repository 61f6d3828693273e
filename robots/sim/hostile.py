"""What makes a world hostile: glass, bricks, smoke, ramps and slippery floor, strewn over any plan."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import cos, pi, sin

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from robots.sim.world import BRICK, GLASS, SMOKE, WALL, FloatGrid, Mask, World


@dataclass(frozen=True, slots=True)
class HostileConfig:
    """How many of each there are."""

    glass: int = 0  # stretches of wall, 1 to 3 m long
    bricks: int = 0  # below the laser's plane, 10 to 25 cm
    smoke: int = 0  # clouds 1.5 to 3 m across
    ramps: int = 0  # 1.5 to 3 m long, 6 to 15 degrees
    slippery: int = 0  # patches 0.8 to 2.5 m across that give 20 to 60 % of the motion
    spikes: int = 0  # of a thousand readings of a radio, 10 to 30 dB off
    dead_tags: int = 0  # of those in place: their radio never works,
    switched_tags: int = 0  # is off for a while,
    moved_tags: int = 0  # somebody carries them off,
    knocked_tags: int = 0  # or knocks them over
    twin_tags: int = 0  # more tags in place that bear the id of another
    fires: int = 0  # that start and grow; active nodes near them tell


def make_hostile(world: World, config: HostileConfig, rng: np.random.Generator) -> World:
    """Return the world with these obstacles added.

    Every kind has its own stream, so that one leaves the others alone.
    """
    glass, bricks, smoke, ramps, slippery = rng.spawn(5)
    world = _slippery(world, config.slippery, slippery)
    world = _ramps(world, config.ramps, ramps)
    cells = world.cells.copy()
    _glass(world, cells, config.glass, glass)
    _bricks(world, cells, config.bricks, bricks)
    for _ in range(config.smoke):
        cells[_cloud(world, smoke.uniform(0.75, 1.5), smoke) & world.free] |= SMOKE
    return World(cells, world.origin_m, world.resolution_m, world.grip, world.slope)


def _glass(world: World, cells: NDArray[np.uint8], count: int, rng: np.random.Generator) -> None:
    """Turn stretches of the walls' surface into glass, deep enough that no beam gets past its edge."""
    near = ndimage.distance_transform_edt(~world.free) * world.resolution_m <= 0.2
    surface = ~world.free & near & ((world.cells & WALL) > 0)
    rows, columns = np.nonzero(surface & (ndimage.binary_dilation(world.free)))
    if rows.size == 0:
        return
    for _ in range(count):
        pick = int(rng.integers(rows.size))
        stretch = _disc(world, int(rows[pick]), int(columns[pick]), rng.uniform(0.5, 1.5))
        cells[stretch & surface] = GLASS


def _bricks(world: World, cells: NDArray[np.uint8], count: int, rng: np.random.Generator) -> None:
    """Lay bricks where a body still gets past on both sides."""
    rows, columns = np.nonzero(world.clearance_m >= 0.9)
    if rows.size == 0:
        return
    for _ in range(count):
        pick = int(rng.integers(rows.size))
        cells[_disc(world, int(rows[pick]), int(columns[pick]), rng.uniform(0.05, 0.125)) & world.free] |= (
            BRICK
        )


def _ramps(world: World, count: int, rng: np.random.Generator) -> World:
    if count == 0:
        return world
    slope: FloatGrid = np.zeros((*world.cells.shape, 2), np.float32)
    for _ in range(count):
        steep, towards = np.tan(np.radians(rng.uniform(6.0, 15.0))), rng.uniform(0.0, 2.0 * pi)
        slope[_cloud(world, rng.uniform(0.75, 1.5), rng)] = (steep * cos(towards), steep * sin(towards))
    return replace(world, slope=slope)


def _slippery(world: World, count: int, rng: np.random.Generator) -> World:
    if count == 0:
        return world
    grip: FloatGrid = np.ones(world.cells.shape, np.float32)
    for _ in range(count):
        share = rng.uniform(0.2, 0.6)
        grip[_cloud(world, rng.uniform(0.4, 1.25), rng)] = share
    return replace(world, grip=grip)


def _cloud(world: World, radius_m: float, rng: np.random.Generator) -> Mask:
    """Return a disc round a random free cell, bool (h, w)."""
    rows, columns = np.nonzero(world.free)
    pick = int(rng.integers(rows.size))
    return _disc(world, int(rows[pick]), int(columns[pick]), radius_m)


def _disc(world: World, row: int, column: int, radius_m: float) -> Mask:
    rows, columns = world.cells.shape
    y, x = np.ogrid[:rows, :columns]
    radius = max(radius_m / world.resolution_m, 0.5)
    mask: Mask = (x - column) ** 2 + (y - row) ** 2 <= radius**2
    return mask
