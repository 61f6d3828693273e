"""Signal and distance: one is the inverse of the other, and what is claimed of the range holds."""

from math import exp, inf, log, nan, pi, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robots.config import AgentConfig, ConfigError, RadioConfig
from robots.estimation.radio.model import ENVIRONMENTS, NEAREST_M, NODE, UHF, RadioModel, radio_for
from robots.overrides import override

powers = st.floats(-80.0, 10.0)
exponents = st.floats(1.2, 5.0)
distances = st.floats(NEAREST_M, 1e4)


def model(**changes) -> RadioModel:
    return RadioModel(RadioConfig(**{"shadowing_sd_db": 3.0, "fading_sd_db": 0.0, "reach_m": 1e6, **changes}))


@given(powers, exponents, distances)
def test_distance_is_the_inverse_of_the_signal(power, exponent, distance):
    radio = model(power_at_1m_dbm=power, path_loss_exponent=exponent)
    assert radio.distance_m(radio.signal_dbm(distance)) == pytest.approx(distance, rel=1e-9)
    assert radio.signal_dbm(1.0) == power
    assert radio.signal_dbm(10.0) == pytest.approx(power - 10.0 * exponent)


@given(powers, exponents, distances, distances)
def test_further_is_weaker(power, exponent, one, two):
    radio = model(power_at_1m_dbm=power, path_loss_exponent=exponent)
    near, far = sorted((one, two))
    assert radio.signal_dbm(near) >= radio.signal_dbm(far)


def test_the_papers_radios():
    uhf, node = RadioModel(UHF), RadioModel(NODE)
    assert uhf.signal_dbm(1.0) == -31.7
    assert node.signal_dbm(1.0) == -12.0
    assert node.signal_dbm(10.0) == -32.0
    assert (UHF.reach_m, NODE.reach_m) == (4.0, 35.0)
    front, rear = uhf.direction("front"), uhf.direction("rear")
    assert front.base_from_antenna.theta == 0.0
    assert abs(rear.base_from_antenna.theta) == pytest.approx(pi)
    assert rear.base_from_antenna.x < 0.0 < front.base_from_antenna.x
    assert front.bearing_rad == rear.bearing_rad == 0.0
    assert front.bearing_sd_rad == pytest.approx(np.radians(60.0) / sqrt(12.0))
    assert node.direction(None).bearing_rad is None


@pytest.mark.parametrize("environment", ENVIRONMENTS)
def test_buildings_set_exponent_and_deviation(environment):
    uhf = radio_for("uhf", environment)
    assert (uhf.path_loss_exponent, uhf.shadowing_sd_db) == ENVIRONMENTS[environment]
    assert (uhf.power_at_1m_dbm, uhf.reach_m) == (-31.7, 4.0)
    node = RadioModel(radio_for("node", environment))
    assert node.config.path_loss_exponent == ENVIRONMENTS[environment][0]
    if environment != "open":
        assert node.shadowing_sd_db(20.0) == ENVIRONMENTS[environment][1]


def test_an_unknown_building_is_refused():
    with pytest.raises(ValueError, match="environment 'cave' is unknown; known are grocery"):
        radio_for("node", "cave")


def test_the_table_of_deviations_is_interpolated():
    radio = model(table_distances_m=(1.0, 11.0), table_sds_db=(1.0, 3.0))
    assert radio.shadowing_sd_db(0.1) == 1.0
    assert radio.shadowing_sd_db(6.0) == pytest.approx(2.0)
    assert radio.shadowing_sd_db(100.0) == 3.0


def test_readings_average_their_fading_away_but_not_the_shadow():
    radio = model(shadowing_sd_db=3.0, fading_sd_db=4.0)
    per_db = log(10.0) / 20.0
    assert radio.log_sd(5.0) == pytest.approx(5.0 * per_db)
    assert radio.log_sd(5.0, 16) == pytest.approx(sqrt(10.0) * per_db)
    assert radio.log_sd(5.0, 10**9) == pytest.approx(3.0 * per_db)


