"""The tag graph written anew with numpy alone: what the solver is held against."""

from math import pi

import numpy as np
from scipy.optimize import least_squares

from robots.estimation.graph.factors import Equations
from robots.estimation.graph.order import Order, order
from robots.estimation.graph.solve import GraphProblem

NO_KERNEL = 1e9


def whitened(problem: GraphProblem, kernel_sd: float, values: np.ndarray) -> np.ndarray:
    """Residuals whose sum of squares is W of eq. (5), written anew with numpy alone."""
    n = len(problem.poses)
    poses, tags = values[: 3 * n].reshape(-1, 3), values[3 * n :].reshape(-1, 2)
    parts = []
    for (i, j), z, covariance in zip(
        problem.edge_pairs, problem.edge_poses, problem.edge_covariances, strict=True
    ):
        c, s = np.cos(poses[i, 2]), np.sin(poses[i, 2])
        at = np.array([[c, s], [-s, c]]) @ (poses[j, :2] - poses[i, :2]) - z[:2]
        turn = (poses[j, 2] - poses[i, 2] - z[2] + pi) % (2 * pi) - pi
        parts.append(np.linalg.solve(np.linalg.cholesky(covariance), np.array([*at, turn])))
    for (i, k), z, covariance in zip(
        problem.sighting_pairs, problem.sighting_offsets, problem.sighting_covariances, strict=True
    ):
        c, s = np.cos(poses[i, 2]), np.sin(poses[i, 2])
        error = np.array([[c, s], [-s, c]]) @ (tags[k] - poses[i, :2]) - z
        error = np.linalg.solve(np.linalg.cholesky(covariance), error)
        size = np.sqrt(error @ error)
        if size > kernel_sd:  # Huber: W grows linearly from there
            error = error / size * np.sqrt(2.0 * kernel_sd * size - kernel_sd**2)
        parts.append(error)
    off = poses[problem.prior_index] - problem.prior_poses
    off[:, 2] = (off[:, 2] + pi) % (2 * pi) - pi
    parts.append((off / problem.prior_sds).ravel())
    turned = (poses[problem.heading_index, 2] - problem.heading_rad + pi) % (2 * pi) - pi
    parts.append(turned / problem.heading_sd_rad)
    return np.concatenate(parts)


def reference(problem: GraphProblem, kernel_sd: float) -> tuple[np.ndarray, np.ndarray, float]:
    start = np.concatenate([problem.poses.ravel(), problem.tags.ravel()])
    found = least_squares(
        lambda x: whitened(problem, kernel_sd, x), start, xtol=1e-14, ftol=1e-14, gtol=1e-12
    )
    n = 3 * len(problem.poses)
    return found.x[:n].reshape(-1, 3), found.x[n:].reshape(-1, 2), 2.0 * float(found.cost)


def room_for(count: int, pairs: np.ndarray) -> tuple[Order, Equations]:
    frame, slot, turned = order(count, pairs)
    blocks = np.empty((len(frame.entries), 3, 3))
    return frame, Equations(slot, turned, np.empty((count, 3, 3)), blocks, np.empty((count, 3)))


def dense(equations: Equations, pairs: np.ndarray) -> np.ndarray:
    """The whole matrix of the normal equations."""
    n = len(equations.diagonal)
    matrix = np.zeros((n, 3, n, 3))
    for i in range(n):
        matrix[i, :, i] = equations.diagonal[i]
    for (a, b), slot, turned in zip(pairs, equations.slot, equations.turned, strict=True):
        if slot >= 0:
            block = equations.beside[slot] if turned else equations.beside[slot].T  # a by b
            matrix[a, :, b], matrix[b, :, a] = block, block.T
    return matrix.reshape(3 * n, 3 * n)
