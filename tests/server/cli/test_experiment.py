"""`waymark experiment`, run as a user would, with an experiment small enough for a test."""

import json
import subprocess
import sys
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from robots.experiments import kleiner_time, one_robot
from robots.experiments.buildings import Building
from robots.experiments.registry import EXPERIMENTS
from server.cli.main import run


@pytest.fixture
def tiny(monkeypatch):
    measure = partial(
        kleiner_time.measure, buildings=(Building("small", 40.0, "office:40"),), minutes=0.5, searches=1
    )
    monkeypatch.setitem(EXPERIMENTS, "tiny", replace(kleiner_time.EXPERIMENT, name="tiny", run=measure))
    return "tiny"


def test_without_a_name_they_are_listed(capsys):
    assert run(["experiment"]) == 0
    printed = " ".join(capsys.readouterr().out.split())
    for each in EXPERIMENTS.values():
        assert each.name in printed
        assert each.summary.split()[0] in printed


def test_an_experiment_is_measured_printed_written_and_drawn(tiny, tmp_path, capsys):
    file, plot = tmp_path / "rows.json", tmp_path / "plot.svg"
    assert run(["experiment", tiny, "--runs", "2", "--json", str(file), "--plot", str(plot)]) == 0
    printed = capsys.readouterr()
    assert "paper" in printed.out
    assert "0.42" in printed.out
    assert printed.err == ""
    rows = json.loads(file.read_text())["rows"]
    assert [row["method"] for row in rows] == ["linear", "gauss-newton"]
    assert all(not isinstance(value, dict | list) for row in rows for value in row.values())
    assert "<svg" in plot.read_text()


@pytest.fixture
def plan(tmp_path):
    """Return the file of a plan with one room of 6 x 4 m."""
    pixels = np.zeros((60, 80), np.uint8)
    pixels[10:50, 10:70] = 255
    Image.fromarray(pixels).save(tmp_path / "room.png")
    file = tmp_path / "room.yaml"
    file.write_text("image: room.png\nresolution: 0.1\norigin: [0, 0, 0]\n")
    return str(file)


def test_maps_may_be_given_in_place_of_its_own(plan, monkeypatch, tmp_path, capsys):
    measure = partial(one_robot.measure, methods=("nearest",))
    monkeypatch.setitem(EXPERIMENTS, "quick", replace(one_robot.EXPERIMENT, name="quick", run=measure))
    file = tmp_path / "rows.json"
    maps = ["--map", plan, "--map", "office:40"]
    assert run(["experiment", "quick", "--runs", "1", *maps, "--json", str(file)]) == 0
    rows = json.loads(file.read_text())["rows"]
    assert [(row["map"], row["method"]) for row in rows] == [
        (name, method) for name in (plan, "office:40") for method in ("nearest", "oracle")
    ]
    assert rows[0]["way_per_m2"] < 0.1 < rows[2]["way_per_m2"]  # one room is seen from its middle
    capsys.readouterr()
    assert run(["experiment", "quick", "--map", "absent.yaml"]) == 1
    assert "absent.yaml" in capsys.readouterr().err
    assert run(["experiment", "kleiner-slam", "--map", plan]) == 1
    assert "leave --map out" in capsys.readouterr().err


def test_rows_may_go_to_stdout(tiny, capsys):
    assert run(["experiment", tiny, "--runs", "1", "--json", "-"]) == 0
    assert len(json.loads(capsys.readouterr().out)["rows"]) == 2


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["nonsense"], "there is no experiment nonsense; known are kleiner-slam"),
        (["kleiner-slam", "--runs", "0"], "--runs 0 is out of range; give 1 to"),
        (["kleiner-slam", "--jobs", "0"], "--jobs 0 is out of range"),
        (["kleiner-slam", "--seed", "-1"], "--seed -1 is out of range"),
        (["kleiner-slam", "--plot", "plot.gif"], "has to end in .png, .pdf or .svg"),
        (["kleiner-slam", "--plot", "nowhere/plot.png"], "there is no folder nowhere"),
        (["kleiner-slam", "--json", "nowhere/rows.json"], "there is no folder nowhere"),
        (["kleiner-slam", "--json", "."], "is a folder"),
        (["kleiner-slam-plans", "--data", "nowhere"], "the plan office-280.yaml is not in nowhere"),
        (["kleiner-cellar", "--data", "nowhere"], "the recording intel_raw_2726.npz is not in nowhere"),
    ],
)
def test_what_is_wrong_is_one_sentence(arguments, sentence, capsys, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    assert run(["experiment", *arguments]) == 1
    printed = capsys.readouterr()
    assert sentence in printed.err
    assert printed.err.count("\n") == 1
    assert printed.out == ""


def test_matplotlib_is_loaded_for_plots_only():
    program = (
        "import sys; from server.cli.main import run; run(['experiment']); print('matplotlib' in sys.modules)"
    )
    root = Path(__file__).parents[3]
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=root, capture_output=True, text=True, timeout=120, check=True
    )
    assert done.stdout.splitlines()[-1] == "False"
