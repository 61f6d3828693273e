"""Statistics of paired runs against scipy's own and against what they must say of made-up draws."""

import numpy as np
import pytest
from scipy import stats

from robots.experiments.paired import effect, equivalence, two_way

RNG = np.random.default_rng(3)
FIRST = RNG.normal(300.0, 40.0, 25)
SECOND = FIRST + RNG.normal(20.0, 15.0, 25)


def test_a_paired_effect_is_that_of_the_t_test():
    found, theirs = effect(FIRST, SECOND), stats.ttest_rel(SECOND, FIRST)
    assert found.p == pytest.approx(theirs.pvalue)
    interval = theirs.confidence_interval(0.95)
    assert (found.low, found.high) == pytest.approx((interval.low, interval.high))
    assert found.mean == pytest.approx((SECOND - FIRST).mean())


def test_intervals_cover_the_truth_in_nineteen_of_twenty():
    covered = 0
    for _ in range(400):
        base = RNG.normal(0.0, 40.0, 12)
        found = effect(base, base + RNG.normal(7.0, 20.0, 12))
        covered += found.low <= 7.0 <= found.high
    assert 0.91 < covered / 400 < 0.98


def test_equivalence_is_two_one_sided_tests():
    differences = SECOND - FIRST
    low = stats.ttest_1samp(differences, -30.0, alternative="greater").pvalue
    high = stats.ttest_1samp(differences, 30.0, alternative="less").pvalue
    assert equivalence(FIRST, SECOND, 30.0) == pytest.approx(max(low, high))
    assert equivalence(FIRST, FIRST + RNG.normal(0.0, 5.0, 25), 30.0) < 1e-6
    assert equivalence(FIRST, FIRST + RNG.normal(60.0, 5.0, 25), 30.0) > 0.99


def test_analysis_of_variance_finds_the_factor_that_matters():
    values = RNG.normal(0.0, 10.0, (2, 3, 20)) + 100.0 * RNG.normal(0.0, 1.0, 20)
    values[:, 1] += 30.0
    strategy, coordination, both = two_way(values)
    assert coordination < 1e-6
    assert strategy > 0.01
    assert both > 0.01


def test_of_two_methods_it_is_the_paired_t_test():
    values = np.stack([FIRST, SECOND])[:, None]
    assert two_way(values)[0] == pytest.approx(effect(FIRST, SECOND).p)


def test_one_run_says_nothing_of_chance():
    assert np.isnan(effect(FIRST[:1], SECOND[:1]).p)
    assert np.isnan(equivalence(FIRST[:1], SECOND[:1], 30.0))
    assert np.isnan(two_way(np.zeros((2, 3, 1)))).all()
