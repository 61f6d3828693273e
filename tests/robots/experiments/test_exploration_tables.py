"""Baselines and capacities, on a building small enough for a test."""

import numpy as np
import pytest
from PIL import Image

from robots.experiments import baselines, tag_capacity
from robots.experiments.experiment import Options

OPTIONS = Options(2, maps=("office:60",))


@pytest.fixture(scope="module")
def shared():
    methods = [each for each in baselines.METHODS if each[0] in ("none", "nearest", "gain + hungarian")]
    return baselines.measure(OPTIONS, methods, robots=3)


@pytest.fixture(scope="module")
def capacity():
    return tag_capacity.measure(OPTIONS, tag_capacity.capacities((512, 2048), (4.0,), (0.5,))[:3])


def drawn(experiment, rows, path):
    experiment.plot(rows, path)
    with Image.open(path) as image:
        return len(np.unique(np.asarray(image.convert("RGB")).reshape(-1, 3), axis=0)) > 20


def test_baselines_have_a_row_for_each_method_and_all_get_there(shared, tmp_path):
    assert [row["method"] for row in shared] == ["none", "nearest", "gain + hungarian"]
    for row in shared:
        for column in baselines.EXPERIMENT.columns:
            assert column.value in row
        assert 0.0 < row["t50_s"] < row["t90_s"] <= row["t99_s"]
        assert row["t99_reached_share"] == 1.0
        assert (row["times_stuck"], row["false_ends"]) == (0, 0)
    assert shared[1]["t90_ratio"] == 1.0
    assert drawn(baselines.EXPERIMENT, shared, tmp_path / "plot.png")


def test_every_method_has_a_name_of_its_own_and_can_be_had():
    assert len({name for name, _ in baselines.METHODS}) == len(baselines.METHODS) == 7
    cases = [*tag_capacity.capacities(), *tag_capacity.printed()]
    assert len({(c.method, c.tag_bits, c.planning.tag_cell_m, c.reader_m) for c in cases}) == len(cases)
    for case in cases:
        case.config("office:60", 1)  # refuses what no chip or strategy has


def test_capacities_are_set_against_no_communication_and_one_map(capacity, tmp_path):
    assert [(row["method"], row["tag_bits"], row["cell_m"]) for row in capacity] == [
        ("none", None, None),
        ("full", None, None),
        ("waymark", 512, 0.5),
        ("waymark", 2048, 0.5),
        ("kleiner, tau 2 m", 2048, 0.5),
    ]
    for row in capacity:
        for column in tag_capacity.EXPERIMENT.columns:
            assert column.value in row
    assert [row["gap_mean"] for row in capacity[:2]] == [0.0, 1.0]
    assert drawn(tag_capacity.EXPERIMENT, capacity, tmp_path / "plot.png")
