"""What every recording of a real robot offers, whatever its file format."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from robots.se2 import Array
from robots.team import StartPose
from robots.trajectory import Trajectory
from robots.types import Observation

T = TypeVar("T")


class RecordingError(ValueError):
    """A recording cannot be read; the message names the file and what is wrong in it."""


class Recording(Protocol):
    """A day of real robots, as observations in the order they were made."""

    @property
    def name(self) -> str:
        """The format's name, as the command line has it."""

    @property
    def robots(self) -> tuple[str, ...]:
        """Ids of the robots in it."""

    @property
    def settings(self) -> dict[str, Any]:
        """Overrides of ``AgentConfig`` that describe the hardware it was made with."""

    def settings_of(self, robot_id: str) -> dict[str, Any]:
        """Return the overrides for one robot, where they differ."""

    def start_pose(self, robot_id: str) -> StartPose | None:
        """Return where the robot started in the world, where that was surveyed."""

    def length(self, robot_id: str) -> int:
        """Return how many observations the robot made."""

    def observations(self, robot_id: str) -> Iterator[Observation]:
        """Yield them; ``seq`` from 0, ``stamp_s`` never falls, so it can be later than what was recorded."""

    def stamps_s(self, robot_id: str) -> Array:
        """Return the stamp of each observation on the recording's own clock, (n,), NaN where it has none."""

    def truth(self, robot_id: str) -> Trajectory | None:
        """Return where the robot really was, where someone knows."""

    def tag_places(self) -> dict[str, tuple[float, float]]:
        """Return where tags really are, where someone knows, in the truth's frame."""

    @property
    def truth_gap_s(self) -> float:
        """Poses of the truth further apart than this are not interpolated between."""


def array_names(path: Path) -> tuple[str, ...]:
    """Return the names of the arrays in an ``.npz`` file.

    Raises:
        RecordingError: the file cannot be read.
    """
    return _read(path, lambda archive: tuple(archive.files))


def load_arrays(path: Path, shapes: dict[str, tuple[int | None, ...]]) -> dict[str, NDArray[Any]]:
    """Read numeric arrays from an ``.npz`` file.

    Args:
        path: the file.
        shapes: the names needed and the shape of each; ``None`` stands for any length, the same for every
            array.

    Raises:
        RecordingError: the file cannot be read, or an array is missing, is not numeric or has another shape.
    """

    def read(archive: Any) -> dict[str, NDArray[Any]]:
        missing = [name for name in shapes if name not in archive.files]
        if missing:
            raise RecordingError(f"{path} has no array {missing[0]!r}; it holds {', '.join(archive.files)}")
        return {name: np.asarray(archive[name]) for name in shapes}

    arrays = _read(path, read)
    for name, array in arrays.items():
        if array.dtype.kind not in "fiu":
            raise RecordingError(f"{path}: array {name!r} has to hold numbers, not {array.dtype}")
    length = next(iter(arrays.values())).shape[:1]
    for name, array in arrays.items():
        wanted = tuple(size if size is not None else (length or (0,))[0] for size in shapes[name])
        if array.shape != wanted:
            raise RecordingError(f"{path}: array {name!r} has shape {array.shape}, expected {wanted}")
    return arrays


def _read(path: Path, work: Callable[[Any], T]) -> T:
    try:
        with path.open("rb") as file:  # numpy would leave it open when it turns out to be damaged
            archive = np.load(file, allow_pickle=False)
            if isinstance(archive, np.ndarray):
                raise RecordingError(f"{path} is a single array, not an .npz recording")
            return work(archive)
    except RecordingError:
        raise
    except FileNotFoundError as error:
        raise RecordingError(f"there is no recording {path}") from error
    except OSError as error:
        raise RecordingError(f"cannot read the recording {path}: {error.strerror or error}") from error
    except Exception as error:  # numpy and zipfile raise half a dozen kinds for a damaged file
        raise RecordingError(f"{path} is not an intact .npz recording; fetch it again") from error
