"""Tags that were never there: placed along a reference path, sighted where the robot drove over them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robots.se2 import Array

SIGHTING_RADIUS_M = 0.15


@dataclass(frozen=True, slots=True, eq=False)
class VirtualTags:
    """``places_m`` (m, 2) in the reference's frame; ``sighted``: frame -> numbers of the tags read there."""

    places_m: Array
    sighted: dict[int, tuple[int, ...]]


def place_tags(path_m: Array, spacing_m: float, radius_m: float = SIGHTING_RADIUS_M) -> VirtualTags:
    """Put a tag on the path wherever none is nearer than ``spacing_m``, and find the sightings.

    A pass is a maximal run of frames within ``radius_m`` of the tag; the tag is read once in a pass, at the
    frame of closest approach. The path serves for nothing else: what the agent is given is an id at a frame.

    Args:
        path_m: (n, 2) reference positions, NaN where unknown.
        spacing_m: greater than 0.
        radius_m: reach of the reader round the robot.
    """
    known = np.flatnonzero(np.isfinite(path_m).all(axis=1))
    places: list[Array] = []
    for frame in known:
        if not places or np.min(np.linalg.norm(np.array(places) - path_m[frame], axis=1)) >= spacing_m:
            places.append(path_m[frame])
    sighted: dict[int, tuple[int, ...]] = {}
    for number, place in enumerate(places):
        distance = np.linalg.norm(path_m - place, axis=1)
        for run in _runs(distance <= radius_m):
            closest = int(run[np.argmin(distance[run])])
            sighted[closest] = (*sighted.get(closest, ()), number)
    return VirtualTags(np.array(places).reshape(-1, 2), sighted)


def _runs(inside: NDArray[np.bool_]) -> list[NDArray[np.int64]]:
    frames = np.flatnonzero(inside)
    return [run for run in np.split(frames, np.flatnonzero(np.diff(frames) > 1) + 1) if len(run)]
