"""The state of the EKF: pose and tags (Ziparo 2007 eq. 2 and 3), near tags exact, far ones when they matter.

A sighting of a near tag changes what is known of all others, but until a far one is seen, only the sum of
those changes matters: it is gathered in the size of the near part and brought to the far tags when the near
ones are chosen anew (Guivant and Nebot 2001, compressed EKF). The result is that of the full filter, but for
the point at which far tags are linearised.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import cos, sin

import numpy as np

from robots.estimation.ekf import kernels
from robots.estimation.ekf.kernels import HEAD
from robots.estimation.radio.cones import Expected
from robots.se2 import Array, GaussianPose, Pose2, wrap

MOST_NEAR = 64  # tags; beyond, those nearest to the robot are kept near
_KEPT_NEAR = 40
_SQRT2 = np.sqrt(2.0)
_NOUGHT = 1e-14  # of the greatest eigenvalue: rounding
_QUARTER = np.array([[0.0, -1.0], [1.0, 0.0]])  # J: turns by 90 degrees


class TagState:
    """Gaussian belief of pose and tags in the map frame, with the invariant error of ``ekf_kernels``."""

    def __init__(self, start: Pose2, most_near: int = MOST_NEAR) -> None:
        self._most_near = most_near
        self._near: dict[str, int] = {}  # index in mean and cov
        self._far: dict[str, int] = {}
        size = HEAD + 2 * most_near
        self._mean, self._cov = np.zeros(size), np.zeros((size, size))
        self._mean[:3] = start.theta, start.x, start.y
        self._kept = np.zeros((size, 0))
        self._set_far(np.zeros(0), np.zeros((0, 0)), np.zeros((HEAD, 0)))

    @property
    def belief(self) -> GaussianPose:
        """The robot's pose."""
        m = self._mean
        by_error = np.array([[-m[2], 1.0, 0.0], [m[1], 0.0, 1.0], [1.0, 0.0, 0.0]])
        return GaussianPose(Pose2(m[1], m[2], m[0]), by_error @ self._cov[:3, :3] @ by_error.T)

    @property
    def tag_ids(self) -> list[str]:
        """All tags whose place is known."""
        return [*self._near, *self._far]

    def __contains__(self, tag_id: str) -> bool:
        return tag_id in self._near or tag_id in self._far

    def copy(self) -> TagState:
        """Return an independent copy."""
        other = TagState(Pose2(), self._most_near)
        other._near, other._far = dict(self._near), dict(self._far)
        other._mean, other._cov = self._mean.copy(), self._cov.copy()
        other._far_mean, other._far_cov = self._far_mean, self._far_cov  # never changed in place
        other._cross, other._spreads = self._cross, self._spreads
        other._kept, other._told = self._kept.copy(), self._told.copy()
        other._moved, other._turn_rad = self._moved.copy(), self._turn_rad
        return other

    def move(self, step: GaussianPose) -> None:
        """Move by a displacement in the frame of the pose before, with covariance (eq. 4)."""
        mean = step.mean
        moved = np.array([mean.x, mean.y, mean.theta])
        kernels.move(self._mean, self._cov, self._size, moved, step.covariance, bool(self._far))

    def expect(self, tag_id: str, antenna: Array) -> Expected:
        """Return at which range and bearing a known tag is expected."""
        return Expected(*kernels.expected_spread(self._mean, self._cov, self._near_index(tag_id), antenna))

    def see(self, tag_id: str, antenna: Array, seen: Array, thin: float, gate: float) -> float:
        """Correct by a sighting of a known tag; see ``ekf_kernels.see``. Returns its squared innovation."""
        tag = self._near_index(tag_id)
        distance, turn = kernels.see(
            self._mean,
            self._cov,
            self._size,
            tag,
            antenna,
            seen,
            thin,
            gate,
            self._kept,
            self._told,
            self._moved,
        )
        self._turn_rad += turn
        return float(distance)

    def see_heading(self, heading_rad: float, sd_rad: float) -> None:
        """Correct by a compass."""
        off = wrap(heading_rad - self._mean[0])
        self._turn_rad += kernels.see_heading(
            self._mean, self._cov, self._size, off, sd_rad**2, self._kept, self._told, self._moved
        )

    def add(self, tag_id: str, place_m: tuple[float, float], spread: Array) -> None:
        """Add a tag at a place in the base frame, covariance (2, 2), seen from the pose as it is now."""
        if self._size == len(self._mean):
            self._choose_near(())
        m, n = self._mean, self._size
        c, s = cos(m[0]), sin(m[0])
        turned = np.array([[c, -s], [s, c]])
        m[n : n + 2] = m[1:3] + turned @ place_m
        # the place turns with the heading as the position does, so its error is that of the position
        self._cov[n : n + 2, :n] = self._cov[1:3, :n]
        self._cov[:n, n : n + 2] = self._cov[:n, 1:3]
        own = self._cov[1:3, 1:3] + turned @ spread @ turned.T
        self._cov[n : n + 2, n : n + 2] = (own + own.T) / 2.0
        if self._far:
            self._kept = np.vstack([self._kept, self._kept[1:3]])
        self._near[tag_id] = n

    def forget(self, tag_id: str) -> None:
        """Leave a tag out, and keep what it told of the others."""
        mean, cov = self.whole()
        names = self.tag_ids
        at = HEAD + 2 * names.index(tag_id)
        names.remove(tag_id)
        rest = np.delete(np.arange(len(mean)), [at, at + 1])
        self.set_whole(names, mean[rest], cov[np.ix_(rest, rest)])

    def place(self, tag_id: str) -> tuple[Array, Array]:
        """Return a tag's place (2,) and its covariance (2, 2); of a far one as when it was put aside."""
        far = self._far.get(tag_id)
        if far is not None:
            return self._far_mean[far : far + 2], self._spreads[far // 2]
        at = self._near[tag_id]
        return self._mean[at : at + 2], _spread(self._mean, self._cov, at)

    def whole(self) -> tuple[Array, Array]:
        """Return mean and covariance of all, far tags brought up to date, in the order of ``tag_ids``."""
        n, far = self._size, 2 * len(self._far)
        mean, cov = np.empty(n + far), np.empty((n + far, n + far))
        mean[:n], cov[:n, :n] = self._mean[:n], self._cov[:n, :n]
        if not far:
            return mean, cov
        cross = self._cross
        by_turned = -(self._far_mean.reshape(-1, 2) @ _QUARTER.T).ravel()
        shift = cross.T @ self._moved + by_turned * mean[3]
        mean[n:] = _retracted(self._far_mean, self._turn_rad, shift)
        joint = self._kept @ cross + np.outer(cov[:n, 3], by_turned)
        cov[:n, n:], cov[n:, :n] = joint, joint.T
        values, vectors = np.linalg.eigh(self._told)
        matter = values > _NOUGHT * values[-1]
        root = (vectors[:, matter] * np.sqrt(values[matter])).T @ cross
        # what turned with the far tags goes with them as they were: u v' + v u' is a difference of squares
        along = self._kept[3] @ cross + 0.5 * cov[3, 3] * by_turned
        less = np.vstack([root, (along - by_turned) / _SQRT2])
        more = (along + by_turned) / _SQRT2
        own = cov[n:, n:]
        np.subtract(self._far_cov, less.T @ less, out=own)
        own += np.outer(more, more)
        return mean, cov

    def set_whole(self, names: Sequence[str], mean: Array, cov: Array, wanted: Iterable[str] = ()) -> None:
        """Take the state of all, as ``whole`` gives it; ``wanted`` tags count as near the robot."""
        count = len(names)
        places = mean[HEAD:].reshape(-1, 2)
        away = np.hypot(places[:, 0] - mean[1], places[:, 1] - mean[2])
        known = {name: k for k, name in enumerate(names)}
        away[[known[name] for name in wanted]] = -1.0
        kept = count if count < self._most_near else min(_KEPT_NEAR, self._most_near // 2)
        order = np.argsort(away, kind="stable")
        near, far = np.sort(order[:kept]), np.sort(order[kept:])
        head = np.arange(HEAD)
        a = np.concatenate([head, (HEAD + 2 * near[:, None] + (0, 1)).ravel()]).astype(np.int64)
        b = (HEAD + 2 * far[:, None] + (0, 1)).ravel().astype(np.int64)
        self._near = {names[k]: HEAD + 2 * i for i, k in enumerate(near.tolist())}
        self._far = {names[k]: 2 * i for i, k in enumerate(far.tolist())}
        n = len(a)
        self._mean[:n], self._cov[:n, :n] = mean[a], cov[np.ix_(a, a)]
        self._mean[3] = self._cov[3, :n] = self._cov[:n, 3] = 0.0
        self._spreads = np.array([_spread(mean, cov, k) for k in b[::2].tolist()]).reshape(-1, 2, 2)
        cross = cov[np.ix_(a, b)]
        cross[3] = 0.0
        self._set_far(mean[b], cov[np.ix_(b, b)], cross)

    def _set_far(self, mean: Array, cov: Array, cross: Array) -> None:
        self._far_mean, self._far_cov, self._cross = mean, cov, cross
        m = len(cross) if cross.shape[1] else 0
        if not m:
            self._spreads = np.zeros((0, 2, 2))
        # without far tags the kernels have nothing to gather, but read rows of it
        self._kept = np.eye(m) if m else np.zeros((len(self._mean), 0))
        self._told, self._moved, self._turn_rad = np.zeros((m, m)), np.zeros(m), 0.0

    def _near_index(self, tag_id: str) -> int:
        if tag_id not in self._near:
            self._choose_near((tag_id,))
        return self._near[tag_id]

    def _choose_near(self, wanted: Iterable[str]) -> None:
        self.set_whole(self.tag_ids, *self.whole(), wanted)

    @property
    def _size(self) -> int:
        return HEAD + 2 * len(self._near)


def _spread(mean: Array, cov: Array, at: int) -> Array:
    """Return the covariance (2, 2) of a point, from that of its error and of the heading's."""
    by_heading = np.array([-mean[at + 1], mean[at]])
    joint = np.outer(by_heading, cov[0, at : at + 2])
    spread: Array = cov[at : at + 2, at : at + 2] + joint + joint.T
    spread += cov[0, 0] * np.outer(by_heading, by_heading)
    return spread


def _retracted(points: Array, turn_rad: float, shift: Array) -> Array:
    head = np.zeros(HEAD)
    mean = np.concatenate([head, points])
    kernels.retract(mean, len(mean), np.concatenate([[turn_rad, 0.0, 0.0, 0.0], shift]))
    moved: Array = mean[HEAD:]
    return moved