@given(st.floats(0.5, 6.0), st.floats(1.5, 4.0), st.floats(3.0, 30.0))
@settings(max_examples=40)
def test_mean_and_deviation_are_those_of_the_likelihood(sd_db, exponent, reach):
    radio = model(shadowing_sd_db=sd_db, path_loss_exponent=exponent, reach_m=reach)
    found = radio.range_of(radio.signal_dbm(3.0))
    d = np.linspace(1e-4, min(reach, 3.0 * exp(12.0 * found.log_sd)), 100_001)
    likelihood = np.exp(-((np.log(d) - log(3.0)) ** 2) / (2.0 * found.log_sd**2))
    mean = np.sum(d * likelihood) / np.sum(likelihood)
    sd = sqrt(np.sum((d - mean) ** 2 * likelihood) / np.sum(likelihood))
    assert found.range_m == pytest.approx(mean, rel=0.01)
    assert found.sd_m == pytest.approx(sd, rel=0.02)
    assert found.median_m == pytest.approx(3.0)
    assert found.range_m <= reach


def test_a_signal_too_weak_for_the_reach_is_no_precise_one():
    radio = model(reach_m=4.0)
    behind_walls, at_reach = radio.range_of(-90.0), radio.range_of(radio.signal_dbm(4.0))
    assert (behind_walls.range_m, behind_walls.sd_m) == (at_reach.range_m, at_reach.sd_m)
    assert behind_walls.sd_m > 0.1 * behind_walls.range_m


def test_weighted_ranges_average_to_the_true_distance():
    radio, rng = model(shadowing_sd_db=2.5), np.random.default_rng(1)
    signals = radio.signal_dbm(8.0) + 2.5 * rng.standard_normal(10_000)
    found = [radio.range_of(float(signal)) for signal in signals]
    ranges, sds = (np.array([getattr(each, name) for each in found]) for name in ("range_m", "sd_m"))
    assert np.average(ranges, weights=sds**-2) == pytest.approx(8.0, rel=0.02)
    medians = np.array([each.median_m for each in found])
    assert np.average(medians, weights=medians**-2.0) < 7.2  # what the correction is for
    inside = np.abs(ranges - 8.0) < 2.0 * sds
    assert 0.9 < inside.mean() < 0.99


def test_without_noise_the_range_is_exact():
    radio = model(shadowing_sd_db=0.0)
    found = radio.range_of(radio.signal_dbm(7.0))
    assert found.range_m == pytest.approx(7.0)
    assert 0.0 < found.sd_m < 1e-3


@given(st.floats(-400.0, 200.0), st.integers(0, 20))
def test_any_signal_gives_a_range_within_reach(rssi, readings):
    for config in (UHF, NODE, radio_for("uhf", "office1"), radio_for("node", "retail")):
        found = RadioModel(config).range_of(rssi, readings)
        assert 0.0 < found.range_m <= config.reach_m * (1.0 + 1e-9)
        assert 0.0 < found.sd_m <= config.reach_m


@pytest.mark.parametrize("rssi", [nan, inf, -inf])
def test_a_signal_that_is_none_is_refused(rssi):
    with pytest.raises(ValueError, match="a signal has to be a finite number of dBm"):
        RadioModel(NODE).range_of(rssi)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"table_distances_m": [1.0]}, "have to be of one length"),
        ({"table_distances_m": [2.0, 1.0], "table_sds_db": [1.0, 1.0]}, "has to rise"),
        ({"table_distances_m": 3.0}, r"config\.radio\.table_distances_m has to be a list of at most 100"),
        ({"table_sds_db": ["a"]}, r"config\.radio\.table_sds_db has to be a finite number"),
        ({"table_sds_db": [-1.0], "table_distances_m": [1.0]}, "has to be 0 or more"),
        ({"table_sds_db": [1.0] * 101}, "at most 100 numbers"),
        ({"path_loss_exponent": 0.0}, r"config\.radio\.path_loss_exponent has to be more than 0"),
    ],
)
def test_settings_of_a_radio_are_checked(changes, message):
    with pytest.raises(ConfigError, match=message):
        override(AgentConfig(), {"radio": changes})


def test_a_table_comes_in_as_lists():
    config = override(AgentConfig(), {"radio": {"table_distances_m": [1, 10], "table_sds_db": [2, 4.5]}})
    assert config.radio.table_distances_m == (1.0, 10.0)
    assert RadioModel(config.radio).shadowing_sd_db(10.0) == 4.5
