"""The exploration experiment, on a building small enough for a test."""

import numpy as np
import pytest
from PIL import Image

from robots.experiments import kleiner_exploration
from robots.experiments.experiment import ExperimentError, Options
from robots.experiments.exploring import gap_closed, ratio_of_means


def measure(runs=2, jobs=1, maps=("office:50",), **more):
    return kleiner_exploration.measure(
        Options(runs, jobs=jobs, maps=maps, **more), starts=("same",), readers_m=(4.0,)
    )


@pytest.fixture(scope="module")
def rows():
    return measure()


def test_rows_have_what_was_agreed(rows):
    assert [(row["in_order"], row["method"], row["tag_error_m"]) for row in rows] == [
        ("sequence", "none", None),
        ("sequence", "full", None),
        ("sequence", "no tags", None),
        ("sequence", "tags", 0.0),
        ("at once", "none", None),
        ("at once", "full", None),
        ("at once", "no tags", None),
        ("at once", "tags", 0.0),
        ("at once", "tags", 0.3),
    ]
    names = "map start reader_m tag_bits method robots runs score_mean score_sd gap_mean gap_low gap_high"
    for row in rows:
        assert set(names.split()) <= set(row)
        for column in kleiner_exploration.EXPERIMENT.columns:
            assert column.value in row
        assert row["score_mean"] > 0.0
        assert (row["times_stuck"], row["false_ends"]) == (0, 0)
    assert [row["gap_mean"] for row in rows[:2]] == [0.0, 1.0]
    assert rows[5]["t99_ratio"] == 1.0


def test_processes_change_nothing(rows):
    assert measure(jobs=2) == rows


def test_the_plot_is_drawn(rows, tmp_path):
    path = tmp_path / "plot.png"
    kleiner_exploration.EXPERIMENT.plot(rows, path)
    with Image.open(path) as image:
        assert len(np.unique(np.asarray(image.convert("RGB")).reshape(-1, 3), axis=0)) > 20


def test_a_map_that_is_not_there_is_named():
    with pytest.raises(ExperimentError, match=r"nowhere\.yaml"):
        measure(maps=("nowhere.yaml",))


def test_the_interval_of_the_gap_holds_the_truth_as_often_as_it_says():
    """Buildings differ more than methods do: only pairs tell."""
    rng = np.random.default_rng(5)
    held = 0
    for _ in range(200):
        building = rng.normal(1.0, 0.3, 24)
        none, full = building + rng.normal(0.0, 0.05, 24), building + 1.0 + rng.normal(0.0, 0.05, 24)
        method = building + 0.7 + rng.normal(0.0, 0.1, 24)
        gap, low, high = gap_closed(none, method, full)
        assert low <= gap <= high
        held += low <= 0.7 <= high
    assert 0.88 <= held / 200 <= 0.99
    ratio, low, high = ratio_of_means(np.array([2.0, 4.0, 6.0]), np.array([1.0, 2.0, 3.0]))
    assert (ratio, low, high) == pytest.approx((2.0, 2.0, 2.0))
