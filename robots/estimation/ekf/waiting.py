"""Tags heard whose place is not known yet: their sightings wait until they tell it.

A range with a bearing of a narrow beam tells a place at once. A range alone, or one with the side of the
antenna that heard it, tells a ring or a part of one, which no Gaussian describes; several from different
poses cross. They are solved together as a small least-squares problem in the frame of the robot now, from
seeds all round, and believed when one place fits and no other.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2, hypot, log, pi

import numpy as np
from numba import njit

from robots.estimation.tag_filter import RangeSighting
from robots.se2 import Array, GaussianPose, Pose2

_MOST = 80  # sightings of a tag that wait; then every other one goes
_PATIENCE = 8  # a new attempt after an eighth more sightings
_ROUND, _SHARES = 12, (0.4, 1.0, 2.0)
_STEPS = 12
_STRIDE_M = 2.0
_LEAST_LOG_SD = 1e-3
_FLAT = 1e-9  # information that keeps one range alone solvable
_OTHER = 9.0  # squared deviations by which another place has to fit worse
_SAME_SD = 2.0  # solutions nearer than so many deviations are one
_MISFIT = 2.5  # of the mean squared residual: nothing fits


@dataclass(frozen=True, slots=True)
class _Waiting:
    sighting: RangeSighting
    trail_from_antenna: Pose2
    drift: tuple[float, float]  # variances of the dead reckoning so far: m2, rad2


class WaitingRoom:
    """Keeps sightings by tag, and where dead reckoning had the robot when they were made."""

    def __init__(self, place_sd_m: float) -> None:
        self._place_sd_m = place_sd_m
        self._waiting: dict[str, list[_Waiting]] = {}
        self._tried: dict[str, int] = {}  # how many have to wait before the next attempt
        self._trail = Pose2()
        self._drift = (0.0, 0.0)

    def move(self, step: GaussianPose) -> None:
        """Follow the robot's displacement."""
        self._trail = self._trail @ step.mean
        c = step.covariance
        along, turn = max(c[0, 0], c[1, 1]), c[2, 2]
        self._drift = (self._drift[0] + along, self._drift[1] + turn)

    def leave(self, tag_id: str) -> None:
        """Let go of what waits for a tag."""
        self._waiting.pop(tag_id, None)
        self._tried.pop(tag_id, None)

    def add(self, sighting: RangeSighting) -> tuple[tuple[float, float], Array] | None:
        """Add a sighting; return the tag's place in the base frame with its covariance once it is known."""
        rows = self._waiting.setdefault(sighting.tag_id, [])
        rows.append(_Waiting(sighting, self._trail @ sighting.base_from_antenna, self._drift))
        if len(rows) > _MOST:
            del rows[1::2]
            self._tried.pop(sighting.tag_id, None)
        if len(rows) < self._tried.get(sighting.tag_id, 2):
            return None
        found = self._solve(rows)
        self._tried[sighting.tag_id] = len(rows) + 1 + len(rows) // _PATIENCE
        if found is None or np.linalg.eigvalsh(found[1])[-1] > self._place_sd_m**2:
            return None
        self.leave(sighting.tag_id)
        return found

    def _solve(self, rows: list[_Waiting]) -> tuple[tuple[float, float], Array] | None:
        antennas = np.array([self._trail.between(row.trail_from_antenna).as_array() for row in rows])
        seen = np.array([_numbers(row.sighting) for row in rows])
        drift = np.array([self._drift]) - [row.drift for row in rows]
        away = np.hypot(antennas[:, 0], antennas[:, 1])
        seen[:, 1] += drift[:, 0] + drift[:, 1] * away**2
        near = np.maximum(seen[:, 0], 0.3) ** 2
        seen[:, 3] += (drift[:, 0] + drift[:, 1] * away**2) / near + drift[:, 1]
        places = _seeds(antennas[-1], seen)
        costs, information = np.empty(len(places)), np.empty((len(places), 2, 2))
        settle(places, antennas, seen, costs, information)
        best = int(np.argmin(costs))
        measured = len(seen) + int(np.isfinite(seen[:, 3]).sum())
        if not np.isfinite(costs[best]) or costs[best] > _MISFIT * measured:
            return None
        off = places - places[best]
        elsewhere = np.einsum("ki,ij,kj->k", off, information[best], off) > _SAME_SD**2
        if (elsewhere & (costs < costs[best] + _OTHER)).any():
            return None
        x, y = places[best].tolist()
        return (x, y), np.linalg.inv(information[best])


