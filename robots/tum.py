"""Trajectory files as the TUM RGB-D benchmark writes them: lines ``stamp x y z qx qy qz qw``."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from robots.se2 import wrap_array
from robots.trajectory import Trajectory


class TumError(ValueError):
    """A trajectory file cannot be read; the message names the file and the line."""


def read_tum(path: Path) -> Trajectory:
    """Read a trajectory; ``#`` begins a comment.

    The heading is ``2 atan2(qz, qw)``: the motion is taken to be planar. Lines holding NaN or infinity are
    left out.

    Raises:
        TumError: the file is missing or empty, or a line is not eight numbers.
    """
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except OSError as error:
        raise TumError(f"cannot read the trajectory {path}: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise TumError(f"cannot read the trajectory {path}: it is not a text file") from error
    rows = [
        row for number, line in enumerate(lines, start=1) if (row := _row(path, number, line)) is not None
    ]
    table = np.array(rows, dtype=np.float64).reshape(-1, 8)
    table = table[np.isfinite(table).all(axis=1)]
    if not len(table):
        raise TumError(f"the trajectory {path} holds no pose")
    headings = wrap_array(2.0 * np.arctan2(table[:, 6], table[:, 7]))
    return Trajectory(table[:, 0], np.column_stack([table[:, 1:3], headings]))


def _row(path: Path, number: int, line: str) -> list[float] | None:
    words = line.split("#", 1)[0].split()
    if not words:
        return None
    if len(words) != 8:
        raise TumError(
            f"{path}, line {number}: expected eight numbers (stamp x y z qx qy qz qw),"
            f" found {len(words)} words"
        )
    try:
        return [float(word) for word in words]
    except ValueError as error:
        raise TumError(f"{path}, line {number}: every word has to be a number") from error


def write_tum(path: Path, trajectory: Trajectory) -> None:
    """Write a trajectory; poses without a stamp are left out."""
    with path.open("w", encoding="utf-8", newline="\n") as file:
        for stamp, (x, y, theta) in zip(trajectory.stamps_s, trajectory.poses, strict=True):
            if np.isfinite(stamp):
                quaternion = f"0 0 {np.sin(theta / 2.0):.9f} {np.cos(theta / 2.0):.9f}"
                file.write(f"{stamp:.6f} {x:.6f} {y:.6f} 0 {quaternion}\n")
