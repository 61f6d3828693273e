"""Kleiner's two strategies: the printed one to the letter, the corrected one by what it is for."""

from dataclasses import replace

import numpy as np
import pytest

from robots.config import PlanningConfig
from robots.exploration.frontiers import Frontier
from robots.exploration.settings import KleinerConfig
from robots.exploration.strategies.kleiner import Foreign, Kleiner, crowding, visited_places
from robots.exploration.strategies.kleiner_printed import (
    KleinerPrinted,
    pull,
    synchronise_frontiers,
    synchronise_visited,
)
from robots.exploration.strategy import ExplorationView
from robots.exploration.told.claims import KnownTag
from robots.exploration.told.survey import Survey
from robots.planning.plan_grid import FREE, UNKNOWN, PlanGrid
from robots.se2 import Pose2
from robots.tags.memory import OPEN, TagMemory

SURVEY = Survey(np.ones((2, 2)), np.zeros((2, 2), np.uint8), (0.0, 0.0))
LEFT, RIGHT = Frontier((0, 0), (-4.0, 0.0), 1.0, 4.0), Frontier((0, 0), (4.0, 0.0), 1.0, 4.0)
NO_TRAIL = np.zeros((0, 4))


def memory(frontiers=(), visited=()):
    """A tag's memory: frontiers in cells of 1 m, visited places in cells of 0.4 m, north and west of it."""
    cells, driven = np.zeros((9, 9), np.uint8), np.zeros((21, 21), np.uint8)
    for north, west in frontiers:
        cells[north + 4, west + 4] = OPEN
    for north, west in visited:
        driven[north + 10, west + 10] = 1
    return TagMemory(cells, visited=driven)


def view(*frontiers, trail=NO_TRAIL, tags=(), now_s=100.0, known_to_m=None, **told):
    cells = np.full((200, 200), UNKNOWN, np.uint8)
    if known_to_m is not None:
        half = round(known_to_m / 0.1)
        cells[100 - half : 100 + half, 100 - half : 100 + half] = FREE
    grid = PlanGrid(cells, np.full_like(cells, 5), (-10.0, -10.0), 0.1)
    settings = PlanningConfig(kleiner=KleinerConfig(**told))
    return ExplorationView(
        Pose2(),
        frontiers or (LEFT, RIGHT),
        lambda: SURVEY,
        now_s,
        grid,
        trail=trail,
        tags=tags,
        settings=settings,
    )


def tag(memory, place=(0.0, 0.0)):
    return KnownTag("A", place, memory, 0.0)


def test_corrected_by_hand():
    """Two places at 1 and 2 m from the right frontier, one of them within 0.4 m of nothing; beta 0.2."""
    trail = np.array([[2.0, 0.0, 0.0, 1.0], [3.2, 0.0, 0.0, 2.0]])
    worths = Kleiner().worths(view(trail=trail, beta=0.2, tau_m=3.0))
    np.testing.assert_allclose(worths, [-4.0, -4.0 - 0.2 * (1 / 2.0 + 1 / 0.8)])


def test_corrected_goes_away_from_where_robots_were_and_the_printed_one_towards_it():
    visits = [(k, 0) for k in range(3, 11)]  # to the north, x
    told = tag(memory(visited=visits))
    assert Kleiner().worths(view(tags=(told,))).argmax() == 0
    printed = KleinerPrinted()
    printed.answer(told.memory, view(now_s=0.0), (0.0, 0.0))
    far = view(now_s=100.0, printed_beta=1.0)
    assert printed.worths(far).argmax() == 1


def test_a_place_counts_once_whoever_was_there_and_however_often():
    trail = np.array([[2.0, 0.0, 0.0, 1.0], [2.05, 0.0, 0.0, 2.0]])
    seen = view(trail=trail, tags=(tag(memory(visited=[(5, 0)])),))
    np.testing.assert_allclose(visited_places(seen), [[2.0, 0.0]])


def test_crowding_ends_at_tau_and_is_bounded_near_by():
    places = np.array([[0.0, 0.0]])
    assert crowding(places, np.array([[4.1, 0.0]]), 4.0)[0] == 0.0
    assert crowding(places, np.array([[0.1, 0.0]]), 4.0)[0] == pytest.approx(1 / 0.4)


