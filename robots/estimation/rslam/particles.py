"""Particles: poses with weights, moved by noisy displacements and resampled by their weights."""

from __future__ import annotations

from math import atan2, cos, exp, pi, sin

import numpy as np
from numba import njit

from robots.graph_report import IntArray
from robots.se2 import Array, GaussianPose, Pose2


class Particles:
    """M poses of the robot in the map frame with normalised weights.

    ``poses`` (3, M); ``weights`` (M,), which sum to 1.
    """

    def __init__(self, start: Pose2, count: int, seed: tuple[int, ...]) -> None:
        self.poses = np.repeat(start.as_array()[:, None], count, axis=1)
        self.weights = np.full(count, 1.0 / count)
        self._log_weights = np.zeros(count)
        self._generator = np.random.default_rng(seed)
        self._belief: GaussianPose | None = None

    @property
    def count(self) -> int:
        """How many there are."""
        return len(self.weights)

    @property
    def effective(self) -> float:
        """The effective sample size 1 / sum w^2."""
        return float(1.0 / (self.weights @ self.weights))

    @property
    def best(self) -> int:
        """The particle with the greatest weight."""
        return int(np.argmax(self.weights))

    @property
    def belief(self) -> GaussianPose:
        """Weighted mean and covariance; headings are averaged on the circle."""
        if self._belief is None:
            mean, covariance = _moments(self.poses, self.weights)
            self._belief = GaussianPose(Pose2.from_array(mean), covariance)
        return self._belief

    def normal(self, *shape: int) -> Array:
        """Draw from the particles' own generator, which is the only source of chance here."""
        return self._generator.standard_normal(shape)

    def move(self, moved: GaussianPose) -> None:
        """Move each particle by a displacement of its own, drawn about the measured one."""
        values, vectors = np.linalg.eigh(moved.covariance)
        root = vectors * np.sqrt(np.maximum(values, 0.0))
        _move(self.poses, moved.mean.as_array(), root, self.normal(3, self.count))
        self._belief = None

    def weigh(self, log_likelihoods: Array) -> None:
        """Multiply the weights by likelihoods, (M,), given as logarithms that are all finite."""
        _weigh(self._log_weights, log_likelihoods, self.weights)
        self._belief = None

    def resample(self) -> IntArray:
        """Draw particles by their weights with low variance; return whom each one descends from.

        Whoever is drawn stays in place, so only the others have to be copied.
        """
        ancestors: IntArray = _systematic(self.weights, float(self._generator.uniform()))
        copy_columns(self.poses, ancestors)
        self.weights[:] = 1.0 / self.count
        self._log_weights[:] = 0.0
        self._belief = None
        return ancestors


@njit(cache=True)
def copy_columns(rows: Array, ancestors: IntArray) -> None:
    """Let column k of (r, M) be what ``ancestors[k]`` was; ancestors stand in columns of their own."""
    for p in range(len(ancestors)):
        q = ancestors[p]
        if q != p:
            for r in range(rows.shape[0]):
                rows[r, p] = rows[r, q]


@njit(cache=True)
def _move(poses: Array, moved: Array, root: Array, noise: Array) -> None:
    for p in range(poses.shape[1]):
        a, b, e = noise[0, p], noise[1, p], noise[2, p]
        x = moved[0] + root[0, 0] * a + root[0, 1] * b + root[0, 2] * e
        y = moved[1] + root[1, 0] * a + root[1, 1] * b + root[1, 2] * e
        turn = moved[2] + root[2, 0] * a + root[2, 1] * b + root[2, 2] * e
        c, s = cos(poses[2, p]), sin(poses[2, p])
        poses[0, p] += c * x - s * y
        poses[1, p] += s * x + c * y
        poses[2, p] = (poses[2, p] + turn + pi) % (2.0 * pi) - pi


@njit(cache=True)
def _weigh(log_weights: Array, more: Array, weights: Array) -> None:
    top = -np.inf
    for p in range(len(more)):
        log_weights[p] += more[p]
        top = max(top, log_weights[p])
    total = 0.0
    for p in range(len(more)):
        log_weights[p] -= top
        weights[p] = exp(log_weights[p])
        total += weights[p]
    for p in range(len(more)):
        weights[p] /= total


@njit(cache=True)
def _systematic(weights: Array, start: float) -> IntArray:
    count = len(weights)
    copies = np.zeros(count, np.int64)
    reached, at = weights[0], 0
    for k in range(count):
        wanted = (start + k) / count
        while reached < wanted and at < count - 1:
            at += 1
            reached += weights[at]
        copies[at] += 1
    ancestors = np.empty(count, np.int64)
    giver = 0
    for p in range(count):
        if copies[p] > 0:
            ancestors[p] = p
    for p in range(count):
        if copies[p] == 0:
            while copies[giver] < 2:
                giver += 1
            copies[giver] -= 1
            ancestors[p] = giver
    return ancestors


@njit(cache=True)
def _moments(poses: Array, weights: Array) -> tuple[Array, Array]:
    mean, covariance = np.zeros(3), np.zeros((3, 3))
    c = s = 0.0
    for p in range(len(weights)):
        mean[0] += weights[p] * poses[0, p]
        mean[1] += weights[p] * poses[1, p]
        c += weights[p] * cos(poses[2, p])
        s += weights[p] * sin(poses[2, p])
    mean[2] = atan2(s, c)
    off = np.empty(3)
    for p in range(len(weights)):
        off[0], off[1] = poses[0, p] - mean[0], poses[1, p] - mean[1]
        off[2] = (poses[2, p] - mean[2] + pi) % (2.0 * pi) - pi
        for i in range(3):
            for j in range(3):
                covariance[i, j] += weights[p] * off[i] * off[j]
    return mean, covariance
