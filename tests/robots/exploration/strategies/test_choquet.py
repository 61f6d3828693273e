"""Laws of the Choquet integral, and the capacity that Amigoni 2013 prints."""

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.exploration.strategies.choquet import Capacity
from robots.exploration.strategies.mcdm import CAPACITY, WEIGHTS, relative

UNIT = st.floats(0.0, 1.0)
ROWS = st.lists(st.tuples(UNIT, UNIT, UNIT, UNIT), min_size=1, max_size=8).map(np.array)


def groups(criteria):
    return [frozenset(g) for k in range(1, len(criteria)) for g in combinations(criteria, k)]


def test_the_printed_weights_are_a_capacity_with_all_fourteen_groups():
    assert len(WEIGHTS) == 14
    with pytest.raises(ValueError, match="weighs more than a larger one"):
        Capacity("AdPb", {frozenset(g): w for g, w in (WEIGHTS | {"AdP": 0.5}).items()})
    with pytest.raises(ValueError, match="every group"):
        Capacity("AdPb", {frozenset(g): w for g, w in list(WEIGHTS.items())[1:]})
    with pytest.raises(ValueError, match="a criterion that there is not"):
        Capacity("Ad", {frozenset("A"): 0.5, frozenset("x"): 0.5})


def test_by_hand():
    """0.2 of everything, 0.3 more of A, d and b (0.8), 0.4 more of A and d (0.75), 0.1 more of A (0.4)."""
    value = CAPACITY.integral(np.array([[1.0, 0.9, 0.2, 0.5]]))[0]
    assert value == pytest.approx(0.2 + 0.3 * 0.8 + 0.4 * 0.75 + 0.1 * 0.4)


@given(ROWS, st.integers(0, 3), UNIT)
def test_it_never_falls_when_a_criterion_rises(rows, column, by):
    higher = rows.copy()
    higher[:, column] = np.minimum(1.0, higher[:, column] + by)
    assert (CAPACITY.integral(higher) >= CAPACITY.integral(rows) - 1e-12).all()


@given(UNIT)
def test_criteria_that_agree_are_all_there_is_to_say(value):
    assert CAPACITY.integral(np.full((1, 4), value))[0] == pytest.approx(value)


@given(ROWS)
def test_it_lies_between_the_worst_and_the_best_criterion(rows):
    values = CAPACITY.integral(rows)
    assert (values >= rows.min(axis=1) - 1e-12).all()
    assert (values <= rows.max(axis=1) + 1e-12).all()


@given(ROWS, st.tuples(*[st.floats(0.01, 1.0)] * 4))
def test_with_weights_that_add_up_it_is_the_weighted_mean(rows, shares):
    weights = np.array(shares) / sum(shares)
    single = dict(zip("AdPb", weights, strict=True))
    added = Capacity("AdPb", {g: sum(single[c] for c in g) for g in groups("AdPb")})
    np.testing.assert_allclose(added.integral(rows), rows @ weights, atol=1e-9)


def test_a_scale_without_spread_speaks_for_all():
    np.testing.assert_allclose(relative(np.array([2.0, 4.0, 3.0])), [0.0, 1.0, 0.5])
    np.testing.assert_allclose(relative(np.array([2.0, 2.0])), [1.0, 1.0])
