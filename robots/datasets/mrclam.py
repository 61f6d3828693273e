"""UTIAS multi-robot localisation and mapping (Leung et al. 2011): five robots among landmarks, as .npz.

For robot N: ``odoN_t_ms`` (n,) and ``odoN_vw`` (n, 2) commanded velocities in m/s and rad/s; ``measN_t_ms``
(m,), ``measN_subject`` (m,) and ``measN_rb`` (m, 2) range in metres and bearing of what its camera saw: robot
1..5, a landmark's number from 6 on, or -1 where the barcode could not be read; ``gtN_t_ms``, ``gtN_xyth`` (k,
3) where a motion capture system saw the robot; ``landmarks`` (l, 5) number, x, y and two deviations. All
stamps are milliseconds of one clock.

Measured against the motion capture, alike for all five robots, and so taken for properties of the hardware:

* A robot does what it was told 0.24 s later (0.20 to 0.28 s), and a sighting is stamped 0.04 s after the
  picture was taken. Both are put where they belong, so stamps here are those of the motion.
* A robot drives and turns at 0.94 times the velocities it was told (0.925 to 0.958 driving, 0.92 to 0.97
  turning): the velocities are multiplied by that, and what differs from robot to robot is left to the noise.
* Velocities are logged at up to 100 Hz while they change and at least every second, so one that is more than
  a second old is no longer held.
* A camera tells how far off a barcode is by how high it looks, and that tells the depth along the camera's
  axis, as in every pinhole camera: at 0.5 rad beside the axis the range is 1.14 times what was measured. So
  measured ranges are divided by the cosine of their bearing, whatever the capture says. What is left is
  1.025 times the range and 0.04 m more (1.014 to 1.054, 0.00 to 0.09 m), which is taken back, and errors of
  0.8 to 1.5 % of the range, where without the cosine they were 3.4 to 4.6 % and lasted for seconds.
* What the cameras differ in, and bearings' errors (0.006 to 0.018 rad), stay the same for seconds and more,
  so deviations are larger than their scatter.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robots.datasets.recording import RecordingError, array_names, load_arrays
from robots.datasets.velocities import HeldVelocities, displacements
from robots.se2 import Array
from robots.team import StartPose
from robots.trajectory import Trajectory
from robots.types import Displacement, Observation, RobotSighting, TagSighting

_ROBOTS = range(1, 6)  # subjects that are robots; landmarks have the numbers after them
_MOTION_LAGS_MS, _SIGHTING_LAGS_MS = 240.0, 40.0
_GAIN = 0.94
_RANGE_GAIN, _RANGE_OFFSET_M = 1.025, 0.04  # of the depth that the cameras measure
_LEAST_COSINE = 0.17
_HOLD_S = 1.1
_EVERY_S = 0.05  # velocities that follow faster are merged into one observation

_SETTINGS: dict[str, Any] = {
    "body": {"radius_m": 0.18, "max_speed_mps": 0.2},
    "odometry": {
        "distance_sd_per_sqrt_m": 0.08,
        "turn_sd_per_sqrt_m": 0.06,
        "turn_sd_per_sqrt_rad": 0.10,
        "lateral_sd_per_sqrt_m": 0.02,
    },
    "ranging": {"range_sd_m": 0.03, "range_sd_per_m": 0.02, "bearing_sd_rad": 0.018},
    "rslam": {"scale_sd": 0.02, "offset_sd_m": 0.05},
    "deployment": {"magazine": 0},
    "planning": {"replan_every_s": 10.0},  # somebody drove it; where our agent would go is only looked at
}

# particles take every range for a new one: a deviation for ranges whose errors stay the same for seconds
_BY_RANGE: dict[str, Any] = {"slam": "rslam", "ranging": {"range_sd_m": 0.05, "range_sd_per_m": 0.03}}


@dataclass(frozen=True, slots=True, eq=False)
class _Sightings:
    """What one robot's camera saw: ``stamps_s`` (m,) in order, ``subjects`` (m,), ``places`` (m, 2)."""

    stamps_s: Array
    subjects: NDArray[np.int64]
    places: Array


