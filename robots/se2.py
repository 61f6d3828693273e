"""Planar poses (the group SE(2)) and how covariance travels through their composition.

Frames stand in names: ``world_from_base @ base_from_laser = world_from_laser``, adjacent frames cancel.
Angles are counter-clockwise radians in (-pi, pi]. Covariances are (3, 3) in the order x, y, theta, additive
on the components of the pose in its parent frame, as in Kleiner 2006 eq. (2).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, hypot, pi, sin
from typing import Self

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_SMALL_ANGLE = 1e-5  # below it sin(t)/t and (1-cos(t))/t come from their series: error under 1e-21


def wrap(angle_rad: float) -> float:
    """Return the angle in (-pi, pi]."""
    wrapped = (angle_rad + pi) % (2.0 * pi) - pi
    return pi if wrapped == -pi else wrapped


def wrap_array(angles_rad: Array) -> Array:
    """Return the angles, shape (n,), in (-pi, pi]."""
    wrapped = (angles_rad + pi) % (2.0 * pi) - pi
    return np.where(wrapped == -pi, pi, wrapped)


@dataclass(frozen=True, slots=True)
class Pose2:
    """A pose in the plane: position x, y in metres and heading theta in radians, in a parent frame."""

    x: float = 0.0
    y: float = 0.0
    theta: float = 0.0

    def __matmul__(self, other: Pose2) -> Pose2:
        """Compose: ``a_from_b @ b_from_c = a_from_c``."""
        c, s = cos(self.theta), sin(self.theta)
        return Pose2(
            self.x + c * other.x - s * other.y,
            self.y + s * other.x + c * other.y,
            wrap(self.theta + other.theta),
        )

    def inverse(self) -> Pose2:
        """Return ``b_from_a`` of ``a_from_b``."""
        c, s = cos(self.theta), sin(self.theta)
        return Pose2(-c * self.x - s * self.y, s * self.x - c * self.y, wrap(-self.theta))

    def between(self, other: Pose2) -> Pose2:
        """Return ``self.inverse() @ other``: the other pose seen from this one."""
        c, s = cos(self.theta), sin(self.theta)
        dx, dy = other.x - self.x, other.y - self.y
        return Pose2(c * dx + s * dy, -s * dx + c * dy, wrap(other.theta - self.theta))

    def transform(self, points: Array) -> Array:
        """Map points, shape (n, 2) in metres, from this pose's frame to its parent frame."""
        c, s = cos(self.theta), sin(self.theta)
        rotation = np.array([[c, s], [-s, c]])
        moved: Array = np.asarray(points, dtype=np.float64) @ rotation + (self.x, self.y)
        return moved

    def transform_point(self, x: float, y: float) -> tuple[float, float]:
        """Map one point in metres from this pose's frame to its parent frame."""
        c, s = cos(self.theta), sin(self.theta)
        return self.x + c * x - s * y, self.y + s * x + c * y

    def distance(self, other: Pose2) -> float:
        """Return the distance between the two positions in metres."""
        return hypot(other.x - self.x, other.y - self.y)

    def log(self) -> Array:
        """Return the twist (vx, vy, omega), shape (3,), whose ``exp`` is this pose."""
        t = self.theta
        if abs(t) < _SMALL_ANGLE:
            a, b = 1.0 - t * t / 6.0, t / 2.0
        else:
            a, b = sin(t) / t, (1.0 - cos(t)) / t
        n = a * a + b * b
        return np.array([(a * self.x + b * self.y) / n, (a * self.y - b * self.x) / n, t])

    @classmethod
    def exp(cls, twist: Array) -> Self:
        """Return the pose reached by following the twist (vx, vy, omega), shape (3,), for unit time."""
        vx, vy, t = float(twist[0]), float(twist[1]), float(twist[2])
        if abs(t) < _SMALL_ANGLE:
            a, b = 1.0 - t * t / 6.0, t / 2.0
        else:
            a, b = sin(t) / t, (1.0 - cos(t)) / t
        return cls(a * vx - b * vy, b * vx + a * vy, wrap(t))

    def as_array(self) -> Array:
        """Return (x, y, theta), shape (3,)."""
        return np.array([self.x, self.y, self.theta])

    @classmethod
    def from_array(cls, values: Array) -> Self:
        """Return the pose of (x, y, theta), shape (3,); theta is wrapped."""
        return cls(float(values[0]), float(values[1]), wrap(float(values[2])))


def compose_jacobians(a_from_b: Pose2, b_from_c: Pose2) -> tuple[Array, Array]:
    """Return the Jacobians, each (3, 3), of ``a_from_b @ b_from_c`` by its first and by its second pose."""
    c, s = cos(a_from_b.theta), sin(a_from_b.theta)
    by_first = np.eye(3)
    by_first[0, 2] = -s * b_from_c.x - c * b_from_c.y
    by_first[1, 2] = c * b_from_c.x - s * b_from_c.y
    by_second = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return by_first, by_second


@dataclass(frozen=True, slots=True, eq=False)
class GaussianPose:
    """A pose with its uncertainty, both in the parent frame.

    ``mean``, and ``covariance`` (3, 3) in the order x, y, theta.
    """

    mean: Pose2
    covariance: Array

    @classmethod
    def exact(cls, mean: Pose2 | None = None) -> Self:
        """Return a pose that is known exactly; the origin by default."""
        return cls(mean or Pose2(), np.zeros((3, 3)))

    def __matmul__(self, other: GaussianPose) -> GaussianPose:
        """Compose two independent uncertain poses to first order (Smith, Self and Cheeseman)."""
        by_first, by_second = compose_jacobians(self.mean, other.mean)
        covariance = by_first @ self.covariance @ by_first.T + by_second @ other.covariance @ by_second.T
        return GaussianPose(self.mean @ other.mean, (covariance + covariance.T) / 2.0)