def _numbers(sighting: RangeSighting) -> tuple[float, ...]:
    bearing, sd = sighting.bearing_rad, sighting.bearing_sd_rad
    range_m, log_sd = range_of(sighting)
    if bearing is None or sd is None:
        return range_m, sighting.range_sd_m**2, 0.0, np.inf, log_sd
    return range_m, sighting.range_sd_m**2, bearing, sd**2, log_sd


def range_of(sighting: RangeSighting) -> tuple[float, float]:
    """Return a range and the deviation of its logarithm: 0 where the range itself is normal."""
    if sighting.median_m is None or sighting.log_sd is None:
        return sighting.range_m, 0.0
    return sighting.median_m, max(sighting.log_sd, _LEAST_LOG_SD)


def _seeds(antenna: Array, seen: Array) -> Array:
    """Return where to begin: all round the newest antenna, as far off as ranges go."""
    usual_m = float(np.median(seen[:, 0]))
    angles = 2.0 * pi * np.arange(_ROUND) / _ROUND + antenna[2]
    circle = np.column_stack([np.cos(angles), np.sin(angles)])
    seeds: Array = np.concatenate([antenna[:2] + share * usual_m * circle for share in _SHARES])
    return seeds


@njit(cache=True)
def settle(places: Array, antennas: Array, seen: Array, costs: Array, information: Array) -> None:
    """Move each place (s, 2) to its minimum by Gauss-Newton; fill in cost (s,) and information (s, 2, 2)."""
    for k in range(len(places)):
        for step in range(_STEPS + 1):
            cost, xx, xy, yy, px, py = 0.0, _FLAT, 0.0, _FLAT, 0.0, 0.0
            for i in range(len(seen)):
                dx, dy = places[k, 0] - antennas[i, 0], places[k, 1] - antennas[i, 1]
                r = max(hypot(dx, dy), 1e-3)
                ex, ey, off, weight = dx / r, dy / r, seen[i, 0] - r, 1.0 / seen[i, 1]
                if seen[i, 4] > 0.0:
                    off, weight = r * log(seen[i, 0] / r), 1.0 / (r * seen[i, 4]) ** 2
                cost += off * off * weight
                xx, xy, yy = xx + ex * ex * weight, xy + ex * ey * weight, yy + ey * ey * weight
                px, py = px + ex * off * weight, py + ey * off * weight
                if seen[i, 3] == np.inf:
                    continue
                off = seen[i, 2] - atan2(dy, dx) + antennas[i, 2]
                off = (off + pi) % (2.0 * pi) - pi
                weight = 1.0 / seen[i, 3]
                cost += off * off * weight
                weight /= r
                px, py = px - ey * off * weight, py + ex * off * weight
                weight /= r
                xx, xy, yy = xx + ey * ey * weight, xy - ex * ey * weight, yy + ex * ex * weight
            costs[k] = cost
            information[k, 0, 0], information[k, 1, 1] = xx, yy
            information[k, 0, 1] = information[k, 1, 0] = xy
            if step < _STEPS:
                size = xx * yy - xy * xy
                places[k, 0] += min(max((yy * px - xy * py) / size, -_STRIDE_M), _STRIDE_M)
                places[k, 1] += min(max((xx * py - xy * px) / size, -_STRIDE_M), _STRIDE_M)
