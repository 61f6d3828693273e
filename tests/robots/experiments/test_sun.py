"""Sun 2009's figure and tables: the radio by itself, ways and odometry of the trials, one small trial."""

import numpy as np
import pytest

from robots.experiments import sun_radio, sun_table1, sun_table2
from robots.experiments.experiment import Options
from robots.experiments.radio_course import (
    READINGS,
    STEP_M,
    RadioWorld,
    calibrated,
    mean_error_m,
    measured,
    reckoned,
)
from robots.experiments.sun_table1 import PaperRobot, PaperWorld
from robots.sim.generate import generate

SMALL = PaperWorld(
    "small", "ground", 200.0, 6, (PaperRobot(3.0, 0.3, 0.3, 40.0), PaperRobot(2.0, 0.8, 0.6, 30.0))
)


@pytest.fixture(scope="module")
def air() -> RadioWorld:
    random = np.random.default_rng(1)
    return RadioWorld(generate("open", 150.0, random), 5, 7, random)


def test_the_mean_of_ten_lies_on_the_model_and_outliers_are_left_out(tmp_path):
    rows = sun_radio.measure(Options(60, seed=2))
    assert [row["distance_m"] for row in rows] == list(sun_radio.DISTANCES_M)
    for row in rows:
        assert row["rssi_dbm"] == pytest.approx(row["model_dbm"], abs=2.0)
    spreads = [[row["rssi_sd_db"], row["plain_rssi_sd_db"]] for row in rows]
    assert np.diff(np.mean(spreads, axis=0))[0] > 0.2
    assert rows[-1]["estimate_sd_m"] > 3.0 * rows[2]["estimate_sd_m"]
    sun_radio.draw(rows, tmp_path / "radio.png")
    assert (tmp_path / "radio.png").stat().st_size > 1000


def test_ways_are_free_and_as_long_as_asked(air):
    course = air.drive(40.0, np.random.default_rng(2))
    steps = course.motions
    assert len(course.poses) == pytest.approx(40.0 / STEP_M, abs=1)
    assert steps[:, 0].max() <= STEP_M + 1e-9
    assert all(len(readings) == READINGS for heard in course.heard for _, readings in heard)


def test_exact_odometry_reckons_the_true_way_and_noise_is_as_asked(air):
    courses = [air.drive(60.0, np.random.default_rng(k)) for k in range(3)]
    exact = measured(courses[0], 0.0, np.random.default_rng(0))
    assert mean_error_m(reckoned(courses[0], exact), courses[0]) < 1e-6
    level = calibrated(courses, [4, 5, 6], 3.0)
    errors = [
        mean_error_m(reckoned(c, measured(c, level, np.random.default_rng(seed))), c)
        for c, seed in zip(courses, (4, 5, 6), strict=True)
    ]
    assert np.mean(errors) == pytest.approx(3.0, rel=0.05)


def test_a_survey_finds_the_radio_where_nothing_is_in_the_way():
    random = np.random.default_rng(3)
    radio = sun_table1._air(SMALL, random).survey(random)
    assert radio.path_loss_exponent == pytest.approx(2.0, abs=0.4)
    assert radio.power_at_1m_dbm == pytest.approx(-12.0, abs=4.0)


def test_a_small_trial_beats_odometry_and_comes_out_the_same_again(tmp_path):
    rows = sun_table1.measure(Options(1, seed=1), (SMALL,))
    assert [row["robot"] for row in rows] == [1, 2]
    assert rows[0]["single_m"] == rows[0]["multi_m"]
    assert rows[0]["multi_by_single"] is None
    assert np.mean([row["multi_m"] for row in rows]) < np.mean([row["odometry_m"] for row in rows])
    assert rows == sun_table1.measure(Options(1, seed=1), (SMALL,))
    sun_table1.EXPERIMENT.plot(rows, tmp_path / "table.png")
    assert (tmp_path / "table.png").stat().st_size > 1000


def test_worlds_are_the_papers():
    assert [(w.area_m2, w.nodes, len(w.robots)) for w in sun_table1.WORLDS] == [
        (109.0, 7, 2), (250.0, 8, 2), (846.0, 14, 2), (1975.0, 58, 2), (3819.0, 58, 2), (4529.0, 60, 4),
    ]  # fmt: skip
    assert [robot.length_m for robot in sun_table2.OUTDOOR.robots] == [410.0, 348.0, 320.0, 282.0]
