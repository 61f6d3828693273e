"""What recordings of one robot with a laser have in common: frames of scan and displacement, virtual tags."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import inf
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robots.datasets.recording import RecordingError
from robots.datasets.virtual_tags import VirtualTags, place_tags
from robots.se2 import Array, Pose2
from robots.team import StartPose
from robots.trajectory import Trajectory
from robots.types import Displacement, FloatArray32, LaserScan, Observation, TagSighting

ROBOT = "r1"


@dataclass(frozen=True, slots=True)
class Laser:
    """Bearing of the first beam, angle from one beam to the next, and where the scanner sits."""

    angle_min_rad: float
    angle_increment_rad: float
    wheels_from_scanner: Pose2


@dataclass(frozen=True, slots=True, eq=False)
class LaserRecording:
    """One robot's day: a scan and a displacement each frame, in the frame of the scanner.

    ``displacements`` (n, 3) from the frame before, ``own_stamps_s`` (n,), ``reference`` (n, 3) poses, NaN
    where unknown, ``tags`` sighted by frame.
    """

    name: str
    settings: dict[str, Any]
    laser: Laser
    ranges_m: FloatArray32
    displacements: Array
    own_stamps_s: Array
    reference: Array
    tags: VirtualTags
    range_max_m: float
    robots: tuple[str, ...] = (ROBOT,)
    truth_gap_s: float = inf  # a pose for each observation, however far apart: nothing is interpolated

    def settings_of(self, robot_id: str) -> dict[str, Any]:
        """Return overrides of ``AgentConfig`` for this hardware."""
        return self.settings

    def start_pose(self, robot_id: str) -> StartPose | None:
        """Return nothing: the map begins where the robot did."""
        return None

    def length(self, robot_id: str) -> int:
        """Return the number of observations."""
        return len(self.own_stamps_s)

    def stamps_s(self, robot_id: str) -> Array:
        """Return the recorded stamps, (n,)."""
        return self.own_stamps_s

    def truth(self, robot_id: str) -> Trajectory | None:
        """Return the reference path."""
        known = np.isfinite(self.reference).all(axis=1)
        return Trajectory(self.own_stamps_s[known], self.reference[known]) if known.any() else None

    def tag_places(self) -> dict[str, tuple[float, float]]:
        """Return where the virtual tags were placed."""
        return {str(k + 1): (float(x), float(y)) for k, (x, y) in enumerate(self.tags.places_m)}

    def observations(self, robot_id: str) -> Iterator[Observation]:
        """Yield one observation a frame: displacement, scan, and the ids of virtual tags driven over."""
        clock = np.maximum.accumulate(self.own_stamps_s)
        for seq, (stamp, motion, ranges) in enumerate(
            zip(clock, self.displacements, self.ranges_m, strict=True)
        ):
            yield Observation(
                seq=seq,
                stamp_s=float(stamp),
                odometry=Displacement(*(float(value) for value in motion)),
                scan=LaserScan(
                    ranges, self.laser.angle_min_rad, self.laser.angle_increment_rad, self.range_max_m
                ),
                tag_sightings=tuple(
                    TagSighting(str(number + 1)) for number in self.tags.sighted.get(seq, ())
                ),
            )


def stamped_frames(path: Path, stamps: Array) -> NDArray[np.int64]:
    """Return the frames that have a stamp: the others are not observed, their motion is the next one's.

    Raises:
        RecordingError: there are fewer than two.
    """
    frames = np.flatnonzero(np.isfinite(stamps))
    if len(frames) < 2:
        raise RecordingError(f"{path}: array 't_epoch' holds fewer than two stamps")
    return frames


def checked_ranges(path: Path, ranges: NDArray[Any]) -> FloatArray32:
    """Return the ranges as float32.

    Raises:
        RecordingError: none is finite, or one is negative.
    """
    if not np.isfinite(ranges).any() or np.nanmin(ranges) < 0.0:
        raise RecordingError(f"{path}: array 'ranges' has to hold distances of 0 m or more")
    return ranges.astype(np.float32)


def virtual_tags(path: Path, reference: Array, spacing_m: float | None) -> VirtualTags:
    """Place a tag on the reference path (n, 3) every so many metres, none where that is None.

    Raises:
        RecordingError: the reference holds no pose.
    """
    if spacing_m is None:
        return VirtualTags(np.zeros((0, 2)), {})
    if np.isfinite(reference).all(axis=1).any():
        return place_tags(reference[:, :2], spacing_m)
    raise RecordingError(f"{path}: array 'corrected_pose' holds no pose to place virtual tags by")


def scanner_motion(wheels: Pose2, laser: Laser) -> Array:
    """Return the scanner's displacement (3,) when the wheels' frame moved like that."""
    there = laser.wheels_from_scanner
    return (there.inverse() @ wheels @ there).as_array()
