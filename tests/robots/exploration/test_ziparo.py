"""Ziparo's utility by hand."""

import numpy as np
import pytest

from robots.exploration.frontiers import Frontier
from robots.exploration.strategies.ziparo import Ziparo, angles, local_visits, visited
from robots.exploration.strategy import ExplorationView
from robots.exploration.told.claims import KnownTag
from robots.exploration.told.survey import Survey
from robots.se2 import Pose2
from robots.tags.memory import TagMemory

SURVEY = Survey(np.ones((2, 2)), np.zeros((2, 2), np.uint8), (0.0, 0.0))


def frontier(x, y):
    return Frontier((0, 0), (x, y), 1.0, 2.0)


def tag(name, place, visits):
    """A tag that holds visits: cells of 0.4 m north and west of it, and how often."""
    driven = np.zeros((21, 21), np.uint8)
    for (north, west), count in visits.items():
        driven[north + 10, west + 10] = count
    return KnownTag(name, place, TagMemory(np.zeros((1, 1), np.uint8), visited=driven), 0.0)


def view(*frontiers, heading=0.0, tags=()):
    return ExplorationView(Pose2(0.0, 0.0, heading), frontiers, lambda: SURVEY, tags=tags)


def test_the_angle_grows_quadratically_with_the_turn():
    seen = view(frontier(2.0, 0.0), frontier(0.0, 2.0), frontier(-2.0, 0.0))
    np.testing.assert_allclose(angles(seen), [0.0, np.pi / 2, np.pi])
    np.testing.assert_allclose(Ziparo().worths(seen), [0.0, -(np.pi**2) / 4, -(np.pi**2)])


def test_eq_8_by_hand():
    """Once 2 m and twice 1 m from the frontier: 1 / 2 + 2 / 1."""
    seen = view(
        frontier(2.0, 0.0), tags=(tag("A", (0.0, 0.0), {(0, 0): 1}), tag("B", (1.0, 0.0), {(0, 0): 2}))
    )
    places, counts = local_visits(seen)
    np.testing.assert_allclose(places, [[0.0, 0.0], [0.8, 0.0]])  # in cells of 0.4 m
    np.testing.assert_allclose(counts, [1.0, 2.0])
    assert visited(seen)[0] == pytest.approx(1 / 2.0 + 2 / 1.2)


def test_a_cell_that_two_tags_hold_counts_once():
    both = (tag("A", (0.0, 0.0), {(1, 0): 1}), tag("B", (0.8, 0.0), {(-1, 0): 2}))
    np.testing.assert_allclose(local_visits(view(frontier(2.0, 0.0), tags=both))[1], [2.0])


def test_tags_out_of_reach_of_the_local_map_say_nothing():
    seen = view(frontier(2.0, 0.0), tags=(tag("A", (2.5, 0.0), {(0, 0): 1}),))
    assert visited(seen)[0] == 0.0


def test_a_visit_at_the_frontier_itself_is_bounded():
    seen = view(frontier(0.0, 0.0), tags=(tag("A", (0.0, 0.0), {(0, 0): 1}),))
    assert visited(seen)[0] == pytest.approx(1 / 0.4)


def test_robots_turn_off_where_the_way_ahead_is_worn():
    ahead, aside = frontier(2.0, 0.0), frontier(0.0, 2.0)
    assert Ziparo().worths(view(ahead, aside)).argmax() == 0
    worn = tag("A", (1.0, 0.0), {(k, j): 2 for k in range(0, 4) for j in range(-2, 3)})
    seen = view(ahead, aside, tags=(worn,))
    assert Ziparo().worths(seen).argmax() == 1
    assert Ziparo().reason(seen, 1).startswith("the unknown to the side; tags tell of")
    assert Ziparo().reason(view(ahead), 0) == "the unknown ahead; tags tell of no visits near it"
