"""CMU Plaza (Djugash, Singh and Corke 2009): a mower among radio nodes that tell their range, as a folder.

``*_DR.txt`` rows of stamp, distance driven (m) and angle turned (rad) since the row before; ``*_TD.txt``
rows of stamp, antenna, node and range (m). The ``*.mat`` beside them is the truth, read for comparison alone:
``GT`` (n, 4) stamp, x, y, heading; ``TL`` (k, 3) node, x, y. Stamps are seconds of one clock.

Measured against the truth, and so taken for properties of the hardware: over 5 m the wheels err by 0.12 m
along and 0.12 m across the way, the gyro by next to nothing; ranges scatter by 0.55 m whatever the distance,
from one to the next independently. By how much they are too long the filter has to find out.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import loadmat

from robots.datasets.recording import RecordingError
from robots.se2 import Array
from robots.team import StartPose
from robots.trajectory import Trajectory
from robots.types import DistanceTurn, Observation, TagSighting

_ROBOT = "r1"
_FARTHEST_M = 1e4

_SETTINGS: dict[str, Any] = {
    "body": {"radius_m": 0.8, "max_speed_mps": 2.0},
    "odometry": {
        "distance_sd_per_sqrt_m": 0.055,
        "lateral_sd_per_sqrt_m": 0.055,
        "turn_sd_per_sqrt_m": 0.002,
        "turn_sd_per_sqrt_rad": 0.005,
        "slip": "off",
    },
    "ranging": {"range_sd_m": 0.55, "range_sd_per_m": 0.0, "anchor_travel_m": 0.5},
    "deployment": {"magazine": 0},
    "planning": {"replan_every_s": 10.0},  # somebody drove it; where our agent would go is only looked at
    "slam": "rslam",
}


@dataclass(frozen=True, slots=True, eq=False)
class PlazaRecording:
    """One robot among nodes: ``motions`` (n, 2) distance and turn up to each of ``stamps`` (n,).

    ``heard`` (n,) is the row of ``ranges_m`` and ``nodes`` made at that stamp, -1 for none.
    """

    stamps: Array
    motions: Array
    heard: Array
    nodes: Array
    ranges_m: Array
    path: Trajectory | None
    places: dict[str, tuple[float, float]]
    name: str = "plaza"
    truth_gap_s: float = 0.5

    @property
    def robots(self) -> tuple[str, ...]:
        """The one robot's id."""
        return (_ROBOT,)

    @property
    def settings(self) -> dict[str, Any]:
        """Overrides of ``AgentConfig`` for this hardware."""
        return _SETTINGS

    def settings_of(self, robot_id: str) -> dict[str, Any]:
        """Return the same: there is one robot."""
        return _SETTINGS

    def start_pose(self, robot_id: str) -> StartPose | None:
        """Return nothing: the map begins where the robot did."""
        return None

    def length(self, robot_id: str) -> int:
        """Return the number of observations."""
        return len(self.stamps)

    def stamps_s(self, robot_id: str) -> Array:
        """Return when each observation was made, (n,), in seconds of the recording's clock."""
        return self.stamps

    def truth(self, robot_id: str) -> Trajectory | None:
        """Return the surveyed path, where its file is there."""
        return self.path

    def tag_places(self) -> dict[str, tuple[float, float]]:
        """Return the surveyed nodes, where their file is there."""
        return self.places

    def observations(self, robot_id: str) -> Iterator[Observation]:
        """Yield one observation at each row of either file; a range goes with the motion up to its stamp."""
        for seq, (stamp, motion, row) in enumerate(zip(self.stamps, self.motions, self.heard, strict=True)):
            heard: tuple[TagSighting, ...] = ()
            if row >= 0:
                heard = (TagSighting(f"N{self.nodes[int(row)]:.0f}", range_m=float(self.ranges_m[int(row)])),)
            yield Observation(
                seq=seq,
                stamp_s=float(stamp),
                odometry=DistanceTurn(float(motion[0]), float(motion[1])),
                tag_sightings=heard,
            )


def load(path: Path, virtual_tags_m: float | None = None) -> PlazaRecording:
    """Read the recording in a folder. Rows that were logged out of order go where their stamp says.

    Raises:
        RecordingError: a file is missing, more than one fits, or one has another shape or impossible values;
            or virtual tags are wanted where there are real ones.
    """
    if virtual_tags_m is not None:
        raise RecordingError("plaza has radio nodes for tags; leave the virtual ones out")
    if not path.is_dir():
        raise RecordingError(f"{path} is no folder; plaza is the folder of *_DR.txt and *_TD.txt")
    driven = _rows(_only(path, "*_DR.txt"), 3)
    heard = _rows(_only(path, "*_TD.txt"), 4)
    heard = heard[(heard[:, 0] >= driven[0, 0]) & (heard[:, 0] <= driven[-1, 0])]
    if (heard[:, 3] < 0.0).any() or (heard[:, 3] > _FARTHEST_M).any():
        raise RecordingError(f"{path}: ranges have to lie between 0 and {_FARTHEST_M:.0f} m")
    stamps = np.concatenate([driven[:, 0], heard[:, 0]])
    order = np.argsort(stamps, kind="stable")
    rows = np.concatenate([np.full(len(driven), -1), np.arange(len(heard))])[order]
    since = np.array([np.interp(stamps[order], driven[:, 0], np.cumsum(driven[:, k])) for k in (1, 2)]).T
    motions = np.diff(since, axis=0, prepend=since[:1])
    truth, places = _truth(path)
    return PlazaRecording(stamps[order], motions, rows, heard[:, 2], heard[:, 3], truth, places)


def _only(folder: Path, pattern: str) -> Path:
    found = sorted(folder.glob(pattern))
    if len(found) != 1:
        raise RecordingError(f"{folder} has to hold one file {pattern}; there are {len(found)}")
    return found[0]


def _rows(path: Path, columns: int) -> Array:
    try:
        rows = np.loadtxt(path, np.float64, ndmin=2)
    except (OSError, ValueError) as error:
        raise RecordingError(f"{path} is no table of numbers: {error}") from error
    if rows.shape[1:] != (columns,) or not len(rows):
        raise RecordingError(
            f"{path} has {rows.shape[-1]} columns and {len(rows)} rows, not {columns} columns"
        )
    if not np.isfinite(rows).all():
        raise RecordingError(f"{path} holds a value that is not finite")
    return rows[np.argsort(rows[:, 0], kind="stable")]


def _truth(folder: Path) -> tuple[Trajectory | None, dict[str, tuple[float, float]]]:
    files = sorted(folder.glob("*.mat"))
    if not files:
        return None, {}
    try:
        arrays = loadmat(files[0])
        path = np.asarray(arrays["GT"], np.float64).reshape(-1, 4)
        nodes = np.asarray(arrays["TL"], np.float64).reshape(-1, 3)
    except Exception as error:  # scipy raises half a dozen kinds for a damaged file
        raise RecordingError(f"{files[0]} is no intact .mat with GT and TL ({error})") from error
    known = np.isfinite(path).all(axis=1)
    places = {f"N{node:.0f}": (float(x), float(y)) for node, x, y in nodes if np.isfinite([x, y]).all()}
    return Trajectory(path[known, 0], path[known, 1:]), places
