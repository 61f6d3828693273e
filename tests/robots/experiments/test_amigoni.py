"""The experiment of Amigoni 2013 by a team of two for half a minute, and what it says of made-up areas."""

import numpy as np
import pytest

from robots.experiments.amigoni import (
    COORDINATIONS,
    MARGIN_M2,
    STRATEGIES,
    WAYMARK,
    Cell,
    effects,
    measure,
    methods_of,
    play,
    safe_area_m2,
)
from robots.experiments.amigoni_paper import PAPER_M2
from robots.experiments.experiment import Options
from robots.sim.scenario import ScenarioConfig, build_world


def test_rows_hold_means_and_effects_and_do_not_depend_on_how_often_it_is_run():
    options = Options(runs=2, maps=("office:60",))
    rows = measure(options, teams=(2,), costs_s=(0.0,), minutes=0.3)
    means = [row for row in rows if row["what"] == "safe area"]
    assert [row["method"] for row in means][-2:] == ["random", "waymark exclusion"]
    assert len(means) == len(methods_of(2)) == 8
    assert all(5.0 < row["safe_m2"] < 60.0 for row in means)
    assert len([row for row in rows if row["what"] == "effect"]) == 3 + 4 + 2 + 1
    assert [row["method"] for row in rows if row["what"] == "ANOVA"] == [
        "strategy",
        "coordination",
        "both together",
    ]
    cell = Cell("office:60", 2, 0.0, "mcdm", "original", 7, 0.3)
    assert play(cell) == play(cell)


def test_planning_that_costs_time_leaves_less_to_drive():
    free = play(Cell("office:100", 1, 0.0, "aojrf", "none", 3, 0.6))
    dear = play(Cell("office:100", 1, 30.0, "aojrf", "none", 3, 0.6))
    assert dear < free


def test_effects_of_made_up_areas():
    rng = np.random.default_rng(2)
    runs = rng.normal(400.0, 50.0, 12)
    found = {
        (strategy, coordination): runs + 40.0 * (coordination != "none") + rng.normal(0.0, 2.0, 12)
        for strategy in STRATEGIES for coordination in COORDINATIONS
    } | {WAYMARK: 1.2 * runs}  # fmt: skip
    rows = {row["method"]: row for row in effects({}, found)}
    assert rows["mcdm - aojrf, none"]["equivalent_p"] < 0.001
    assert abs(rows["mcdm - aojrf, none"]["gain_m2"]) < MARGIN_M2
    gain = rows["original - none, aojrf"]
    assert gain["gain_low_m2"] < 40.0 < gain["gain_high_m2"]
    assert rows["coordination"]["p"] < 1e-6 < rows["strategy"]["p"]
    assert rows["waymark - mcdm original"]["ratio"] == pytest.approx(1.2 * 400 / 440, rel=0.05)


def test_safe_ground_lies_within_three_metres_and_was_seen():
    world = build_world(ScenarioConfig(map="open:100", seed=1))
    rows, columns = np.nonzero(world.reachable(0.3))
    x, y = world.origin_m + (np.array([columns[0], rows[0]]) + 0.5) * world.resolution_m
    trail = np.array([[x, y, 0.0, 0.0]])
    everything = np.ones(world.cells.shape, bool)
    area = safe_area_m2(world, trail, everything, 3.0)
    assert 1.0 < area <= np.pi * 9.0 + 0.5
    assert safe_area_m2(world, trail, ~everything, 3.0) == 0.0


def test_the_paper_s_table():
    assert len(PAPER_M2) == 24 + 2 + 2
    assert PAPER_M2["open", 3, "aojrf", "simplified"] == (673.48, 85.61)
