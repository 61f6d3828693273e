"""The sparse factorisation against dense algebra."""

import numpy as np
import pytest

from robots.estimation.graph.cholesky import factorise, solve_factored
from tests.robots.estimation.graph.dense_graphs import dense, room_for


@pytest.mark.parametrize("seed", range(12))
def test_the_factorisation_is_that_of_dense_algebra(seed):
    """Random graphs: trees, pieces, thick ones; whole blocks of zeros keep their places between values."""
    rng = np.random.default_rng([42, seed])
    n = int(rng.integers(1, 60))
    pairs = rng.integers(0, n, (int(rng.integers(0, 4 * n)), 2))  # twice, both ways, from itself to itself
    frame, equations = room_for(n, pairs)
    factor, found = np.empty(frame.panel_start[-1]), np.empty((n, 3))
    assert sorted(frame.vertex) == list(range(n))
    for zeros in (False, True, False):
        equations.beside[:] = 0.0 if zeros else rng.standard_normal(equations.beside.shape)
        roots = rng.standard_normal((n, 3, 3))
        equations.diagonal[:] = roots @ roots.transpose(0, 2, 1) + 40.0 * np.eye(3)
        right = rng.standard_normal((n, 3))
        assert factorise(frame, equations, 0.0, factor)
        solve_factored(frame, factor, right, found)
        expected = np.linalg.solve(dense(equations, pairs), right.ravel())
        np.testing.assert_allclose(found.ravel(), expected, rtol=1e-9, atol=1e-11)


def test_a_matrix_that_is_not_positive_definite_has_no_factor():
    pairs = np.array([[0, 1], [1, 2]])
    frame, equations = room_for(3, pairs)
    equations.diagonal[:], equations.beside[:] = np.eye(3), np.eye(3)
    factor = np.empty(frame.panel_start[-1])
    assert not factorise(frame, equations, 0.0, factor)
    assert factorise(frame, equations, 1.0, factor)  # twice the diagonal: now it is
