"""Means of readings: what does not fit is left out, and no place speaks twice."""

import pickle
from math import nan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.config import RadioConfig
from robots.estimation.radio.signal_mean import SignalAverager, robust_mean

signals = st.lists(st.floats(-100.0, 0.0), min_size=2, max_size=10)


@given(signals, st.randoms())
def test_the_order_of_readings_does_not_matter(readings, random):
    shuffled = list(readings)
    random.shuffle(shuffled)
    assert robust_mean(np.array(readings), 2.0) == robust_mean(np.array(shuffled), 2.0)


@given(signals)
def test_a_mean_lies_among_the_readings_that_it_says_agree(readings):
    mean = robust_mean(np.array(readings), 2.0)
    if mean is not None:
        assert min(readings) - 1e-9 <= mean.rssi_dbm <= max(readings) + 1e-9
        assert mean.readings + mean.rejected == len(readings)
        assert 2 * mean.readings >= len(readings)
        near = np.abs(np.array(readings) - mean.rssi_dbm) <= 2 * 2.5 * np.sqrt(1.5) * 2.0
        assert near.sum() >= mean.readings


@pytest.mark.parametrize("outliers", [0, 1, 3, 4])
def test_spikes_do_not_move_the_mean(outliers):
    rng = np.random.default_rng(outliers)
    errors = []
    for _ in range(200):
        readings = -40.0 + 2.0 * rng.standard_normal(10)
        readings[:outliers] += rng.choice([-1.0, 1.0], outliers) * rng.uniform(15.0, 40.0, outliers)
        mean = robust_mean(readings, 2.0)
        assert mean is not None
        errors.append(mean.rssi_dbm + 40.0)
    assert np.std(errors) < 1.4 * 2.0 / np.sqrt(10 - outliers)
    assert abs(np.mean(errors)) < 0.25


def test_readings_that_agree_in_nothing_have_no_mean():
    assert robust_mean(np.array([-10.0, -40.0, -70.0, -100.0]), 2.0) is None
    assert robust_mean(np.array([-10.0]), 2.0) is None
    assert robust_mean(np.zeros(0), 2.0) is None


def test_equal_readings_without_fading():
    mean = robust_mean(np.full(5, -33.0), 0.0)
    assert mean is not None
    assert (mean.rssi_dbm, mean.readings) == (-33.0, 5)


def gathered(averager: SignalAverager, tag_id: str, places) -> list[int]:
    return [k for k, at in enumerate(places) if averager.add(tag_id, None, -40.0, at) is not None]


def test_ten_readings_make_a_mean():
    averager = SignalAverager(RadioConfig())
    assert gathered(averager, "N1", [0.0] * 25) == [9]  # and the same place does not speak again


def test_after_the_next_half_metre_there_is_a_new_mean_from_readings_made_there():
    averager = SignalAverager(RadioConfig())
    for _ in range(10):
        averager.add("N1", None, -40.0, 0.0)
    means = [averager.add("N1", None, -50.0, 0.05 * k) for k in range(1, 31)]
    given_at = [k for k, mean in enumerate(means, 1) if mean is not None]
    assert given_at == [10, 20, 30]
    assert all(mean.rssi_dbm == -50.0 for mean in means if mean is not None)


def test_a_robot_that_drives_past_gets_a_mean_of_the_few_it_heard():
    averager = SignalAverager(RadioConfig())
    assert gathered(averager, "N1", [0.0, 0.2, 0.4, 0.6]) == [3]
    assert gathered(averager, "N2", [0.0, 2.0, 4.0, 6.0, 8.0]) == []  # never three within half a metre


def test_tags_and_antennas_have_readings_of_their_own():
    averager = SignalAverager(RadioConfig(readings=2))
    assert averager.add("N1", "front", -40.0, 0.0) is None
    assert averager.add("N1", "rear", -40.0, 0.0) is None
    assert averager.add("N2", "front", -40.0, 0.0) is None
    assert averager.add("N1", "front", -40.0, 0.0) is not None


def test_an_averager_comes_back_from_a_snapshot():
    one = SignalAverager(RadioConfig())
    gathered(one, "N1", np.linspace(0.0, 1.0, 17))
    two = pickle.loads(pickle.dumps(one))
    places = np.linspace(1.0, 3.0, 40)
    assert gathered(one, "N1", places) == gathered(two, "N1", places)


@pytest.mark.parametrize("values", [[nan, -1.0], [-1.0, np.inf]])
def test_a_reading_that_is_none_is_refused(values):
    with pytest.raises(ValueError, match="finite number of dBm"):
        robust_mean(np.array(values), 2.0)
    with pytest.raises(ValueError, match="finite number of dBm"):
        SignalAverager(RadioConfig()).add("N1", None, nan, 0.0)
