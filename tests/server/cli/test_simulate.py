"""`waymark simulate` from the options to the files."""

import json
import math

import numpy as np
import pytest

from robots.evaluation import absolute_error
from robots.sim.map_files import load_map
from robots.tum import read_tum
from server.cli.main import run

SHORT = ["simulate", "--map", "office:60", "--robots", "2", "--minutes", "0.5", "--seed", "3"]
KEYS = {
    "explored_m2",
    "observable_m2",
    "coverage",
    "covered_s",
    "distance_m",
    "score",
    "victims_found",
    "victims_total",
    "tags_dropped",
    "ate_m",
    "step_hz",
    "wall_s",
    "step_ms_p50",
    "step_ms_p99",
}


@pytest.fixture(scope="module")
def mission(tmp_path_factory):
    out = tmp_path_factory.mktemp("mission") / "new" / "folder"
    captured = pytest.MonkeyPatch()
    lines: list[dict] = []
    captured.setattr("server.cli.simulate.print_json", lines.append)
    try:
        assert run([*SHORT, "--out", str(out), "--json"]) == 0
    finally:
        captured.undo()
    return lines[0], out


def test_the_summary_has_what_is_promised(mission):
    summary, _ = mission
    assert summary.keys() >= KEYS
    assert summary["coverage"] == pytest.approx(summary["explored_m2"] / summary["observable_m2"])
    assert summary["score"] == pytest.approx(summary["explored_m2"] / summary["distance_m"])
    assert summary["ate_m"].keys() == {"r1", "r2"}
    assert all(error < 0.5 for error in summary["ate_m"].values())
    assert summary["victims_total"] == 4
    assert 0.0 < summary["step_ms_p50"] <= summary["step_ms_p99"]


def test_robots_that_talk_tell_their_base(capsys):
    talking = [
        "--minutes",
        "0.3",
        "--communication",
        "radio",
        "--coordinate",
        "burgard",
        "--radio-range",
        "30",
    ]
    assert run([*SHORT, *talking, "--json"]) == 0
    assert 0.3 < json.loads(capsys.readouterr().out)["known_at_base"] <= 1.0
    assert run([*SHORT, "--coordinate", "auction"]) == 1
    assert "coordinate: 'auction' is unknown; use one of none, random" in capsys.readouterr().err


def test_the_files_agree_with_the_summary(mission):
    summary, out = mission
    for robot_id in ("r1", "r2"):
        online = read_tum(out / f"trajectory_{robot_id}.tum")
        final = read_tum(out / f"trajectory_{robot_id}_final.tum")
        assert len(online) == len(final) == 600  # half a minute at 20 Hz
        assert absolute_error(final, online).rmse_m < 0.5
    header, *rows = (out / "tags.csv").read_text().splitlines()
    assert header == "tag_id,x_m,y_m,var_x,var_xy,var_y"
    assert len(rows) <= summary["tags_dropped"] + 1  # and the one at the base
    assert all(math.isfinite(float(value)) for row in rows for value in row.split(",")[1:])
    mapped = load_map(out / "map.yaml")
    assert (
        0.2 * summary["explored_m2"]
        < mapped.free.sum() * mapped.resolution_m**2
        < 3.0 * summary["explored_m2"]
    )


def test_the_same_seed_writes_the_same_files(mission, tmp_path, capsys):
    _, out = mission
    assert run([*SHORT, "--out", str(tmp_path), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["coverage"] > 0.0
    for name in ("trajectory_r1.tum", "trajectory_r2_final.tum", "tags.csv", "map.png", "map.yaml"):
        assert (tmp_path / name).read_bytes() == (out / name).read_bytes(), name


def test_true_poses_leave_no_error(capsys):
    options = ["--poses", "truth", "--robots", "1", "--coordinate", "hungarian", "--json"]
    assert run([*SHORT, *options]) == 0
    said = capsys.readouterr()
    assert json.loads(said.out)["ate_m"]["r1"] == pytest.approx(0.0, abs=1e-6)
    assert "hungarian shares out nothing among robots that hear nobody: by tags they do not" in said.err


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--robots", "0"], "robots 0 is out of range"),
        (["--minutes", "-1"], "--minutes has to be greater than 0"),
        (["--minutes", "nan"], "--minutes has to be a finite number"),
        (["--minutes", "0"], "--minutes has to be greater than 0"),
        (["--seed", "-1"], "seed -1 is out of range"),
        (["--victims", "-1"], "victims -1 is out of range"),
        (["--noise", "9"], "noise_level 9 is out of range"),
        (["--laser-range", "inf"], "laser.range_max_m inf is out of range"),
        (["--map", "office:big"], "give the area in square metres"),
        (["--map", "castle:50"], "castle"),
        (["--map", "office:nan"], "office"),
        (["--map", "absent.yaml"], "absent.yaml"),
        (["--radio-cut", "r2"], "give ROBOT:FROM:TO"),
        (["--environment", "cave"], "environment: 'cave' is unknown"),
        (["--slam", "r1=magic"], "slam: 'magic' is unknown"),
        (["--slam", "r7=odometry"], "slam: there is no robot r7"),
    ],
)
def test_what_cannot_be_simulated_ends_in_one_sentence(capsys, options, words):
    assert run([*SHORT, "--json", *options]) == 1
    shown = capsys.readouterr()
    assert shown.out == ""
    assert words in shown.err
    assert shown.err.count("\n") == 1
    assert "Traceback" not in shown.err


def test_a_map_without_free_space_is_refused(tmp_path, capsys):
    from PIL import Image

    Image.fromarray(np.zeros((20, 20), np.uint8)).save(tmp_path / "full.png")
    (tmp_path / "full.yaml").write_text("image: full.png\nresolution: 0.05\norigin: [0, 0, 0]\n")
    assert run([*SHORT, "--map", str(tmp_path / "full.yaml")]) == 1
    assert "no free space" in capsys.readouterr().err


def test_a_folder_that_cannot_be_made_is_refused_before_the_work(tmp_path, capsys):
    (tmp_path / "file").write_text("")
    assert run([*SHORT, "--minutes", "600", "--out", str(tmp_path / "file" / "out")]) == 1
    assert "cannot create the folder" in capsys.readouterr().err
