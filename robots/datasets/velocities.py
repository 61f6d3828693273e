"""Dead reckoning from commanded velocities: exact arcs between any two instants."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robots.se2 import Array


@dataclass(frozen=True, slots=True, eq=False)
class HeldVelocities:
    """Velocities held from one stamp to the next, none longer than ``hold_s``; then the robot stands.

    ``stamps_s`` (n,) never falling, ``linear_mps`` (n,), ``angular_radps`` (n,), one sample or more.
    """

    stamps_s: Array
    linear_mps: Array
    angular_radps: Array
    hold_s: float

    def poses(self, times_s: Array) -> Array:
        """Return the pose at each time, (k, 3), in the frame of the pose at the first stamp."""
        held_s = np.minimum(np.diff(self.stamps_s, append=np.inf), self.hold_s)
        starts = np.zeros((len(self.stamps_s), 3))
        ends = self._moved(np.arange(len(self.stamps_s)), held_s)
        starts[1:, 2] = np.cumsum(ends[:-1, 2])
        starts[1:, :2] = np.cumsum(_turned(ends[:-1, :2], starts[:-1, 2]), axis=0)
        sample = np.clip(np.searchsorted(self.stamps_s, times_s, side="right") - 1, 0, None)
        since_s = np.clip(times_s - self.stamps_s[sample], 0.0, held_s[sample])
        moved = self._moved(sample, since_s)
        start = starts[sample]
        return np.column_stack([start[:, :2] + _turned(moved[:, :2], start[:, 2]), start[:, 2] + moved[:, 2]])

    def _moved(self, sample: NDArray[np.int64], held_s: Array) -> Array:
        """Return the motion under the velocities of each sample held for so long: an arc, (k, 3)."""
        turn = self.angular_radps[sample] * held_s
        chord = self.linear_mps[sample] * held_s * np.sinc(turn / (2.0 * np.pi))  # of the arc
        return np.column_stack([chord * np.cos(turn / 2.0), chord * np.sin(turn / 2.0), turn])


def displacements(poses: Array) -> Array:
    """Return each pose in the frame of the one before it, (n, 3); zero for the first."""
    moved = np.diff(poses, axis=0, prepend=poses[:1])
    headings = np.concatenate([poses[:1, 2], poses[:-1, 2]])
    return np.column_stack([_turned(moved[:, :2], -headings), moved[:, 2]])


def _turned(points: Array, angles: Array) -> Array:
    c, s = np.cos(angles), np.sin(angles)
    return np.column_stack([c * points[:, 0] - s * points[:, 1], s * points[:, 0] + c * points[:, 1]])
