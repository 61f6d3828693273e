"""What the strategies choose."""

from robots.exploration.frontiers import Frontier
from robots.exploration.strategies import STRATEGIES
from robots.exploration.strategies.nearest import Nearest
from robots.exploration.strategy import ExplorationView
from robots.se2 import Pose2


def frontier(cost_m: float, length_m: float) -> Frontier:
    return Frontier((1, 1), (0.15, 0.15), length_m, cost_m)


def test_the_nearest_is_taken_however_wide_the_others_are():
    view = ExplorationView(Pose2(), (frontier(1.0, 0.6), frontier(2.0, 9.0)))
    choice = Nearest().choose(view)
    assert choice.frontier is view.frontiers[0]
    assert choice.reason == "the nearest edge of the unknown, 0.6 m wide"


def test_every_strategy_says_when_there_is_nothing_left():
    assert "nearest" in STRATEGIES
    for strategy in STRATEGIES.values():
        assert strategy().choose(ExplorationView(Pose2(), ())) is None


def test_every_strategy_chooses_one_of_what_it_sees():
    view = ExplorationView(Pose2(), (frontier(1.0, 0.6), frontier(2.0, 9.0)))
    for strategy in STRATEGIES.values():
        choice = strategy().choose(view)
        assert choice.frontier in view.frontiers
        assert choice.reason
