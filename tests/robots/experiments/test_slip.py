"""The slip experiment: rows from runs, a small run for real, and what is said where physics is missing."""

import sys

import numpy as np
import pytest

from robots.estimation.slip.detector import SlipDetector
from robots.experiments import slip
from robots.experiments.experiment import ExperimentError, Options
from robots.sim.physics.fit import Verdict
from robots.sim.physics.kinematic import drive_kinematic
from robots.sim.physics.labels import true_motion


def results():
    return [
        [
            slip.Measured("none", None, None, 10.0 + k, 0.1),
            slip.Measured("basic", Verdict(0.2, 0.1 * k), Verdict(0.3, 0.0), 8.0, 0.1),
            slip.Measured("boosted", Verdict(0.2, 0.0), None, None, 0.1),
            slip.Measured("extended", Verdict(0.1, 0.1), Verdict(0.2, 0.0), 6.0, 0.1),
        ]
        for k in range(2)
    ]


def test_rows_are_mean_and_deviation_over_runs(tmp_path):
    rows = slip.rows_of(results())
    assert [row["detector"] for row in rows] == ["none", "basic", "boosted", "extended"]
    assert rows[0]["balanced_accuracy"] is None
    assert (rows[0]["drift_percent"], rows[0]["drift_percent_sd"]) == (10.5, 0.5)
    assert rows[1]["balanced_accuracy"] == pytest.approx(0.875)
    assert rows[1]["balanced_accuracy_sd"] == pytest.approx(0.025)
    assert (rows[2]["balanced_accuracy"], rows[2]["drift_percent"]) == (pytest.approx(0.9), None)
    assert all(column.value in row for column in slip.EXPERIMENT.columns for row in rows)
    pytest.importorskip("matplotlib")
    slip.plot(rows, tmp_path / "slip.png")
    assert (tmp_path / "slip.png").stat().st_size > 5_000


def test_drift_is_what_the_wheels_count_too_much():
    firm = drive_kinematic(3, 20.0, level=0, slippery=False)
    assert slip.drift_percent(firm, None) < 1.5  # noise of the yaw alone
    slick = drive_kinematic(5, 40.0, level=0, slippery=True)
    assert true_motion(slick).slips.mean() > 0.02
    assert slip.drift_percent(slick, None) > slip.drift_percent(firm, None)
    measured = slip.drift_percent(slick, SlipDetector())
    assert np.isfinite(measured)


def test_a_run_trains_and_tests():
    pytest.importorskip("mujoco", reason="MuJoCo is not installed; it comes with the extra `physics`")
    pytest.importorskip("sklearn", reason="scikit-learn is not installed; it comes with the extra `physics`")
    measured = slip.measure_run((1, 0, 3, 2, 5.0))
    assert [item.detector for item in measured] == ["none", "basic", "boosted", "extended"]
    assert measured[2].drift_percent is None  # nothing drives by it
    assert all(0.0 <= item.drift_percent < 100.0 for item in measured if item.detector != "boosted")
    assert measured[2].verdict is not None


def test_without_physics_it_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(ExperimentError, match="physics"):
        slip.run(Options(1))
