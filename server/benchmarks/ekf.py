"""What a sighting costs the EKF over tags, beside a dense EKF in numpy that does the same by the book."""

from __future__ import annotations

from collections.abc import Iterator
from math import atan2, hypot
from time import thread_time
from typing import Any

import numpy as np

from robots.config import AgentConfig
from robots.estimation.ekf.filter import EkfFilter
from robots.estimation.tag_filter import RangeSighting
from robots.se2 import Array, GaussianPose, Pose2, wrap

_SPACING_M, _REACH_M, _STEP_M = 3.0, 5.0, 0.1
_NOISE = np.diag([1e-4, 1e-5, 1e-5])
_RANGE_SD_M, _BEARING_SD_RAD = 0.1, 0.03
_TURN_RAD = 0.6  # at most, in a step
_EVERY = 5  # steps between two looks round
_COMPARED = 200  # sightings that the slow rival gets


def measure(tags: tuple[int, ...] = (50, 1000), sightings: int = 4000) -> dict[str, Any]:
    """Return the times with each number of tags on the map, as ``update_us_50``, and how the rival does."""
    results: dict[str, Any] = {}
    for count in tags:
        results |= {f"{name}_{count}": value for name, value in _measure(count, sightings).items()}
    return results


def _measure(tags: int, sightings: int) -> dict[str, Any]:
    """Map ``tags`` on a lawn by mowing it, then time so many sightings on the way back through it.

    Times are the processor's, of ``EkfFilter.see`` from Python; mean and maximum include changes of the near
    tags.
    """
    course = _Course(tags)
    ours = EkfFilter("bench", AgentConfig(), course.start)
    for around, moved in course.drive(1):
        ours.predict(moved)
        for each in around:
            ours.see(each)
    seconds, dense_s = [], 0.0
    for around, moved in course.drive(-1):
        ours.predict(moved)
        dense_s = dense_s or _dense_s(ours, around)
        for each in around:
            began = thread_time()
            ours.see(each)
            seconds.append(thread_time() - began)
        if len(seconds) >= sightings:
            break
    times_us = 1e6 * np.array(seconds)
    off = ours.belief.mean.distance(course.pose)
    return {
        "mapped": len(ours.tags()),
        "update_us_p50": float(np.median(times_us)),
        "update_us_mean": float(times_us.mean()),
        "update_us_p99": float(np.percentile(times_us, 99)),
        "update_ms_max": float(times_us.max()) / 1e3,
        "numpy_dense_us": 1e6 * dense_s,
        "times_faster": 1e6 * dense_s / float(times_us.mean()),
        "off_m": off,
    }


class _Course:
    """A robot that mows a lawn of tags, row by row, and measures with the noise it states."""

    def __init__(self, tags: int) -> None:
        side = int(np.ceil(np.sqrt(tags)))
        places = [(_SPACING_M * (k % side), _SPACING_M * (k // side)) for k in range(tags)]
        self._places = np.array(places)
        self._length_m = _SPACING_M * (side - 1)
        self._rows = (tags + side - 1) // side
        self.start = self.pose = Pose2(-1.0, 0.7, 0.0)
        self._stamp_s = 0.0
        self._rng = np.random.default_rng(1)

    def drive(self, direction: int) -> Iterator[tuple[list[RangeSighting], GaussianPose]]:
        """Yield what is seen and how the robot moved, over all rows upwards (1) or downwards (-1)."""
        for x, y in self._way()[::direction]:
            while (away := hypot(x - self.pose.x, y - self.pose.y)) > _STEP_M:
                moved = GaussianPose.exact()
                for _ in range(_EVERY):
                    moved = moved @ self._step(x, y, away)
                self._stamp_s += 1.0
                yield self._look(), moved

    def _step(self, x: float, y: float, away_m: float) -> GaussianPose:
        """Turn towards a point, then drive; return what the wheels tell of it."""
        turn = wrap(atan2(y - self.pose.y, x - self.pose.x) - self.pose.theta)
        ahead_m = min(_STEP_M, away_m) if abs(turn) < _TURN_RAD else 0.0
        motion = Pose2(ahead_m, 0.0, max(min(turn, _TURN_RAD), -_TURN_RAD))
        self.pose = self.pose @ motion
        noise = self._rng.standard_normal(3) * np.sqrt(np.diag(_NOISE))
        return GaussianPose(Pose2.from_array(motion.as_array() + noise), _NOISE)

    def _way(self) -> list[tuple[float, float]]:
        way = []
        for row in range(self._rows):
            ends = [-1.0, self._length_m + 1.0]
            way += [(x, _SPACING_M * row + 0.7) for x in (ends if row % 2 == 0 else ends[::-1])]
        return way

    def _look(self) -> list[RangeSighting]:
        d = self._places - (self.pose.x, self.pose.y)
        away = np.hypot(d[:, 0], d[:, 1])
        seen = np.flatnonzero(away < _REACH_M)
        off = self._rng.standard_normal((len(seen), 2))
        return [
            RangeSighting(
                str(k),
                self._stamp_s,
                float(away[k] + _RANGE_SD_M * off[i, 0]),
                _RANGE_SD_M,
                wrap(float(np.arctan2(d[k, 1], d[k, 0])) - self.pose.theta + _BEARING_SD_RAD * off[i, 1]),
                _BEARING_SD_RAD,
            )
            for i, k in enumerate(seen.tolist())
        ]


def _dense_s(ours: EkfFilter, around: list[RangeSighting]) -> float:
    """Return the median time of an update by the book with as many tags (Ziparo 2007 eq. 2 to 5)."""
    names = list(ours.tags())
    places = np.array([(b.x_m, b.y_m) for b in ours.tags().values()])
    belief = ours.belief
    mean = np.concatenate([belief.mean.as_array(), places.ravel()])
    cov = np.eye(len(mean)) * 0.1
    seconds = []
    known = [sighting for sighting in around if sighting.tag_id in names]
    for k in range(_COMPARED):
        sighting = known[k % len(known)]
        began = thread_time()
        mean, cov = _by_the_book(mean, cov, 3 + 2 * names.index(sighting.tag_id), sighting)
        seconds.append(thread_time() - began)
    return float(np.median(seconds))


def _by_the_book(mean: Array, cov: Array, at: int, seen: RangeSighting) -> tuple[Array, Array]:
    dx, dy = mean[at] - mean[0], mean[at + 1] - mean[1]
    r = hypot(dx, dy)
    h = np.zeros((2, len(mean)))
    h[:, :3] = [[-dx / r, -dy / r, 0.0], [dy / r**2, -dx / r**2, -1.0]]
    h[:, at : at + 2] = [[dx / r, dy / r], [-dy / r**2, dx / r**2]]
    off = np.array([seen.range_m - r, wrap((seen.bearing_rad or 0.0) - atan2(dy, dx) + mean[2])])
    by_state = cov @ h.T
    spread = h @ by_state + np.diag([_RANGE_SD_M**2, _BEARING_SD_RAD**2])
    gain = by_state @ np.linalg.inv(spread)
    return mean + gain @ off, cov - gain @ by_state.T
