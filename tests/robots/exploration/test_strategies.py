"""What the strategies find worth going to."""

from dataclasses import replace

import numpy as np
import pytest

from robots.exploration.frontiers import Frontier
from robots.exploration.strategies import STRATEGIES
from robots.exploration.strategies.information_gain import InformationGain
from robots.exploration.strategies.nearest import Nearest
from robots.exploration.strategies.waymark import Waymark
from robots.exploration.strategy import ExplorationView, ways_of
from robots.exploration.told.survey import Survey
from robots.planning.plan_grid import FREE, UNKNOWN, PlanGrid
from robots.se2 import Pose2
from robots.tags.memory import CLOSED, OPEN

NEAR, FAR = Frontier((0, 0), (5.0, 5.0), 0.6, 5.0), Frontier((0, 0), (25.0, 5.0), 9.0, 7.0)


def view(frontiers=(NEAR, FAR), known_to_x_m=0.0, claimed_to_x_m=0.0, state=CLOSED):
    """A map of 30 m by 10 m, known up to one x and claimed up to another."""
    unknown, claimed = np.ones((20, 60)), np.zeros((20, 60), np.uint8)
    unknown[:, : round(2 * known_to_x_m)] = 0.0
    claimed[:, : round(2 * claimed_to_x_m)] = state
    return ExplorationView(Pose2(), frontiers, lambda: Survey(unknown, claimed, (0.0, 0.0)))


def best(strategy, seen):
    return seen.frontiers[int(np.argmax(strategy.worths(seen)))]


def test_the_nearest_is_taken_however_wide_the_others_are():
    assert best(Nearest(), view()) is NEAR
    assert Nearest().reason(view(), 0) == "the nearest edge of the unknown, 0.6 m wide"
    assert Nearest().reason(view(), 1) == "an edge of the unknown, 9.0 m wide"


def test_a_little_more_way_is_worth_much_more_to_see():
    assert best(InformationGain(), view()) is NEAR
    assert best(InformationGain(), view(known_to_x_m=8.0)) is FAR
    assert InformationGain().reason(view(known_to_x_m=30.0), 1) == "see about 0 m² of new ground"
    assert InformationGain().reason(view(), 1) == "see about 36 m² of new ground"


def test_what_others_covered_is_left_to_the_last_and_only_by_waymark():
    seen = view(claimed_to_x_m=12.0)
    assert best(InformationGain(), seen) is NEAR
    assert best(Waymark(), seen) is FAR
    assert best(Waymark(), view((NEAR,), claimed_to_x_m=12.0)) is NEAR
    assert Waymark().reason(seen, 0) == "cross covered ground to what beyond it is open"
    assert Waymark().reason(seen, 1) == "see about 36 m² of new ground"


def test_who_reads_tags_only_under_its_feet_does_not_follow_others():
    """From afar a tag is read before one drives where its writer did: it tells of the way ahead."""
    cells = np.full((20, 60), UNKNOWN, np.uint8)
    cells[5:15, :40] = FREE
    grid = PlanGrid(cells, np.zeros_like(cells), (0.0, 0.0), 0.5)
    edges = tuple(Frontier((row, 39), grid.centre_of(row, 39), 1.0, 5.0) for row in (5, 14))
    claimed = np.zeros((20, 60), np.uint8)
    claimed[:, 50:] = CLOSED
    survey = Survey(
        np.where(cells == UNKNOWN, 1.0, 0.0), claimed, (0.0, 0.0), promised=np.array([(20.0, 2.0)])
    )
    afar = ExplorationView(Pose2(), edges, lambda: survey, grid=grid, tag_reach_m=4.0)
    lost = Waymark().worths(afar) - Waymark().worths(replace(afar, tag_reach_m=0.3))
    assert lost[0] > 3.0
    assert lost[1] == pytest.approx(0.0)


def test_ground_with_an_open_frontier_is_no_claim():
    assert best(Waymark(), view(claimed_to_x_m=12.0, state=OPEN)) is NEAR


def test_own_eyes_overrule_what_tags_say():
    seen, told = view(known_to_x_m=30.0), view(known_to_x_m=30.0, claimed_to_x_m=30.0)
    np.testing.assert_allclose(Waymark().worths(told), Waymark().worths(seen))


def test_a_view_can_be_asked_as_if_the_ways_were_others():
    shorter = view().with_ways(np.array([5.0, 1.0]))
    assert best(Nearest(), shorter).goal_m == FAR.goal_m
    assert list(ways_of(shorter)) == [5.0, 1.0]


@pytest.mark.parametrize("name", STRATEGIES)
def test_every_strategy_weighs_all_it_sees_and_says_why(name):
    strategy = STRATEGIES[name]()
    for seen in (view(), view((FAR,)), view(known_to_x_m=15.0, claimed_to_x_m=20.0)):
        worths = strategy.worths(seen)
        assert worths.shape == (len(seen.frontiers),)
        assert np.isfinite(worths).all()
        assert strategy.reason(seen, 0)
