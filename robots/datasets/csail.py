"""MIT CSAIL (C. Stachniss): one floor with a 180 degree laser of 361 beams, raw odometry, as .npz.

Arrays, one row a frame: ``ranges`` (n, 361) metres, ``raw_odometry_pose`` (n, 3) the pose by the wheels
alone, ``t_epoch`` (n,) seconds, ``corrected_pose`` (n, 3) a reference path.

Measured on the recording, not printed anywhere:

* The beams are half a degree apart, -90 to +90 degrees. Scans of neighbouring frames fit each other better so
  than 180/361 of a degree apart (median 1.11 cm against 1.12 cm, of 339 pairs; 1 % more or less: 1.13 cm).
* The scanner sits above the point the wheels turn about (within 1 cm) and looks 1.1 degrees to the left of
  the way the robot drives: by so much matched scans move otherwise than the wheels. The reference path is the
  scanner's, so the base frame here is too, and the wheels' displacements are carried over into it.
* The wheels roll 1 to 2 % short and turn without a bias, but a step of 0.9 m is 0.05 rad off in the median
  and 0.12 rad rms: a few steps are wrong by much.
* A reading of 81.91 m means that no echo came back. A frame comes about every 0.9 s.
"""

from __future__ import annotations

from itertools import pairwise
from math import radians
from pathlib import Path
from typing import Any

import numpy as np

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
from robots.se2 import Pose2

_BEAMS = 361
_LASER = Laser(radians(-90.0), radians(0.5), Pose2(0.0, 0.0, 0.0186))

# No inertial unit; a reader that reaches SIGHTING_RADIUS_M round the robot; a magazine that is empty.
_SETTINGS: dict[str, Any] = {
    "body": {"radius_m": 0.25, "max_speed_mps": 1.0},
    "antenna": {"radius_m": SIGHTING_RADIUS_M, "ahead_m": 0.0},
    "odometry": {"distance_sd_per_sqrt_m": 0.06, "turn_sd_per_sqrt_m": 0.13, "lateral_sd_per_sqrt_m": 0.06},
    "deployment": {"magazine": 0},
    "planning": {"replan_every_s": 10.0},  # somebody drove it; where our agent would go is only looked at
}


def load(path: Path, virtual_tags_m: float | None = None) -> LaserRecording:
    """Read the recording; with ``virtual_tags_m``, place a tag on the reference path every so many metres.

    Raises:
        RecordingError: the file cannot be read, or an array is missing, has another shape or an impossible
            value.
    """
    shapes: dict[str, tuple[int | None, ...]] = {
        "t_epoch": (None,),
        "ranges": (None, _BEAMS),
        "raw_odometry_pose": (None, 3),
        "corrected_pose": (None, 3),
    }
    arrays = load_arrays(path, shapes)
    stamps = arrays["t_epoch"].astype(np.float64)
    observed = stamped_frames(path, stamps)
    wheels = arrays["raw_odometry_pose"].astype(np.float64)[observed]
    if not np.isfinite(wheels).all():
        raise RecordingError(f"{path}: array 'raw_odometry_pose' holds a value that is not finite")
    ranges = checked_ranges(path, arrays["ranges"][observed])
    reference = arrays["corrected_pose"].astype(np.float64)[observed]
    motions = [
        scanner_motion(Pose2.from_array(here).between(Pose2.from_array(there)), _LASER)
        for here, there in pairwise(wheels)
    ]
    return LaserRecording(
        name="csail",
        settings=_SETTINGS,
        laser=_LASER,
        ranges_m=ranges,
        displacements=np.array([np.zeros(3), *motions]),
        own_stamps_s=stamps[observed],
        reference=reference,
        tags=virtual_tags(path, reference, virtual_tags_m),
        range_max_m=float(np.max(ranges[np.isfinite(ranges)])),
    )
