"""The oracle's tours, and one robot beside them."""

import numpy as np
import pytest

from robots.experiments.experiment import Options
from robots.experiments.one_robot import SHARE, measure
from robots.experiments.oracle import Oracle
from robots.sim.arena.ground import ground_of
from robots.sim.scenario import ScenarioConfig


def test_a_tour_sees_what_it_promises_and_more_costs_more():
    ground = ground_of(ScenarioConfig(map="office:80", robots=1, seed=3))
    oracle = Oracle(ground, 0.22, 4.0)
    tours = [oracle.tour(ground.starts[0], share) for share in (0.3, 0.9, 0.98)]
    for tour, share in zip(tours, (0.3, 0.9, 0.98), strict=True):
        assert share <= tour.share <= 1.0
    assert tours[0].length_m < tours[1].length_m <= tours[2].length_m
    everything = np.hypot(*ground.world.cells.shape) * ground.world.resolution_m
    assert 2.0 < tours[2].length_m < 6.0 * everything


def test_nobody_in_the_dark_drives_less_than_who_knows_the_plan():
    rows = {row["method"]: row for row in measure(Options(runs=2, maps=("office:80",)), ("nearest",))}
    assert rows["oracle"]["of_oracle"] == pytest.approx(1.0)
    assert rows["nearest"]["reached"] == 2
    assert 0.2 < rows["nearest"]["of_oracle"] < 1.0
    assert SHARE == 0.98
