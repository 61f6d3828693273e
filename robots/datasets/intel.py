"""Intel Research Lab (Seattle, 2003; D. Haehnel): a Pioneer with a 180 degree laser, raw odometry, as .npz.

Arrays, one row a frame: ``ranges`` (n, 180) metres, ``odo_increments`` (n, 3) motion from frame k to frame k
+ 1 by the wheels alone, ``t_epoch`` (n,) seconds, ``corrected_pose`` (n, 3) a reference path.

Measured on the recording, not printed anywhere:

* The beams are one degree apart and centred, -89.5 to +89.5 degrees. Scans of neighbouring frames fit each
  other better with 1.000 than with 180/179 degrees (1.68 cm against 1.76 cm rms in turns), and centred beams
  make the laser and the wheels agree on the direction of travel (0.1 degrees apart; -90..+89 is 0.4 off,
  -89..+90 0.6).
* The scanner sits 0.095 m ahead of the point the wheels turn about: between scans of turns on the spot it
  moves sideways by that much times the sine of the turn (median over 580 turns; quartiles within 1 cm). The
  reference path, and the relations published with it, are the scanner's. So the base frame here is the
  scanner's, and the wheels' displacements are carried over into it.
* A reading of 81.83 m means that no echo came back. Stamps step backwards 20-odd times, by up to 0.3 s.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from math import inf, radians
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robots.datasets.recording import RecordingError, load_arrays
from robots.datasets.virtual_tags import SIGHTING_RADIUS_M, VirtualTags, place_tags
from robots.se2 import Array, Pose2
from robots.trajectory import Trajectory
from robots.types import Displacement, FloatArray32, LaserScan, Observation, TagSighting

ROBOT = "r1"
_BEAMS = 180
_ANGLE_MIN_RAD, _ANGLE_INCREMENT_RAD = radians(-89.5), radians(1.0)
_WHEELS_FROM_SCANNER = Pose2(0.095, 0.0, 0.0)

# No inertial unit; a reader that reaches SIGHTING_RADIUS_M round the robot; a magazine that is empty. The
# wheels turn about 0.05 rad/m too little and roll about 4 % long: errors that add up rather than average out,
# so their standard deviations are set to reach that over the metre or two between two tags.
_SETTINGS: dict[str, Any] = {
    "body": {"radius_m": 0.25, "max_speed_mps": 1.0},
    "antenna": {"radius_m": SIGHTING_RADIUS_M, "ahead_m": 0.0},
    "odometry": {"distance_sd_per_sqrt_m": 0.10, "turn_sd_per_sqrt_m": 0.08, "lateral_sd_per_sqrt_m": 0.03},
    "deployment": {"magazine": 0},
    "planning": {"replan_every_s": 10.0},  # somebody drove it; where our agent would go is only looked at
}


@dataclass(frozen=True, slots=True, eq=False)
class IntelRecording:
    """One robot's day. Frames without a stamp are not observed: their motion is added to the next frame's."""

    ranges_m: FloatArray32
    displacements: Array  # (n, 3), from the observed frame before
    own_stamps_s: Array
    reference: Array  # (n, 3), NaN where unknown
    tags: VirtualTags
    range_max_m: float
    name: str = "intel"
    robots: tuple[str, ...] = (ROBOT,)
    truth_gap_s: float = inf  # a pose for each observation, however far apart: nothing is interpolated

    @property
    def settings(self) -> dict[str, Any]:
        """Overrides of ``AgentConfig`` for this hardware."""
        return _SETTINGS

    def length(self, robot_id: str) -> int:
        """Return the number of observations."""
        return len(self.own_stamps_s)

    def stamps_s(self, robot_id: str) -> Array:
        """Return the recorded stamps, (n,)."""
        return self.own_stamps_s

    def truth(self, robot_id: str) -> Trajectory | None:
        """Return the reference path, which is itself 0.097 m from the published relations."""
        known = np.isfinite(self.reference).all(axis=1)
        return Trajectory(self.own_stamps_s[known], self.reference[known]) if known.any() else None

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
                scan=LaserScan(ranges, _ANGLE_MIN_RAD, _ANGLE_INCREMENT_RAD, self.range_max_m),
                tag_sightings=tuple(
                    TagSighting(str(number + 1)) for number in self.tags.sighted.get(seq, ())
                ),
            )


def load(path: Path, virtual_tags_m: float | None = None) -> IntelRecording:
    """Read the recording; with ``virtual_tags_m``, place a tag on the reference path every so many metres.

    Raises:
        RecordingError: the file cannot be read, or an array is missing, has another shape or an impossible
            value.
    """
    shapes: dict[str, tuple[int | None, ...]] = {
        "t_epoch": (None,),
        "ranges": (None, _BEAMS),
        "odo_increments": (None, 3),
        "corrected_pose": (None, 3),
    }
    arrays = load_arrays(path, shapes)
    stamps = arrays["t_epoch"].astype(np.float64)
    increments = arrays["odo_increments"].astype(np.float64)
    observed = np.flatnonzero(np.isfinite(stamps))
    if len(observed) < 2:
        raise RecordingError(f"{path}: array 't_epoch' holds fewer than two stamps")
    if not np.isfinite(increments).all():
        raise RecordingError(f"{path}: array 'odo_increments' holds a value that is not finite")
    ranges = arrays["ranges"].astype(np.float32)[observed]
    if not np.isfinite(ranges).any() or np.nanmin(ranges) < 0.0:
        raise RecordingError(f"{path}: array 'ranges' has to hold distances of 0 m or more")
    reference = arrays["corrected_pose"].astype(np.float64)[observed]
    if virtual_tags_m is None:
        tags = VirtualTags(np.zeros((0, 2)), {})
    elif np.isfinite(reference).all(axis=1).any():
        tags = place_tags(reference[:, :2], virtual_tags_m)
    else:
        raise RecordingError(f"{path}: array 'corrected_pose' holds no pose to place virtual tags by")
    return IntelRecording(
        ranges_m=ranges,
        displacements=_between_frames(increments, observed),
        own_stamps_s=stamps[observed],
        reference=reference,
        tags=tags,
        range_max_m=float(np.max(ranges[np.isfinite(ranges)])),
    )


def _between_frames(increments: Array, observed: NDArray[np.int64]) -> Array:
    """Return the scanner's displacement from the observed frame before each, (n, 3), zero for the first."""
    rows = [np.zeros(3)]
    for first, second in pairwise(observed):
        wheels = Pose2()
        for row in increments[first:second]:
            wheels = wheels @ Pose2.from_array(row)
        rows.append((_WHEELS_FROM_SCANNER.inverse() @ wheels @ _WHEELS_FROM_SCANNER).as_array())
    return np.array(rows)
