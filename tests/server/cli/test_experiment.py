"""`waymark experiment`, run as a user would, with an experiment small enough for a test."""

import json
import subprocess
import sys
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest

from robots.experiments import kleiner_time
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
