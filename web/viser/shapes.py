"""Small meshes the layers are built from, and the mathematics to place them."""

from __future__ import annotations

from math import atan2, cos, hypot, pi, sin, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float32]
Wxyz = tuple[float, float, float, float]


class Mesh(NamedTuple):
    """A triangle mesh: ``vertices`` (v, 3) in metres, ``faces`` (f, 3) counter-clockwise from outside."""

    vertices: Floats
    faces: NDArray[np.uint32]


def prism(outline: list[tuple[float, float]], height_m: float) -> Mesh:
    """Return a solid over a counter-clockwise outline, star-shaped from its mean, from z = 0 upwards."""
    n = len(outline)
    ring = np.array([(x, y, 0.0) for x, y in outline], np.float32)
    top = ring + np.array([0.0, 0.0, height_m], np.float32)
    centre = np.append(ring[:, :2].mean(axis=0), height_m).astype(np.float32)
    faces = []
    for i in range(n):
        j = (i + 1) % n
        faces += [(i, j, n + j), (i, n + j, n + i), (n + i, n + j, 2 * n)]
    return Mesh(np.vstack((ring, top, centre[None])), np.array(faces, np.uint32))


def unit_box() -> Mesh:
    """Return a box from (0, 0, 0) to (1, 1, 1) without its floor, to be scaled to a wall."""
    corners = np.array([(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)], np.float32)
    faces = [
        (4, 5, 7), (4, 7, 6),  # top
        (0, 1, 5), (0, 5, 4),  # y = 0
        (3, 2, 6), (3, 6, 7),  # y = 1
        (2, 0, 4), (2, 4, 6),  # x = 0
        (1, 3, 7), (1, 7, 5),  # x = 1
    ]  # fmt: skip
    return Mesh(corners, np.array(faces, np.uint32))


def unit_disc(sides: int = 40) -> Mesh:
    """Return a flat disc of radius 1 in the plane z = 0."""
    angles = np.linspace(0.0, 2.0 * pi, sides, endpoint=False)
    rim = np.stack((np.cos(angles), np.sin(angles), np.zeros(sides)), axis=1)
    faces = [(0, 1 + i, 1 + (i + 1) % sides) for i in range(sides)]
    return Mesh(np.vstack((np.zeros((1, 3)), rim)).astype(np.float32), np.array(faces, np.uint32))


def unit_ring(inner: float = 0.86, sides: int = 40) -> Mesh:
    """Return a flat ring of outer radius 1 in the plane z = 0."""
    angles = np.linspace(0.0, 2.0 * pi, sides, endpoint=False)
    rim = np.stack((np.cos(angles), np.sin(angles), np.zeros(sides)), axis=1)
    faces = []
    for i in range(sides):
        j = (i + 1) % sides
        faces += [(i, j, sides + j), (i, sides + j, sides + i)]
    return Mesh(np.vstack((rim, inner * rim)).astype(np.float32), np.array(faces, np.uint32))


def spike(radius_m: float, height_m: float, sides: int = 4) -> Mesh:
    """Return a pyramid that stands on its tip, at the origin."""
    angles = np.linspace(0.0, 2.0 * pi, sides, endpoint=False)
    rim = np.stack((radius_m * np.cos(angles), radius_m * np.sin(angles), np.full(sides, height_m)), axis=1)
    ends = np.array([(0.0, 0.0, 0.0), (0.0, 0.0, height_m)])
    faces = []
    for i in range(sides):
        j = (i + 1) % sides
        faces += [(i, sides, j), (i, j, sides + 1)]
    return Mesh(np.vstack((rim, ends)).astype(np.float32), np.array(faces, np.uint32))


def outline(corners_m: NDArray[np.floating], z_m: float) -> Floats:
    """Return the sides of an area as line segments (n, 2, 3), at one height; ``corners_m`` (n, 2)."""
    ring = np.column_stack((corners_m, np.full(len(corners_m), z_m))).astype(np.float32)
    return np.stack((ring, np.roll(ring, -1, axis=0)), axis=1)


def dashed(lines: Floats, dash_m: float = 0.6, gap_m: float = 0.35) -> Floats:
    """Return line segments (n, 2, 3) cut into at most 200 dashes each, one at either end."""
    cut = []
    for start, end in lines.astype(float):
        length_m = float(np.linalg.norm(end - start))
        dashes = min(200, max(1, round((length_m + gap_m) / (dash_m + gap_m))))
        unit = 1.0 / (dashes * dash_m + (dashes - 1) * gap_m)
        firsts = np.arange(dashes) * (dash_m + gap_m) * unit
        shares = np.stack((firsts, firsts + dash_m * unit), axis=1)
        cut.append(start + shares[..., None] * (end - start))
    return np.concatenate(cut).astype(np.float32)


def upright(count: int) -> Floats:
    """Return the quaternions (w, x, y, z) of that many unturned instances, shape (count, 4)."""
    return np.tile(np.array([1.0, 0.0, 0.0, 0.0], np.float32), (count, 1))


def turn_z(angle_rad: float) -> Wxyz:
    """Return the quaternion (w, x, y, z) of a turn about the vertical."""
    return cos(angle_rad / 2.0), 0.0, 0.0, sin(angle_rad / 2.0)


class Ellipse(NamedTuple):
    """A 2-sigma ellipse: half axes in metres and the direction of the longer one from x."""

    major_m: float
    minor_m: float
    angle_rad: float


def ellipse(xx: float, xy: float, yy: float) -> Ellipse:
    """Return the 2-sigma ellipse of a position's covariance, given by its elements in square metres."""
    mean, spread = (xx + yy) / 2.0, hypot((xx - yy) / 2.0, xy)
    return Ellipse(
        2.0 * sqrt(max(0.0, mean + spread)),
        2.0 * sqrt(max(0.0, mean - spread)),
        0.5 * atan2(2.0 * xy, xx - yy),
    )
