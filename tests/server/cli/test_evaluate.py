"""`waymark evaluate` from the files to the JSON."""

import json

import numpy as np
import pytest

from robots.se2 import Pose2
from robots.trajectory import Trajectory
from robots.tum import write_tum
from server.cli.main import run


@pytest.fixture
def files(tmp_path):
    rng = np.random.default_rng(1)
    heading = np.cumsum(rng.normal(0.0, 0.2, 200))
    positions = np.cumsum(0.05 * np.column_stack([np.cos(heading), np.sin(heading)]), axis=0)
    truth = Trajectory(10.0 + 0.1 * np.arange(200), np.column_stack([positions, heading]))
    carried = np.array([(Pose2(4.0, 5.0, 1.0) @ Pose2.from_array(row)).as_array() for row in truth.poses])
    estimate = Trajectory(truth.stamps_s, carried)
    write_tum(tmp_path / "truth.tum", truth)
    write_tum(tmp_path / "estimate.tum", estimate)
    return tmp_path


def test_the_json_is_one_object_and_nothing_else(files, capsys):
    assert run(["evaluate", str(files / "estimate.tum"), str(files / "truth.tum"), "--json"]) == 0
    shown = capsys.readouterr()
    result = json.loads(shown.out)
    assert shown.out.count("\n") == 1
    assert result["ate_m"] == pytest.approx(0.0, abs=1e-5)
    assert result["relative_m"] == pytest.approx(0.0, abs=1e-5)
    assert result["poses"] == 200


def test_people_get_a_table(files, capsys):
    assert run(["evaluate", str(files / "estimate.tum"), str(files / "truth.tum")]) == 0
    assert "ate_m" in capsys.readouterr().out


def test_a_trajectory_too_short_for_the_interval_has_no_relative_error(files, capsys):
    arguments = [
        "evaluate",
        str(files / "estimate.tum"),
        str(files / "truth.tum"),
        "--interval",
        "60",
        "--json",
    ]
    assert run(arguments) == 0
    assert json.loads(capsys.readouterr().out)["relative_m"] is None


@pytest.mark.parametrize(
    ("estimate", "options", "words"),
    [
        ("absent.tum", [], "cannot read the trajectory"),
        ("bad.tum", [], "bad.tum, line 2: expected eight numbers"),
        ("late.tum", [], "only 0 of 1 poses lie within the truth's time"),
        ("estimate.tum", ["--max-gap", "nan"], "--max-gap has to be a finite number"),
        ("estimate.tum", ["--interval", "-1"], "--interval has to be greater than 0"),
    ],
)
def test_what_cannot_be_compared_ends_in_one_sentence(files, capsys, estimate, options, words):
    (files / "bad.tum").write_text("1 2 3 0 0 0 0 1\n1 2 3\n")
    (files / "late.tum").write_text("1e9 2 3 0 0 0 0 1\n")
    assert run(["evaluate", str(files / estimate), str(files / "truth.tum"), "--json", *options]) == 1
    shown = capsys.readouterr()
    assert shown.out == ""
    assert words in shown.err
    assert shown.err.count("\n") == 1
