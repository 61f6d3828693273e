"""`waymark fit-radio` from a recording, or a mission's log, to the file that `waymark simulate` takes."""

import json
from pathlib import Path

import numpy as np
import pytest
import yaml

from robots.agent import RobotAgent, merge_commands
from robots.config import RadioConfig
from robots.datasets.log_signals import collect
from robots.datasets.radio_file import read_radio
from robots.datasets.recording import RecordingError
from robots.estimation.radio.fit import Collector, fit_radio
from robots.sim.scenario import ScenarioConfig
from robots.sim.simulation import Order, Simulation
from server.cli.main import run

REAL = Path(__file__).parents[4] / "shared" / "data" / "ble_danis"
RECEIVERS = {"aa": [[0.0, 0.0, 1.0], 0, "one"], "bb": [[10.0, 0.0, 1.0], 0, "two"]}


@pytest.fixture
def folder(tmp_path):
    """Two receivers, a beacon carried past them; p(d0) -50 dBm, n 2, no noise."""
    (tmp_path / "cnf").mkdir()
    (tmp_path / "trk").mkdir()
    (tmp_path / "cnf" / "lab.dev").write_text(f"Dongles:{json.dumps(RECEIVERS)}\nBeacons:{{}}\n")
    lines = []
    for k in range(40):
        x, y = 0.5 + 0.2 * k, 2.0
        for name, (place, *_) in RECEIVERS.items():
            d = float(np.linalg.norm(np.array(place) - (x, y, 1.0)))
            lines.append(f"{k},{name},beacon,{-50.0 - 20.0 * np.log10(d)},{x},{y},1.0,1,0,0,0,1,0,0,0,1")
    (tmp_path / "trk" / "a.mbd").write_text("\n".join(lines) + "\n")
    return tmp_path


def test_a_folder_is_fitted_and_the_file_is_a_radio(folder, capsys):
    out = folder / "radio.yaml"
    assert run(["fit-radio", "ble_danis", str(folder), "--out", str(out), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["power_at_1m_dbm"] == pytest.approx(-50.0, abs=1e-3)
    assert found["path_loss_exponent"] == pytest.approx(2.0, abs=1e-3)
    assert found["readings"] == 80
    radio = read_radio(out)
    assert (radio.power_at_1m_dbm, radio.path_loss_exponent) == (-50.0, 2.0)
    assert radio.reach_m == RadioConfig().reach_m
    options = ["--map", "open:40", "--robots", "1", "--minutes", "0.02", "--victims", "0", "--tags", "node"]
    assert run(["simulate", *options, "--radio", str(out), "--json"]) == 0


def test_the_table_names_the_numbers(folder, capsys):
    assert run(["fit-radio", "ble_danis", str(folder / "trk" / "a.mbd")]) == 0
    shown = capsys.readouterr().out
    assert "power_at_1m_dbm" in shown
    assert "-50.000" in shown


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("trk/a.mbd", "1,aa,beacon,-50\n", "line 1 is no reading"),
        ("trk/a.mbd", "1,aa,beacon,-50,0,nan,1\n", "line 1 is no reading"),
        ("trk/a.mbd", "\n1,zz,beacon,-50,0,0,1\n", "line 2: nobody says where receiver 'zz' is"),
        ("trk/a.mbd", "1,aa,beacon,-50,0,0,1\n", "there are 1 readings with a known distance"),
        ("cnf/lab.dev", "Beacons:{}\n", "no line Dongles"),
        ("cnf/lab.dev", 'Dongles:{"aa": 5}\n', "does not say where the receivers are"),
        ("cnf/lab.dev", 'Dongles:{"aa": [[1, 2]]}\n', "three numbers"),
    ],
)
def test_what_is_damaged_is_named(folder, capsys, name, content, words):
    (folder / name).write_text(content)
    assert run(["fit-radio", "ble_danis", str(folder)]) == 1
    shown = capsys.readouterr().err
    assert words in shown
    assert shown.count("\n") == 1


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["magic", "x"], "known are ble_danis, log"),
        (["ble_danis", "absent"], "it needs trk/*.mbd and cnf/*.dev"),
        (["log", "absent"], "absent"),
    ],
)
def test_what_is_no_recording_is_refused(tmp_path, capsys, monkeypatch, arguments, words):
    monkeypatch.chdir(tmp_path)
    assert run(["fit-radio", *arguments]) == 1
    assert words in capsys.readouterr().err


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("radio: {reach_m: -1}", "radio.reach_m"),
        ("radio: {colour: 3}", "radio.colour is no setting"),
        ("body: {radius_m: 1}", "under 'radio'"),
        ("[1, 2", "is no YAML file"),
    ],
)
def test_a_file_that_is_no_radio_is_refused(tmp_path, content, words):
    (tmp_path / "r.yaml").write_text(content)
    with pytest.raises(RecordingError, match=words):
        read_radio(tmp_path / "r.yaml")


def test_a_mission_among_nodes_tells_its_own_radio():
    """Nodes that the robot drove over are heard from all over the hall: the simulator's radio comes out."""
    radio = RadioConfig(power_at_1m_dbm=-12.0, path_loss_exponent=1.7, shadowing_sd_db=2.0, fading_sd_db=1.5)
    scenario = ScenarioConfig(
        map="open:120", robots=1, minutes=1.0, seed=2, victims=0, tags="node", measured_radio=radio
    )
    told = scenario.agent_of("r1")
    simulation, agent, log = Simulation(scenario), RobotAgent("r1", told), []
    for _ in range(scenario.periods):
        batch = simulation.advance()["r1"]
        log.extend(batch)
        simulation.apply({"r1": Order(merge_commands([agent.step(each) for each in batch]))})
    collector = Collector()
    collect(collector, "r1", told, log)
    found = fit_radio(collector.signals())
    assert found.path_loss_exponent == pytest.approx(1.7, abs=0.25)
    assert found.power_at_1m_dbm == pytest.approx(-12.0, abs=2.0)
    assert 1.6 < found.shadowing_sd_db < 3.2  # pillars and debris take theirs as well
    assert found.fading_sd_db == pytest.approx(1.5, abs=0.3)


def test_the_laboratory_of_danis(capsys):
    """Measured by least squares on it: p(d0) -61.9 dBm, n 1.40, sigma 6.3 dB."""
    if not REAL.exists():
        pytest.skip(
            "the recording is not part of the project; it lies in ../shared/data where that is present"
        )
    assert run(["fit-radio", "ble_danis", str(REAL), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["power_at_1m_dbm"] == pytest.approx(-61.9, abs=0.2)
    assert found["path_loss_exponent"] == pytest.approx(1.40, abs=0.02)
    assert found["sigma_all_db"] == pytest.approx(6.3, abs=0.1)
    assert found["sigma_db"] == pytest.approx(
        np.hypot(found["shadowing_sd_db"], found["fading_sd_db"]), abs=0.1
    )
    assert found["outliers"] < 50


def test_the_yaml_is_what_an_agent_is_told(folder):
    assert run(["fit-radio", "ble_danis", str(folder), "--out", str(folder / "r.yaml")]) == 0
    told = yaml.safe_load((folder / "r.yaml").read_text())
    assert set(told["radio"]) == {"power_at_1m_dbm", "path_loss_exponent", "shadowing_sd_db", "fading_sd_db"}
