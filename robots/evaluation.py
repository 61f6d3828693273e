"""How good an estimate is: trajectory errors, relations, consistency, coverage. Metres and radians."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaincinv

from robots.se2 import Array, wrap_array
from robots.trajectory import Trajectory, in_order

MAX_GAP_S = 0.5  # truth is not interpolated over a longer gap
_MAX_RELATION_GAP_S = 3.0


class EvaluationError(ValueError):
    """Two things cannot be compared, or a file cannot be read; the message says why."""


@dataclass(frozen=True, slots=True)
class TrajectoryError:
    """Absolute trajectory error of ``poses`` poses after alignment: root mean square and largest."""

    rmse_m: float
    max_m: float
    poses: int


@dataclass(frozen=True, slots=True)
class RelativeError:
    """Root mean square errors of the motion over ``interval_s``, over ``pairs`` pairs of poses."""

    translation_m: float
    rotation_rad: float
    interval_s: float
    pairs: int


@dataclass(frozen=True, slots=True)
class RelationsError:
    """Mean translational error over ``relations`` relations that could be compared."""

    mean_m: float
    relations: int


@dataclass(frozen=True, slots=True)
class PlacesError:
    """Mean and largest distance of ``places`` places from the true ones, after alignment."""

    mean_m: float
    max_m: float
    places: int


@dataclass(frozen=True, slots=True)
class Consistency:
    """Average normalised estimation error squared of ``samples`` errors and the bounds it should lie in."""

    average: float
    lower: float
    upper: float
    samples: int

    @property
    def consistent(self) -> bool:
        """Whether the average lies within the bounds."""
        return self.lower <= self.average <= self.upper


@dataclass(frozen=True, slots=True, eq=False)
class Alignment:
    """The rigid motion that carries estimates to truth: ``truth = estimate @ rotation.T + translation``."""

    rotation: Array  # (2, 2)
    translation: Array  # (2,)

    def apply(self, positions: Array) -> Array:
        """Map positions, (n, 2) in metres, from the estimate's frame to the truth's."""
        return np.asarray(positions @ self.rotation.T + self.translation)


def align(estimate: Array, truth: Array) -> Alignment:
    """Return the rigid motion that minimises the squared distances of (n, 2) points (Umeyama 1991)."""
    estimate_mean, truth_mean = estimate.mean(axis=0), truth.mean(axis=0)
    left, _, right = np.linalg.svd((truth - truth_mean).T @ (estimate - estimate_mean))  # eq. 38, 39
    reflection = np.diag([1.0, np.sign(np.linalg.det(left) * np.linalg.det(right))])  # eq. 43: no mirroring
    rotation = left @ reflection @ right  # eq. 40
    return Alignment(rotation, truth_mean - rotation @ estimate_mean)  # eq. 41


def absolute_error(estimate: Trajectory, truth: Trajectory, max_gap_s: float = MAX_GAP_S) -> TrajectoryError:
    """Return the absolute trajectory error (ATE) after rigid alignment.

    Truth is interpolated at the estimate's stamps. Poses outside the truth's time, or in one of its gaps of
    ``max_gap_s`` or more, are left out.

    Raises:
        EvaluationError: fewer than three poses can be compared.
    """
    positions, matched = _matched(estimate, truth, max_gap_s)
    aligned = align(positions, matched[:, :2]).apply(positions)
    distances = np.linalg.norm(aligned - matched[:, :2], axis=1)
    return TrajectoryError(float(np.sqrt(np.mean(distances**2))), float(distances.max()), len(distances))


def relative_error(
    estimate: Trajectory, truth: Trajectory, interval_s: float = 1.0, max_gap_s: float = MAX_GAP_S
) -> RelativeError:
    """Return the error of the motion over an interval.

    That is ``(truth_i^-1 truth_j)^-1 (estimate_i^-1 estimate_j)`` of poses i and j.
    Every pose i is paired with the first j at least ``interval_s`` later, where one follows within
    ``max_gap_s``.

    Raises:
        EvaluationError: no pair can be compared.
    """
    estimate = in_order(estimate)
    keep, matched = _interpolated(estimate.stamps_s, truth, max_gap_s)
    stamps, poses = estimate.stamps_s[keep], estimate.poses[keep]
    later = np.searchsorted(stamps, stamps + interval_s)
    first = np.flatnonzero(later < len(stamps))
    first = first[stamps[later[first]] - stamps[first] <= interval_s + max_gap_s]
    if not len(first):
        raise EvaluationError(f"no two compared poses are {interval_s:g} s apart")
    second = later[first]
    of_estimate, of_truth = _motion(poses[first], poses[second]), _motion(matched[first], matched[second])
    error = _motion(of_truth, of_estimate)
    translation = float(np.sqrt(np.mean(np.sum(error[:, :2] ** 2, axis=1))))
    return RelativeError(translation, float(np.sqrt(np.mean(error[:, 2] ** 2))), interval_s, len(first))


def places_error(
    estimate: Mapping[str, tuple[float, float]], truth: Mapping[str, tuple[float, float]]
) -> PlacesError:
    """Return the error of named places, tags for example, after rigid alignment.

    Raises:
        EvaluationError: fewer than three names are in both.
    """
    names = [name for name in estimate if name in truth]
    if len(names) < 3:
        raise EvaluationError(f"only {len(names)} places are known in truth; three are needed")
    found, true = (np.array([places[name] for name in names]) for places in (estimate, truth))
    distances = np.linalg.norm(align(found, true).apply(found) - true, axis=1)
    return PlacesError(float(distances.mean()), float(distances.max()), len(names))


def read_relations(path: Path) -> Array:
    """Read relations: lines ``t1 t2 x y z roll pitch yaw``, pose at t2 in the frame of that at t1; (n, 8).

    Raises:
        EvaluationError: the file cannot be read, or is not eight numbers a line.
    """
    try:
        table = np.atleast_2d(np.loadtxt(path, dtype=np.float64))
    except (OSError, ValueError) as error:
        raise EvaluationError(f"cannot read the relations {path}: {error}") from error
    if table.shape[1] != 8:
        raise EvaluationError(f"{path} has to hold eight numbers a line (t1 t2 x y z roll pitch yaw)")
    return table


def relations_error(estimate: Trajectory, relations: Array) -> RelationsError:
    """Return the mean distance between estimated and given displacements (Kuemmerle et al. 2009).

    Estimated poses are interpolated at t1 and t2; a relation is left out where a stamp lies before the first
    or after the last pose, or between two that are more than 3 s apart.

    Raises:
        EvaluationError: no relation can be compared.
    """
    estimate = in_order(estimate)
    first, first_ok = _at(estimate, relations[:, 0])
    second, second_ok = _at(estimate, relations[:, 1])
    ok = first_ok & second_ok
    if not ok.any():
        raise EvaluationError("no relation lies within the trajectory's time")
    error = _motion(first[ok], second[ok])[:, :2] - relations[ok, 2:4]
    return RelationsError(float(np.mean(np.linalg.norm(error, axis=1))), int(ok.sum()))


def consistency(errors: Array, covariances: Array, confidence: float = 0.95) -> Consistency:
    """Return the average NEES, ``mean(e^T P^-1 e)``, and its chi-square bounds (Bar-Shalom et al. 2001).

    Args:
        errors: (n, d) independent errors, angles wrapped.
        covariances: (n, d, d) what the estimator said of them.
        confidence: probability of a consistent estimator to lie within the bounds.
    """
    samples, dimension = errors.shape
    squared = np.einsum("ni,ni->n", errors, np.linalg.solve(covariances, errors[:, :, None])[:, :, 0])
    lower, upper = (
        2.0
        * float(gammaincinv(samples * dimension / 2.0, tail))
        / samples  # chi-square quantile with n d degrees
        for tail in ((1.0 - confidence) / 2.0, (1.0 + confidence) / 2.0)
    )
    return Consistency(float(squared.mean()), lower, upper, samples)


def coverage(seen: NDArray[np.bool_], observable: NDArray[np.bool_]) -> float:
    """Return cells seen / cells observable, two masks of one shape; cells that no one could see do not count.

    Raises:
        EvaluationError: nothing is observable.
    """
    total = int(observable.sum())
    if not total:
        raise EvaluationError("no cell of the map can be observed")
    return float((seen & observable).sum() / total)


def _matched(estimate: Trajectory, truth: Trajectory, max_gap_s: float) -> tuple[Array, Array]:
    keep, matched = _interpolated(estimate.stamps_s, truth, max_gap_s)
    if len(matched) < 3:
        raise EvaluationError(
            f"only {len(matched)} of {len(estimate)} poses lie within the truth's time and outside its gaps"
            f" of {max_gap_s:g} s; three are needed"
        )
    return estimate.poses[keep, :2], matched


def _interpolated(stamps: Array, truth: Trajectory, max_gap_s: float) -> tuple[NDArray[np.bool_], Array]:
    """Return which stamps the truth covers, (n,), and the true poses at those, (k, 3)."""
    truth = in_order(truth)
    if len(truth) < 2:
        raise EvaluationError("the truth has fewer than two stamped poses")
    keep = (stamps >= truth.stamps_s[0]) & (stamps <= truth.stamps_s[-1])
    following = np.clip(np.searchsorted(truth.stamps_s, stamps), 1, len(truth) - 1)
    keep &= truth.stamps_s[following] - truth.stamps_s[following - 1] < max_gap_s
    return keep, _interpolate(truth, stamps[keep])


def _at(trajectory: Trajectory, stamps: Array) -> tuple[Array, NDArray[np.bool_]]:
    following = np.searchsorted(trajectory.stamps_s, stamps)
    ok = (following > 0) & (following < len(trajectory))
    inside = np.clip(following, 1, max(len(trajectory) - 1, 1))
    if len(trajectory) > 1:
        ok &= trajectory.stamps_s[inside] - trajectory.stamps_s[inside - 1] <= _MAX_RELATION_GAP_S
    return _interpolate(trajectory, stamps), ok


def _interpolate(trajectory: Trajectory, stamps: Array) -> Array:
    times, poses = trajectory.stamps_s, trajectory.poses
    columns = (poses[:, 0], poses[:, 1], np.unwrap(poses[:, 2]))
    return np.column_stack([np.interp(stamps, times, column) for column in columns])


def _motion(first: Array, second: Array) -> Array:
    """Return the second poses in the frames of the first, all (n, 3)."""
    c, s = np.cos(first[:, 2]), np.sin(first[:, 2])
    d = second - first
    return np.column_stack([c * d[:, 0] + s * d[:, 1], -s * d[:, 0] + c * d[:, 1], wrap_array(d[:, 2])])