def test_a_frontier_others_left_open_is_worth_a_metre_of_way_more():
    told = tag(memory(frontiers=[(4, 0)]))
    seen = view(tags=(told,), known_to_m=4.5, tau_m=5.0)
    np.testing.assert_allclose(Kleiner().worths(seen), [-4.0, -3.0])
    assert Kleiner().reason(seen, 1) == "the unknown that another robot left open; nobody was near it"
    assert Kleiner().reason(seen, 0) == "an edge of the unknown; nobody was near it"


def test_a_foreign_frontier_in_the_unknown_is_planned_to_as_if_the_way_were_free():
    told = tag(memory(frontiers=[(4, 3)]), (4.0, 0.0))
    seen = view(tags=(told,), known_to_m=4.0, tau_m=6.0)
    own_and_foreign = Kleiner().candidates(seen)
    (foreign,) = own_and_foreign[2:]
    assert isinstance(foreign, Foreign)
    assert foreign.at_m == (8.0, 3.0)
    assert foreign.goal_m == RIGHT.goal_m
    assert foreign.cost_m == pytest.approx(4.0 + 5.0)


def test_a_foreign_frontier_goes_when_the_map_knows_all_round_it_and_not_before():
    told = tag(memory(frontiers=[(3, 0)]))
    assert len(Kleiner().candidates(view(tags=(told,), known_to_m=2.8))) == 3
    assert len(Kleiner().candidates(view(tags=(told,), known_to_m=3.2))) == 3
    assert len(Kleiner().candidates(view(tags=(told,), known_to_m=3.6))) == 2


def test_algorithm_1():
    tag_m = np.array([10.0, 0.0])
    added, v_tag = synchronise_visited(np.array([[9.0, 0.0], [2.0, 0.0]]), np.array([[0.0, 2.0]]), tag_m, 4.0)
    np.testing.assert_allclose(added, [[10.0, 2.0]])
    np.testing.assert_allclose(v_tag, [[0.0, 2.0], [-1.0, 0.0], [0.0, 2.0]])


def test_algorithm_2_as_printed_deletes_what_the_reader_never_saw_and_mirrors_what_it_writes():
    tag_m = np.array([10.0, 0.0])
    frontier = np.array([[11.0, 1.0]])

    def is_frontier(places):
        return (np.abs(places[:, None] - frontier[None]).max(axis=2) < 0.5).any(axis=1)

    told = np.array([[1.0, 1.0], [-3.0, 0.0]])  # the second lies where the reader has never been
    foreign, f_tag = synchronise_frontiers(frontier, told, tag_m, 4.0, is_frontier)
    np.testing.assert_allclose(foreign, [[11.0, 1.0]])
    np.testing.assert_allclose(f_tag, [[1.0, 1.0], [-1.0, -1.0]])


def test_eq_7_by_hand_and_clipped_only_where_it_would_divide_by_zero():
    visits = np.array([[3.0, 4.0, 90.0], [0.0, 2.0, 100.0], [1.0, 0.0, 105.0]])
    assert pull(np.zeros((1, 2)), visits, 100.0)[0] == pytest.approx(5.0 / 10.0 + 2.0 / 1.0 + 1.0 / 1.0)


def test_the_printed_robot_takes_its_planned_way_for_visited():
    strategy = KleinerPrinted()
    ahead = replace(view(now_s=10.0, printed_beta=1.0), path_m=np.array([[0.0, 0.0], [2.0, 0.0]]))
    worths = strategy.worths(ahead)
    np.testing.assert_allclose(strategy.worths(ahead), worths)  # asked again in the same cycle, the same
    poses = np.array([[x, 0.0, 10.0] for x in (0.0, 0.5, 1.0, 1.5)])
    np.testing.assert_allclose(worths, -4.0 - pull(np.array([[-4.0, 0.0], [4.0, 0.0]]), poses, 10.0))


def test_the_printed_answer_to_a_tag_holds_frontiers_mirrored_and_visits():
    trail = np.array([[0.4, 0.0, 0.0, 1.0], [0.8, 0.0, 0.0, 2.0], [8.0, 0.0, 0.0, 3.0]])
    answer = KleinerPrinted().answer(memory(visited=[(-3, 0)]), view(trail=trail, known_to_m=2.0), (1.0, 0.0))
    np.testing.assert_allclose(sorted(answer.visited_m[:, 0]), [-1.2, -0.4, 0.0], atol=0.21)
    assert len(answer.frontiers_m)
    assert answer.frontiers_m[:, 0].max() == pytest.approx(3.0)  # the edge at x = -2 lies 3 m behind the tag