@dataclass(frozen=True, slots=True, eq=False)
class _Day:
    stamps_s: Array
    motions: Array  # (n, 3), from the observation before
    sightings: _Sightings
    truth: Trajectory | None


@dataclass(frozen=True, slots=True, eq=False)
class MrclamRecording:
    """Robots that drive among landmarks and see them, and each other, by range and bearing."""

    days: dict[str, _Day]
    landmarks: dict[str, tuple[float, float]]
    name: str = "mrclam"
    truth_gap_s: float = 0.5
    range_only: bool = False  # leave out bearings, and with them the other robots

    @property
    def robots(self) -> tuple[str, ...]:
        """Ids of the robots in it, "r1" for the file's robot 1."""
        return tuple(self.days)

    @property
    def settings(self) -> dict[str, Any]:
        """Overrides of ``AgentConfig`` for this hardware."""
        return _SETTINGS | _BY_RANGE if self.range_only else _SETTINGS

    def settings_of(self, robot_id: str) -> dict[str, Any]:
        """Return the same: the robots are alike."""
        return self.settings

    def start_pose(self, robot_id: str) -> StartPose | None:
        """Return nothing: the map begins where the robot did."""
        return None

    def length(self, robot_id: str) -> int:
        """Return the number of observations."""
        return len(self.days[robot_id].stamps_s)

    def stamps_s(self, robot_id: str) -> Array:
        """Return when each observation was made, (n,), in seconds of the file's clock."""
        return self.days[robot_id].stamps_s

    def truth(self, robot_id: str) -> Trajectory | None:
        """Return the path of the motion capture system."""
        return self.days[robot_id].truth

    def tag_places(self) -> dict[str, tuple[float, float]]:
        """Return where the motion capture system has the landmarks."""
        return self.landmarks

    def observations(self, robot_id: str) -> Iterator[Observation]:
        """Yield one observation at each sighting, and between them one about every ``0.05 s``."""
        day = self.days[robot_id]
        seen = day.sightings
        first = np.searchsorted(seen.stamps_s, day.stamps_s, side="left")
        end = np.searchsorted(seen.stamps_s, day.stamps_s, side="right")
        for seq, (stamp, motion) in enumerate(zip(day.stamps_s, day.motions, strict=True)):
            here = range(first[seq], end[seq])
            yield Observation(
                seq=seq,
                stamp_s=float(stamp),
                odometry=Displacement(*(float(value) for value in motion)),
                tag_sightings=tuple(self._sighting(seen, k) for k in here if seen.subjects[k] not in _ROBOTS),
                robot_sightings=tuple(
                    RobotSighting(f"r{seen.subjects[k]}", *_place(seen, k))
                    for k in here
                    if seen.subjects[k] in _ROBOTS and not self.range_only
                ),
            )

    def _sighting(self, seen: _Sightings, k: int) -> TagSighting:
        range_m, bearing = _place(seen, k)
        return TagSighting(f"L{seen.subjects[k]}", b"", range_m, None if self.range_only else bearing)


def load(path: Path, virtual_tags_m: float | None = None) -> MrclamRecording:
    """Read the recording: every robot that has odometry in it.

    What was stamped out of order is put where its stamp says. A sighting whose barcode was not read, or read
    as the robot's own, is left out; landmarks nobody has heard of are tags like the others.

    Raises:
        RecordingError: the file cannot be read, or an array is missing, has another shape or an impossible
            value; or virtual tags are wanted where there are real ones.
    """
    if virtual_tags_m is not None:
        raise RecordingError("mrclam has landmarks for tags; leave the virtual ones out")
    names = array_names(path)
    numbers = sorted(int(found[1]) for name in names if (found := re.fullmatch(r"odo([1-5])_t_ms", name)))
    if not numbers:
        raise RecordingError(f"{path} has no array 'odo1_t_ms'; it holds {', '.join(names)}")
    days = {f"r{number}": _load_robot(path, number, names) for number in numbers}
    return MrclamRecording(days, _landmarks(path, names))


