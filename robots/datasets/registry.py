"""The formats there are, by the name the command line has for them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from robots.datasets import csail, intel, mission_log, mrclam, plaza
from robots.datasets.recording import Recording, RecordingError

DATASETS: dict[str, Callable[[Path, float | None], Recording]] = {
    "csail": csail.load,
    "intel": intel.load,
    "log": mission_log.load,
    "mrclam": mrclam.load,
    "plaza": plaza.load,
}


def load(dataset: str, path: Path, virtual_tags_m: float | None = None) -> Recording:
    """Read a recording, with a virtual tag on its reference path every ``virtual_tags_m`` if given.

    Raises:
        RecordingError: the format is unknown, or the file is not of it.
    """
    if dataset not in DATASETS:
        known = sorted([*DATASETS, "g2o"])  # a pose graph has nothing to observe: pose_graph_replay
        raise RecordingError(f"there is no dataset {dataset!r}; known are {', '.join(known)}")
    return DATASETS[dataset](path, virtual_tags_m)
