"""Errors and normal-equation blocks of the tag graph's factors, each written once.

Poses are (n, 3), tags (m, 2).
"""

from __future__ import annotations

from math import atan2, cos, sin, sqrt

import numpy as np
from numba import njit

from robots.se2 import Array, wrap_array
from robots.types import IntArray


@njit(cache=True)
def edge_errors(poses: Array, pairs: IntArray, measured: Array) -> Array:
    """Return e = (R_i' (t_j - t_i) - t_ij, wrap(theta_j - theta_i - theta_ij)), shape (k, 3), as g2o does."""
    errors = np.empty((pairs.shape[0], 3))
    for k in range(pairs.shape[0]):
        i, j = pairs[k, 0], pairs[k, 1]
        c, s = cos(poses[i, 2]), sin(poses[i, 2])
        dx, dy = poses[j, 0] - poses[i, 0], poses[j, 1] - poses[i, 1]
        turn = poses[j, 2] - poses[i, 2] - measured[k, 2]
        errors[k, 0] = c * dx + s * dy - measured[k, 0]
        errors[k, 1] = -s * dx + c * dy - measured[k, 1]
        errors[k, 2] = atan2(sin(turn), cos(turn))
    return errors


def edge_chi2(errors: Array, information: Array) -> float:
    """Return the sum of e' Omega e over errors (k, 3) and information matrices (k, 3, 3)."""
    return float(np.einsum("ni,nij,nj->", errors, information, errors))


@njit(cache=True)
def edge_jacobian(pose_i: Array, pose_j: Array, linear: bool) -> Array:
    """Return the Jacobian (3, 6) of an edge's error by pose i and pose j.

    Headings are held fixed where ``linear``.
    """
    c, s = cos(pose_i[2]), sin(pose_i[2])
    dx, dy = pose_j[0] - pose_i[0], pose_j[1] - pose_i[1]
    jacobian = np.zeros((3, 6))
    jacobian[0, 0], jacobian[0, 1], jacobian[1, 0], jacobian[1, 1] = -c, -s, s, -c
    jacobian[0, 3], jacobian[0, 4], jacobian[1, 3], jacobian[1, 4] = c, s, -s, c
    if not linear:
        jacobian[0, 2], jacobian[1, 2], jacobian[2, 2] = -s * dx + c * dy, -c * dx - s * dy, -1.0
        jacobian[2, 5] = 1.0
    return jacobian


@njit(cache=True)
def edge_blocks(
    poses: Array, pairs: IntArray, measured: Array, information: Array, linear: bool
) -> tuple[Array, Array]:
    """Return J' Omega J (k, 6, 6) and J' Omega e (k, 6) of every edge."""
    errors = edge_errors(poses, pairs, measured)
    hessians = np.empty((pairs.shape[0], 6, 6))
    gradients = np.empty((pairs.shape[0], 6))
    for k in range(pairs.shape[0]):
        jacobian = edge_jacobian(poses[pairs[k, 0]], poses[pairs[k, 1]], linear)
        weighted = jacobian.T @ information[k]
        hessians[k] = weighted @ jacobian
        gradients[k] = weighted @ errors[k]
    return hessians, gradients


@njit(cache=True)
def sighting_errors(poses: Array, tags: Array, pairs: IntArray, offsets: Array) -> Array:
    """Return e = R_i' (tag - t_i) - offset, shape (s, 2), in the base frame of the sighting pose."""
    errors = np.empty((pairs.shape[0], 2))
    for k in range(pairs.shape[0]):
        i, j = pairs[k, 0], pairs[k, 1]
        c, s = cos(poses[i, 2]), sin(poses[i, 2])
        dx, dy = tags[j, 0] - poses[i, 0], tags[j, 1] - poses[i, 1]
        errors[k, 0] = c * dx + s * dy - offsets[k, 0]
        errors[k, 1] = -s * dx + c * dy - offsets[k, 1]
    return errors


@njit(cache=True)
def sighting_jacobian(pose: Array, tag: Array, linear: bool) -> Array:
    """Return the Jacobian (2, 5) of a sighting's error by the pose and the tag."""
    c, s = cos(pose[2]), sin(pose[2])
    dx, dy = tag[0] - pose[0], tag[1] - pose[1]
    jacobian = np.zeros((2, 5))
    jacobian[0, 0], jacobian[0, 1], jacobian[1, 0], jacobian[1, 1] = -c, -s, s, -c
    jacobian[0, 3], jacobian[0, 4], jacobian[1, 3], jacobian[1, 4] = c, s, -s, c
    if not linear:
        jacobian[0, 2], jacobian[1, 2] = -s * dx + c * dy, -c * dx - s * dy
    return jacobian


@njit(cache=True)
def sighting_blocks(
    poses: Array,
    tags: Array,
    pairs: IntArray,
    offsets: Array,
    information: Array,
    kernel_sd: float,
    linear: bool,
) -> tuple[Array, Array]:
    """Return w J' Omega J (s, 5, 5) and w J' Omega e (s, 5).

    w = kernel / |e| beyond the Huber kernel, else 1.
    """
    errors = sighting_errors(poses, tags, pairs, offsets)
    hessians = np.empty((pairs.shape[0], 5, 5))
    gradients = np.empty((pairs.shape[0], 5))
    for k in range(pairs.shape[0]):
        e = errors[k]
        norm = sqrt(
            e[0] * (information[k, 0, 0] * e[0] + 2.0 * information[k, 0, 1] * e[1])
            + information[k, 1, 1] * e[1] * e[1]
        )
        weight = 1.0 if norm <= kernel_sd else kernel_sd / norm
        jacobian = sighting_jacobian(poses[pairs[k, 0]], tags[pairs[k, 1]], linear)
        weighted = weight * (jacobian.T @ information[k])
        hessians[k] = weighted @ jacobian
        gradients[k] = weighted @ e
    return hessians, gradients


def heading_errors(poses: Array, index: IntArray, headings: Array) -> Array:
    """Return wrap(theta_i - heading), shape (h,)."""
    return wrap_array(poses[index, 2] - headings)


def pose_prior_errors(poses: Array, index: IntArray, priors: Array) -> Array:
    """Return pose - prior with the heading wrapped, shape (p, 3)."""
    errors = poses[index] - priors
    errors[:, 2] = wrap_array(errors[:, 2])
    return errors