def _load_robot(path: Path, number: int, names: tuple[str, ...]) -> _Day:
    velocities = _velocities(path, number)
    seen = _sightings(path, number)
    stamps = _observed_at(velocities.stamps_s, seen.stamps_s)
    return _Day(stamps, displacements(velocities.poses(stamps)), seen, _truth(path, number, names))


def _velocities(path: Path, number: int) -> HeldVelocities:
    times, told = f"odo{number}_t_ms", f"odo{number}_vw"
    arrays = load_arrays(path, {times: (None,), told: (None, 2)})
    if not len(arrays[times]):
        raise RecordingError(f"{path}: array {times!r} is empty")
    _check_finite(path, arrays)
    stamps = (arrays[times].astype(np.float64) + _MOTION_LAGS_MS) / 1e3
    order = np.argsort(stamps, kind="stable")
    driven = _GAIN * arrays[told].astype(np.float64)[order]
    return HeldVelocities(stamps[order], driven[:, 0], driven[:, 1], _HOLD_S)


def _sightings(path: Path, number: int) -> _Sightings:
    times, subject, places = f"meas{number}_t_ms", f"meas{number}_subject", f"meas{number}_rb"
    arrays = load_arrays(path, {times: (None,), subject: (None,), places: (None, 2)})
    known = (arrays[subject] >= 1) & (arrays[subject] != number)
    arrays = {name: array[known] for name, array in arrays.items()}
    _check_finite(path, arrays)
    if (arrays[places][:, 0] < 0.0).any():
        raise RecordingError(f"{path}: array {places!r} has to hold ranges of 0 m or more")
    stamps = (arrays[times].astype(np.float64) - _SIGHTING_LAGS_MS) / 1e3
    order = np.argsort(stamps, kind="stable")
    seen = arrays[places].astype(np.float64)[order]
    # beyond 80 degrees no camera saw it, and the cosine would make anything of it
    ranges = seen[:, 0] / np.maximum(np.cos(seen[:, 1]), _LEAST_COSINE)
    seen[:, 0] = np.maximum((ranges - _RANGE_OFFSET_M) / _RANGE_GAIN, 0.0)
    return _Sightings(stamps[order], arrays[subject].astype(np.int64)[order], seen)


def _truth(path: Path, number: int, names: tuple[str, ...]) -> Trajectory | None:
    times, poses = f"gt{number}_t_ms", f"gt{number}_xyth"
    if times not in names:
        return None
    arrays = load_arrays(path, {times: (None,), poses: (None, 3)})
    known = np.isfinite(arrays[poses]).all(axis=1) & np.isfinite(arrays[times])
    if not known.any():
        return None
    return Trajectory(arrays[times][known].astype(np.float64) / 1e3, arrays[poses][known].astype(np.float64))


def _landmarks(path: Path, names: tuple[str, ...]) -> dict[str, tuple[float, float]]:
    if "landmarks" not in names:
        return {}
    rows = load_arrays(path, {"landmarks": (None, 5)})["landmarks"].astype(np.float64)
    known = np.isfinite(rows[:, :3]).all(axis=1)
    return {f"L{subject:.0f}": (float(x), float(y)) for subject, x, y in rows[known, :3]}


def _observed_at(moved_s: Array, seen_s: Array) -> Array:
    """Return the stamps to observe at: every sighting, and velocities at least ``_EVERY_S`` apart."""
    kept, last = [], -np.inf
    for stamp in moved_s.tolist():
        if stamp - last >= _EVERY_S:
            kept.append(stamp)
            last = stamp
    return np.unique(np.concatenate([kept, moved_s[-1:], seen_s]))


def _check_finite(path: Path, arrays: dict[str, NDArray[Any]]) -> None:
    for name, array in arrays.items():
        if not np.isfinite(array).all():
            raise RecordingError(f"{path}: array {name!r} holds a value that is not finite")


def _place(seen: _Sightings, k: int) -> tuple[float, float]:
    return float(seen.places[k, 0]), float(seen.places[k, 1])
