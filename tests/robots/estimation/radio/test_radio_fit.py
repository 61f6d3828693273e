"""The fit finds the radio that made the readings, whatever spikes are among them."""

from dataclasses import replace
from math import inf, nan

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robots.config import RadioConfig
from robots.estimation.radio.fit import FitError, Signals, fit_radio
from robots.estimation.radio.model import RadioModel

RADIO = RadioConfig(
    power_at_1m_dbm=-40.0, path_loss_exponent=2.4, shadowing_sd_db=4.0, fading_sd_db=2.0, reach_m=40.0
)


def readings(radio=RADIO, places=400, each=8, seed=1):
    rng = np.random.default_rng(seed)
    distances = np.repeat(rng.uniform(0.5, 25.0, places), each)
    mean = np.vectorize(RadioModel(radio).signal_dbm)(distances)
    shadow = np.repeat(radio.shadowing_sd_db * rng.standard_normal(places), each)
    fading = radio.fading_sd_db * rng.standard_normal(places * each)
    numbers = np.repeat(np.arange(places), each)
    return Signals(distances, mean + shadow + fading, numbers, numbers)


@given(st.floats(-80.0, 0.0), st.floats(0.5, 5.0))
@settings(max_examples=20)
def test_without_noise_the_fit_is_exact(power, exponent):
    radio = replace(
        RADIO,
        power_at_1m_dbm=power,
        path_loss_exponent=exponent,
        shadowing_sd_db=0.0,
        fading_sd_db=0.0,
    )
    found = fit_radio(readings(radio))
    assert found.power_at_1m_dbm == pytest.approx(power, abs=1e-6)
    assert found.path_loss_exponent == pytest.approx(exponent, abs=1e-6)
    assert found.sigma_db < 1e-6


def test_numbers_and_both_deviations_are_found_over_seeds():
    found = [fit_radio(readings(seed=seed)) for seed in range(30)]
    assert np.mean([f.shadowing_sd_db for f in found]) == pytest.approx(4.0, rel=0.03)
    assert np.mean([f.fading_sd_db for f in found]) == pytest.approx(2.0, rel=0.03)
    assert np.mean([f.sigma_db for f in found]) == pytest.approx(np.hypot(4.0, 2.0), rel=0.03)
    scores = [(f.path_loss_exponent - 2.4) / f.exponent_sd for f in found]
    assert 0.6 < np.sqrt(np.mean(np.square(scores))) < 1.4  # the deviation claimed is the one there is
    scores = [(f.power_at_1m_dbm + 40.0) / f.power_sd_db for f in found]
    assert 0.6 < np.sqrt(np.mean(np.square(scores))) < 1.4


def test_spikes_are_left_out():
    clean = readings()
    rng = np.random.default_rng(2)
    spiked = rng.random(len(clean.rssis_dbm)) < 0.1
    dirty = replace(clean, rssis_dbm=clean.rssis_dbm + np.where(spiked, 60.0, 0.0))
    found, wanted = fit_radio(dirty), fit_radio(clean)
    assert found.power_at_1m_dbm == pytest.approx(wanted.power_at_1m_dbm, abs=0.3)
    assert found.path_loss_exponent == pytest.approx(wanted.path_loss_exponent, abs=0.03)
    assert found.outliers == pytest.approx(spiked.sum(), abs=20)
    assert found.sigma_all_db > 3.0 * found.sigma_db


def test_the_order_of_the_readings_does_not_matter():
    one = readings()
    order = np.random.default_rng(3).permutation(len(one.rssis_dbm))
    other = Signals(*(getattr(one, name)[order] for name in Signals.__slots__))
    assert fit_radio(other).path_loss_exponent == pytest.approx(fit_radio(one).path_loss_exponent)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"distances_m": np.full(3200, 3.0)}, "nearly the same distance"),
        ({"rssis_dbm": np.full(3200, nan)}, "not finite"),
        ({"distances_m": np.full(3200, inf)}, "not finite"),
        ({"rssis_dbm": readings().distances_m - 60.0}, "does not fall"),
    ],
)
def test_readings_that_tell_nothing_are_refused(change, words):
    with pytest.raises(FitError, match=words):
        fit_radio(replace(readings(), **change))


def test_too_few_readings_are_refused():
    with pytest.raises(FitError, match="there are 8 readings with a known distance; 20 are needed"):
        fit_radio(readings(places=1))
