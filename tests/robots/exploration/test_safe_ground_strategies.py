"""Amigoni's two strategies on candidates made by hand, in maps and in a mission."""

import numpy as np
import pytest

from robots.exploration.frontiers import Frontier
from robots.exploration.strategies.aojrf import Aojrf
from robots.exploration.strategies.mcdm import CAPACITY, Mcdm
from robots.exploration.strategies.three_grids import Candidate
from robots.exploration.strategy import ExplorationView
from robots.exploration.told.survey import Survey
from robots.planning.plan_grid import FREE, OCCUPIED, UNKNOWN, PlanGrid
from robots.planning.travel import travel_costs
from robots.se2 import Pose2

SURVEY = Survey(np.ones((2, 2)), np.zeros((2, 2), np.uint8), (0.0, 0.0))


def candidate(x, area_m2, way_m):
    return Candidate((0, 0), (x, 0.0), 1.0, way_m, area_m2)


def view(*candidates, battery=1.0):
    return ExplorationView(Pose2(), candidates, lambda: SURVEY, battery=battery)


def test_eq_1_by_hand():
    seen = view(candidate(0.0, 8.0, 4.0), candidate(30.0, 8.0, 4.0), candidate(0.0, 8.0, 0.25), battery=0.5)
    chance = np.exp(-0.5)
    np.testing.assert_allclose(Aojrf().worths(seen), [8.0 / 2.0, 8.0 * chance / 2.0, 8.0])


def test_with_a_full_battery_area_alone_counts_and_of_equals_the_nearer():
    large, near, far = candidate(0.0, 9.0, 40.0), candidate(0.0, 8.0, 2.0), candidate(0.0, 8.0, 20.0)
    worths = Aojrf().worths(view(large, near, far))
    assert worths[0] > worths[1] > worths[2]
    tired = Aojrf().worths(view(large, near, far, battery=0.2))
    assert tired.argmax() == 1


def test_eq_2_by_hand():
    """The first has the most ground, the second the shortest way; both report alike, half the battery."""
    seen = view(candidate(0.0, 10.0, 9.0), candidate(0.0, 6.0, 1.0), candidate(0.0, 0.0, 9.0), battery=0.5)
    expected = CAPACITY.integral(np.array([[1, 0, 1, 0.5], [0.6, 1, 1, 0.5], [0, 0, 1, 0.5]]))
    np.testing.assert_allclose(Mcdm().worths(seen), expected)
    assert Mcdm().worths(seen).argmax() == 1


@pytest.mark.parametrize("strategy", [Aojrf(), Mcdm()])
def test_more_ground_or_a_shorter_way_is_never_worse(strategy):
    rng = np.random.default_rng(1)
    for _ in range(50):
        areas, ways, battery = rng.uniform(1.0, 50.0, 5), rng.uniform(1.0, 30.0, 5), rng.uniform(0.0, 1.0)
        seen = view(*(candidate(0.0, a, w) for a, w in zip(areas, ways, strict=True)), battery=battery)
        better = view(candidate(0.0, 60.0, 0.5), *seen.frontiers[1:], battery=battery)
        best = strategy.worths(better)
        assert best[0] >= best.max() - 1e-12


@pytest.mark.parametrize("strategy", [Aojrf(), Mcdm()])
def test_a_frontier_in_place_of_candidates_is_weighed_and_named(strategy):
    seen = view(Frontier((0, 0), (3.0, 0.0), 2.0, 3.0))
    assert np.isfinite(strategy.worths(seen)).all()
    assert strategy.reason(seen, 0).startswith("the nearest edge of the unknown")
    reason = strategy.reason(view(candidate(0.0, 12.3, 4.0)), 0)
    assert reason == "12 m² of free ground beyond the safe; 100% to reach the base from there"


@pytest.mark.parametrize("strategy", [Aojrf(), Mcdm()])
def test_candidates_come_from_the_view(strategy):
    cells = np.full((14, 120), UNKNOWN, np.uint8)
    cells[1:-1] = OCCUPIED
    cells[2:-2, 10:-10] = FREE
    grid = PlanGrid(cells, (cells == FREE).astype(np.uint8) * 5, (0.0, 0.0), 0.1)
    seen = ExplorationView(
        Pose2(5.0, 0.7, 0.0),
        (),
        lambda: SURVEY,
        grid=grid,
        costs=travel_costs(grid, 7, 50),
        trail=np.array([[5.0, 0.7, 0, 0]]),
    )
    assert len(strategy.candidates(seen)) == 2
    assert strategy.candidates(view()) == ()
