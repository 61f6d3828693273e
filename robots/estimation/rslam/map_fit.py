"""How another robot's map of nodes lies in one's own, by the nodes they have in common."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite

import numpy as np
from scipy.stats import chi2

from robots.se2 import Array
from robots.tags.map_memory import TagBelief, WriterMap

_FARTHEST_M = 1e5
_MOST_M2, _LEAST_M2 = 1e4, 1e-4  # variances beyond are absurd; below, a place counts as known to a centimetre
_CHANCE = 1e-3  # a fit worse than one in so many is none
_TURN_SD_RAD = 0.25  # a turn between frames has to be known so well
_FLAT = 0.1  # nodes in a strip so narrow look alike in a mirror


@dataclass(frozen=True, slots=True)
class MapPlaces:
    """Places of nodes in one map: ``ids``, ``places`` (k, 2) in metres, ``spreads`` (k, 2, 2)."""

    ids: tuple[str, ...]
    places: Array
    spreads: Array

    def mirrored(self) -> MapPlaces:
        """Return the map as it looks in a mirror along its x axis."""
        flip = np.diag([1.0, -1.0])
        return MapPlaces(self.ids, self.places @ flip, flip @ self.spreads @ flip)

    def of(self, ids: tuple[str, ...]) -> MapPlaces:
        """Return some of them, in the order given."""
        rows = [self.ids.index(tag_id) for tag_id in ids]
        return MapPlaces(ids, self.places[rows], self.spreads[rows])


@dataclass(frozen=True, slots=True)
class MapFit:
    """Where the other frame lies, (3,) x, y, turn; the other map, mirrored if need be; nodes that agree."""

    frame: Array
    other: MapPlaces
    agreed: tuple[str, ...]


def sane(other: WriterMap) -> MapPlaces:
    """Return the places of a map that can be true: near enough, with a covariance that is one."""
    kept = {each.tag_id: each for each in other.beliefs if _is_sane(each)}
    return to_places(kept)


def to_places(beliefs: Mapping[str, TagBelief]) -> MapPlaces:
    """Return beliefs as arrays."""
    places = np.array([(each.x_m, each.y_m) for each in beliefs.values()], np.float64).reshape(-1, 2)
    rows = [
        ((each.variance_x, each.covariance_xy), (each.covariance_xy, each.variance_y))
        for each in beliefs.values()
    ]
    spreads = np.array(rows, np.float64).reshape(-1, 2, 2) + np.eye(2) * _LEAST_M2
    return MapPlaces(tuple(beliefs), places, spreads)


def fit(mine: MapPlaces, other: MapPlaces, turn_sd_rad: float | None) -> MapFit | None:
    """Return how the other map fits; None while too few nodes are common to tell.

    With a compass the turn is ``turn_sd_rad`` about nothing and one common node is enough; without, two have
    to be apart. Up to a third of the nodes may have moved.

    Raises:
        ValueError: it does not fit.
    """
    common = tuple(tag_id for tag_id in mine.ids if tag_id in other.ids)
    if len(common) < (2 if turn_sd_rad is None else 1):
        return None
    versions = [other]
    if len(common) > 2 and turn_sd_rad is None and not _is_flat(mine.of(common).places):
        versions.append(other.mirrored())
    found = [(_agree(mine, each, common, turn_sd_rad), each) for each in versions]
    fits = [(solved[0], solved, each) for solved, each in found if solved is not None]
    if not fits:
        raise ValueError("the places do not fit")
    _, (_, frame, information, agreed), version = min(fits, key=lambda each: each[0])
    if np.linalg.inv(information)[2, 2] > _TURN_SD_RAD**2:
        return None
    return MapFit(frame, version, agreed)


def _agree(
    mine: MapPlaces, other: MapPlaces, common: tuple[str, ...], turn_sd_rad: float | None
) -> tuple[float, Array, Array, tuple[str, ...]] | None:
    """Return chi-square a degree of freedom, frame, its information, and the nodes that agree."""
    agreed = list(common)
    while True:
        frame, information, distances = _solve(mine.of(tuple(agreed)), other.of(tuple(agreed)), turn_sd_rad)
        freedom = max(2 * len(agreed) - 3 + (turn_sd_rad is not None), 1)
        total = float(distances.sum())
        if total <= chi2.isf(_CHANCE, freedom):
            return total / freedom, frame, information, tuple(agreed)
        if len(agreed) <= 2 or 3 * (len(common) - len(agreed) + 1) > len(common):
            return None
        del agreed[int(np.argmax(distances))]


def _solve(mine: MapPlaces, other: MapPlaces, turn_sd_rad: float | None) -> tuple[Array, Array, Array]:
    """Return the best frame, its information (3, 3), and the squared distance of each node from it."""
    frame = np.zeros(3)
    if turn_sd_rad is None:
        a, b = mine.places - mine.places.mean(axis=0), other.places - other.places.mean(axis=0)
        frame[2] = np.arctan2((b[:, 0] * a[:, 1] - b[:, 1] * a[:, 0]).sum(), (a * b).sum())
    frame[:2] = (mine.places - _moved(frame, other.places)).mean(axis=0)
    prior = 1e-9 if turn_sd_rad is None else 1.0 / turn_sd_rad**2
    for _ in range(5):
        c, s = np.cos(frame[2]), np.sin(frame[2])
        turned = np.array([[c, -s], [s, c]])
        weights = np.linalg.inv(mine.spreads + turned @ other.spreads @ turned.T)
        moved = _moved(frame, other.places)
        off = mine.places - moved
        by_frame = np.tile(np.eye(2, 3), (len(off), 1, 1))
        by_frame[:, 0, 2], by_frame[:, 1, 2] = -(moved[:, 1] - frame[1]), moved[:, 0] - frame[0]
        information = np.einsum("kia,kij,kjb->ab", by_frame, weights, by_frame)
        gradient = np.einsum("kia,kij,kj->a", by_frame, weights, off)
        information[2, 2] += prior
        gradient[2] -= prior * (frame[2] if turn_sd_rad is not None else 0.0)
        frame = frame + np.linalg.solve(information, gradient)
    off = mine.places - _moved(frame, other.places)
    return frame, information, np.einsum("ki,kij,kj->k", off, weights, off)


def _moved(frame: Array, places: Array) -> Array:
    c, s = np.cos(frame[2]), np.sin(frame[2])
    moved: Array = places @ np.array([[c, s], [-s, c]]) + frame[:2]
    return moved


def _is_flat(places: Array) -> bool:
    sizes = np.linalg.svd(places - places.mean(axis=0), compute_uv=False)
    return bool(sizes[1] < _FLAT * sizes[0])


def _is_sane(belief: TagBelief) -> bool:
    xx, xy, yy = belief.variance_x, belief.covariance_xy, belief.variance_y
    numbers = (belief.x_m, belief.y_m, xx, xy, yy)
    if not all(map(isfinite, numbers)) or max(abs(belief.x_m), abs(belief.y_m)) > _FARTHEST_M:
        return False
    return 0.0 < xx <= _MOST_M2 and 0.0 < yy <= _MOST_M2 and xy * xy <= xx * yy
