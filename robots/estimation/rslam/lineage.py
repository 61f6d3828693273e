"""Where each particle has been, without a copy of its history: particles share the past they inherited."""

from __future__ import annotations

import numpy as np

from robots.graph_report import IntArray
from robots.se2 import Array, Pose2

_PRUNE_EVERY = 32  # poses


class Lineage:
    """Poses remembered, each with the pose remembered before it.

    Resampling makes most of the past common to all particles: that part is kept once, as the trunk.
    """

    def __init__(self, start: Pose2, particles: int) -> None:
        self._trunk = [start]
        self._layers: list[tuple[Array, IntArray]] = []  # poses (k, 3), their number in the layer before
        self._heirs = np.zeros(particles, np.int64)  # which pose of the newest layer is the particle's
        self._pruned = 0  # so many layers had nothing to forget when they were looked at last

    def __len__(self) -> int:
        return len(self._trunk) + len(self._layers)

    def resampled(self, ancestors: IntArray) -> None:
        """Let particle k stand where ``ancestors[k]`` stood."""
        self._heirs = self._heirs[ancestors]

    def add(self, poses: Array) -> None:
        """Remember where the particles are, (3, M)."""
        self._layers.append((poses.T.copy(), self._heirs))
        self._heirs = np.arange(poses.shape[1])
        if len(self) % _PRUNE_EVERY == 0:
            self._prune()

    def path(self, particle: int) -> list[Pose2]:
        """Return all poses of a particle, the first one first."""
        branch, at = [], int(self._heirs[particle])
        for poses, before in reversed(self._layers):
            branch.append(Pose2.from_array(poses[at]))
            at = int(before[at])
        return self._trunk + branch[::-1]

    def _prune(self) -> None:
        """Forget poses without heirs; what all have in common becomes trunk."""
        alive = self._heirs
        for number in range(len(self._layers) - 1, -1, -1):
            poses, before = self._layers[number]
            kept, places = np.unique(alive, return_inverse=True)
            if number + 1 == len(self._layers):
                self._heirs = places
            else:
                later, _ = self._layers[number + 1]
                self._layers[number + 1] = later, places
            if len(kept) == len(poses) and number < self._pruned:
                break
            self._layers[number] = poses[kept], before[kept]
            alive = before[kept]
        common = 0
        while common < len(self._layers) and len(self._layers[common][0]) == 1:
            self._trunk.append(Pose2.from_array(self._layers[common][0][0]))
            common += 1
        del self._layers[:common]
        self._pruned = len(self._layers)
