"""Fusion of two Gaussian estimates of one pose (Kleiner 2006 eq. 3 and 4)."""

from __future__ import annotations

import numpy as np

from robots.se2 import Array, GaussianPose, Pose2, wrap


def fuse(predicted: GaussianPose, matched: GaussianPose) -> GaussianPose:
    """Return the information-weighted mean of the odometry's pose l and the scan matcher's pose k.

    Both in one frame and independent. The angle is averaged on the circle: k's heading is first brought next
    to l's. Eq. (4) is used with its outer inverse, which the scanned text lacks.

    Raises:
        numpy.linalg.LinAlgError: a covariance is singular.
    """
    information_l = np.linalg.inv(predicted.covariance)
    information_k = np.linalg.inv(matched.covariance)
    covariance = np.linalg.inv(information_l + information_k)  # (4)
    l = predicted.mean.as_array()  # noqa: E741 - the paper's name
    k = matched.mean.as_array()
    k[2] = l[2] + wrap(k[2] - l[2])
    mean = covariance @ (information_l @ l + information_k @ k)  # (3)
    return GaussianPose(Pose2.from_array(mean), (covariance + covariance.T) / 2.0)


def at_least(covariance: Array, floor: Array) -> Array:
    """Return the smallest covariance (n, n) that claims less than either in every direction.

    In the axes in which both are diagonal the larger of the two counts.
    """
    lower = np.linalg.cholesky(covariance + 1e-12 * np.eye(len(covariance)))
    inverse = np.linalg.inv(lower)
    shares, axes = np.linalg.eigh(inverse @ floor @ inverse.T)
    if shares[-1] <= 1.0:
        return covariance
    widened = lower @ axes
    larger: Array = (widened * np.maximum(shares, 1.0)) @ widened.T
    return (larger + larger.T) / 2.0
