"""Four-wheel skid-steer bodies: how commands become motion, and what stops them.

Kinematics: speed and turn rate change only at the start of a tick, within the acceleration limits, and stay
constant during it. A tick is therefore one exact arc, and wheels that roll ``distance -+ turn * track / 2``
without noise integrate to the true path by ``Pose2.exp((d, 0, alpha))``. Inside the tick the arc is walked in
small steps for collisions (a disc; it slides along what it meets) and for tags under the antenna.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, cos, floor, hypot, pi, sin, sqrt

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robots.config import AntennaConfig, BodyConfig
from robots.se2 import Array, Pose2
from robots.sim.world import SOLID, Cells, FloatGrid, World

Marks = NDArray[np.uint8]

ACCELERATION_MPS2 = 1.0
TURN_ACCELERATION_RADPS2 = 2.0 * pi
_STEP_M = 0.008  # at most so far between two looks for walls and tags


@njit(cache=True)
def _deepest(
    cells: Cells,
    distance: FloatGrid,
    origin: tuple[float, float],
    resolution: float,
    x: float,
    y: float,
    radius: float,
    poses: Array,
    me: int,
) -> tuple[float, float, float]:
    """Return (depth in metres, normal x, normal y) of the deepest overlap with walls and other robots."""
    rows, columns = cells.shape
    gx, gy = (x - origin[0]) / resolution, (y - origin[1]) / resolution
    column, row = floor(gx), floor(gy)
    depth, nx, ny = 0.0, 0.0, 0.0
    if row < 0 or column < 0 or row >= rows or column >= columns:
        return radius, 0.0, 0.0
    r = radius / resolution
    if distance[row, column] - 1.4143 < r:  # else even the nearest solid cell's corner is out of reach
        for j in range(max(0, floor(gy - r)), min(rows, floor(gy + r) + 1)):
            for i in range(max(0, floor(gx - r)), min(columns, floor(gx + r) + 1)):
                if cells[j, i] & SOLID:
                    dx, dy = gx - min(max(gx, i), i + 1.0), gy - min(max(gy, j), j + 1.0)
                    gap = sqrt(dx * dx + dy * dy)
                    if r - gap > depth:
                        depth = r - gap
                        nx, ny = (dx / gap, dy / gap) if gap > 0.0 else (0.0, 0.0)
        depth *= resolution
    for k in range(poses.shape[0]):
        if k != me:
            dx, dy = x - poses[k, 0], y - poses[k, 1]
            gap = sqrt(dx * dx + dy * dy)
            if 2.0 * radius - gap > depth:
                depth = 2.0 * radius - gap
                nx, ny = (dx / gap, dy / gap) if gap > 0.0 else (0.0, 0.0)
    return depth, nx, ny


@njit(cache=True)
def _advance(
    cells: Cells,
    distance: FloatGrid,
    origin: tuple[float, float],
    resolution: float,
    grip: FloatGrid,
    poses: Array,
    velocities: Array,
    radius: float,
    antenna: tuple[float, float, float, float],
    tags: Array,
    dt: float,
    steps: int,
    moved: Array,
    pressed: Marks,
    read: Marks,
) -> None:
    """Move all bodies by one tick.

    Writes ``poses``, ``moved`` (n, 2: driven metres, mean grip), ``pressed`` (n,) and ``read`` (n, m).
    """
    h = dt / steps
    for i in range(poses.shape[0]):
        moved[i, 0] = 0.0
        moved[i, 1] = 0.0
        pressed[i] = 0
        for t in range(tags.shape[0]):
            read[i, t] = 0
    for _ in range(steps):
        for i in range(poses.shape[0]):
            x, y, theta = poses[i]
            hold = 1.0
            if grip.size > 0:
                row, column = (
                    floor((y - origin[1]) / resolution),
                    floor((x - origin[0]) / resolution),
                )
                hold = grip[row, column]
            moved[i, 1] += hold / steps
            d, a = velocities[i, 0] * h * hold, velocities[i, 1] * h * hold
            if abs(a) < 1e-9:
                along, aside = d, 0.5 * d * a
            else:
                along, aside = d * sin(a) / a, d * (1.0 - cos(a)) / a
            c, s = cos(theta), sin(theta)
            to_x, to_y = x + c * along - s * aside, y + s * along + c * aside
            fits = d == 0.0
            for _attempt in range(6):
                if fits:
                    break
                depth, nx, ny = _deepest(cells, distance, origin, resolution, to_x, to_y, radius, poses, i)
                if depth <= 0.0:
                    fits = True
                    break
                pressed[i] = 1
                if nx == 0.0 and ny == 0.0:
                    break
                to_x += nx * (depth + 1e-9)
                to_y += ny * (depth + 1e-9)
            if fits:
                moved[i, 0] += hypot(to_x - x, to_y - y)
                poses[i, 0], poses[i, 1] = to_x, to_y
            theta += a
            poses[i, 2] = theta - 2.0 * pi * ceil((theta - pi) / (2.0 * pi))
            c, s = cos(theta), sin(theta)
            for t in range(tags.shape[0]):
                dx, dy = tags[t, 0] - poses[i, 0], tags[t, 1] - poses[i, 1]
                ahead, left = c * dx + s * dy - antenna[0], -s * dx + c * dy
                if antenna[3] > 0.0:
                    under = ahead * ahead + left * left <= antenna[3] * antenna[3]
                else:
                    under = abs(ahead) <= antenna[1] / 2.0 and abs(left) <= antenna[2] / 2.0
                if under:
                    read[i, t] = 1


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """What one tick did to each of n robots and m tags.

    ``speeds`` (n, 2) speed and turn rate the wheels ran at; ``driven_m`` (n,) true distance; ``grip`` (n,)
    mean share of the motion the floor gave; ``pressed`` (n,) against something; ``read`` (n, m) tags that
    came under the antenna.
    """

    speeds: Array
    driven_m: Array
    grip: Array
    pressed: NDArray[np.bool_]
    read: NDArray[np.bool_]


class Bodies:
    """The bodies of a team: true poses (n, 3) in the world frame and velocities (n, 2)."""

    def __init__(self, world: World, poses: Array, body: BodyConfig, antenna: AntennaConfig) -> None:
        self._world = world
        self._body = body
        self._antenna = (
            float(antenna.ahead_m),
            float(antenna.along_m),
            float(antenna.across_m),
            float(antenna.radius_m or 0.0),
        )
        self._grip = world.grip if world.grip is not None else np.zeros((0, 0), np.float32)
        self.poses = np.array(poses, dtype=np.float64)
        self.velocities = np.zeros((len(poses), 2))
        reach = abs(antenna.ahead_m) + hypot(antenna.along_m, antenna.across_m) / 2.0
        self._fastest_mps = body.max_speed_mps + body.max_turn_radps * reach
        footprint = (
            2.0 * antenna.radius_m if antenna.radius_m is not None else min(antenna.along_m, antenna.across_m)
        )
        self._step_m = min(_STEP_M, footprint / 3.0)  # a tag cannot slip through between two looks

    def pose(self, index: int) -> Pose2:
        """Return the true pose of one robot in the world frame."""
        return Pose2.from_array(self.poses[index])

    def tick(self, commands: Array, tags_m: Array, dt_s: float) -> Motion:
        """Move everybody for one tick towards the commands, (n, 2), over the tags at ``tags_m``, (m, 2)."""
        wanted = np.clip(
            commands,
            (-self._body.max_speed_mps, -self._body.max_turn_radps),
            (self._body.max_speed_mps, self._body.max_turn_radps),
        )
        limit = np.array([ACCELERATION_MPS2, TURN_ACCELERATION_RADPS2]) * dt_s
        self.velocities += np.clip(wanted - self.velocities, -limit, limit)
        n = len(self.poses)
        moved, pressed = np.empty((n, 2)), np.empty(n, np.uint8)
        read = np.empty((n, len(tags_m)), np.uint8)
        _advance(
            self._world.cells,
            self._world.distance_cells,
            self._world.origin_m,
            self._world.resolution_m,
            self._grip,
            self.poses,
            self.velocities,
            self._body.radius_m,
            self._antenna,
            tags_m,
            dt_s,
            max(2, ceil(self._fastest_mps * dt_s / self._step_m)),
            moved,
            pressed,
            read,
        )
        return Motion(self.velocities.copy(), moved[:, 0], moved[:, 1], pressed.view(bool), read.view(bool))


def inside_solid(world: World, x_m: float, y_m: float, radius_m: float) -> bool:
    """Return whether a disc overlaps anything solid by more than a rounding error."""
    nobody = np.zeros((0, 3))
    depth, _, _ = _deepest(
        world.cells, world.distance_cells, world.origin_m, world.resolution_m, x_m, y_m, radius_m, nobody, -1
    )
    return bool(depth > 1e-6)
