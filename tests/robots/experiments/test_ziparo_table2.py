"""Ziparo 2007 table 2: the filter over UHF tags keeps a robot near the truth, and the rows say how near."""

import numpy as np
import pytest
from PIL import Image

from robots.experiments import ziparo_table2
from robots.experiments.experiment import ExperimentError, Options
from robots.experiments.ziparo_table2 import BUILDINGS, Setting, estimate, explore, run


@pytest.fixture(scope="module")
def way():
    return explore(Setting(3, "office:40", 1.0))


def test_tags_lie_a_metre_apart_and_are_heard_where_there_is_a_line_of_sight(way):
    assert way.tags > 4
    assert set(way.heard) == set(BUILDINGS.values())
    for signals in way.heard.values():
        assert len(signals) == len(way.log) == len(way.poses)
        assert {s.antenna for each in signals for s in each} <= {"front", "rear"}
    assert sum(len(each) for each in way.heard["office2"]) > 100


def test_the_estimate_follows_the_truth(way):
    poses = estimate(way, "ekf", "office2", 3)
    off = np.hypot(*(poses[:, :2] - way.poses[:, :2]).T)
    assert off[0] < 0.05
    assert off.mean() < 0.8


def test_a_building_that_cannot_be_had_is_named():
    with pytest.raises(ExperimentError, match="absent"):
        run(Setting(1, "absent.yaml"))


def test_rows_stand_beside_the_papers(monkeypatch, tmp_path):
    monkeypatch.setattr(ziparo_table2, "Setting", lambda seed: Setting(seed, "office:40", 0.5))
    rows = ziparo_table2.measure(Options(2))
    assert [row["building"] for row in rows] == [f"{name} ({kind})" for name, kind in BUILDINGS.items()]
    assert [row["paper_cartesian_m"] for row in rows] == [0.4, 0.6, 0.7, 0.4]
    for row in rows:
        assert row["runs"] == 2
        longest = max(row["cross_track_m"], row["along_track_m"])
        assert longest <= row["cartesian_m"] <= row["cross_track_m"] + row["along_track_m"]
        assert row["cartesian_m"] <= row["cartesian_worst_run_m"] <= row["cartesian_max_m"] * 2.0
    ziparo_table2.EXPERIMENT.plot(rows, tmp_path / "table.png")
    with Image.open(tmp_path / "table.png") as picture:
        assert picture.size[0] > 500
