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

from itertools import pairwise
from math import radians
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robots.datasets.laser import (
    Laser,
    LaserRecording,
    checked_ranges,
    scanner_motion,
    stamped_frames,
    virtual_tags,
)
from robots.datasets.recording import RecordingError, load_arrays
from robots.datasets.virtual_tags import SIGHTING_RADIUS_M
from robots.se2 import Array, Pose2

_BEAMS = 180
_LASER = Laser(radians(-89.5), radians(1.0), Pose2(0.095, 0.0, 0.0))

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


def load(path: Path, virtual_tags_m: float | None = None) -> LaserRecording:
    """Read the recording; with ``virtual_tags_m``, place a tag on the reference path every so many metres.

    The reference path is itself 0.097 m from the published relations.

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
    observed = stamped_frames(path, stamps)
    if not np.isfinite(increments).all():
        raise RecordingError(f"{path}: array 'odo_increments' holds a value that is not finite")
    ranges = checked_ranges(path, arrays["ranges"][observed])
    reference = arrays["corrected_pose"].astype(np.float64)[observed]
    return LaserRecording(
        name="intel",
        settings=_SETTINGS,
        laser=_LASER,
        ranges_m=ranges,
        displacements=_between_frames(increments, observed),
        own_stamps_s=stamps[observed],
        reference=reference,
        tags=virtual_tags(path, reference, virtual_tags_m),
        range_max_m=float(np.max(ranges[np.isfinite(ranges)])),
    )


def _between_frames(increments: Array, observed: NDArray[np.int64]) -> Array:
    """Return the scanner's displacement from the observed frame before each, (n, 3), zero for the first."""
    rows = [np.zeros(3)]
    for first, second in pairwise(observed):
        wheels = Pose2()
        for row in increments[first:second]:
            wheels = wheels @ Pose2.from_array(row)
        rows.append(scanner_motion(wheels, _LASER))
    return np.array(rows)
