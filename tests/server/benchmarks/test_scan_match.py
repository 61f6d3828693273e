"""The benchmark of scan matching: the same pairs for everybody, figures that mean what they say."""

import json
from math import degrees, hypot

import numpy as np

from server.benchmarks.scan_pairs import buildings, pairs
from server.cli.main import run


def test_the_pairs_are_what_the_benchmark_says_and_the_same_each_time():
    worlds = dict(list(buildings(None).items())[:1])
    first, second = (list(pairs(worlds, 24, seed=3)) for _ in range(2))
    for a, b in zip(first, second, strict=True):
        np.testing.assert_array_equal(a.reference.ranges_m, b.reference.ranges_m)
        np.testing.assert_array_equal(a.scan.ranges_m, b.scan.ranges_m)
        assert (a.true, a.guess) == (b.true, b.guess)
        assert len(a.scan.ranges_m) == 360
        assert abs(hypot(a.true.x, a.true.y) - 0.08) < 1e-9
        assert abs(abs(degrees(a.true.theta)) - 8.0) < 1e-9
        assert hypot(a.guess.x - a.true.x, a.guess.y - a.true.y) <= 0.10
        assert abs(degrees(a.guess.theta - a.true.theta)) <= 5.0
    other = next(pairs(worlds, 1, seed=4))
    assert other.guess != first[0].guess
    assert {pair.scan.range_max_m for pair in first} == {4.0, 8.0, 12.0, 30.0}


def test_the_command_reports_accuracy_far_better_than_the_guesses(capsys):
    assert run(["bench", "scan-match", "--pairs", "12", "--json"]) == 0
    figures = json.loads(capsys.readouterr().out)["scan-match"]
    assert figures["pairs"] == 48
    assert figures["mean_error_cm"] < 2.1
    assert figures["within_10_cm_2_deg"] >= 0.975
    assert 0.3 < figures["mean_nees_of_3"] < 9.0
    assert figures["ms_p50"] > 0.0
    assert "small_gicp" in figures


def test_a_folder_without_maps_is_refused_in_one_sentence(tmp_path, capsys):
    assert run(["bench", "scan-match", "--maps", str(tmp_path)]) != 0
    assert "there is no map_server map" in capsys.readouterr().err
