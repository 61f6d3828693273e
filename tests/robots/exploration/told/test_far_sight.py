"""A robot with a small map among tags: covered ground, ways along tags, and open ground far off."""

from dataclasses import replace

import numpy as np
import pytest

from robots.config import PlanningConfig
from robots.exploration.strategies.waymark import Waymark
from robots.exploration.strategy import ExplorationView
from robots.exploration.told.atlas import Atlas
from robots.exploration.told.claims import KnownTag
from robots.exploration.told.far_sight import FarFrontier, FarSight
from robots.exploration.told.survey import Survey
from robots.exploration.told.tag_ways import TagWays
from robots.planning.plan_grid import FREE, OCCUPIED, UNKNOWN, PlanGrid
from robots.planning.travel import travel_costs
from robots.se2 import Pose2
from robots.tags.memory import CLOSED, OPEN, TagMemory

CELL_M = 0.1
NOTHING = Survey(np.ones((2, 2)), np.zeros((2, 2), np.uint8), (0.0, 0.0))


def window(x: float, free_to: float = 100.0) -> PlanGrid:
    """4 m of a corridor along x, 2 m wide, round a robot at x, in unknown ground; a wall may end it."""
    cells = np.full((44, 44), UNKNOWN, np.uint8)
    left = round(x / CELL_M) * CELL_M - 2.2
    xs = left + (np.arange(44) + 0.5) * CELL_M
    inside = np.abs(xs - x) < 2.0
    cells[11:33, inside & (xs < free_to)] = OCCUPIED
    cells[12:32, inside & (xs < free_to)] = FREE
    cells[11:33, inside & (xs >= free_to) & (xs < free_to + CELL_M)] = OCCUPIED
    return PlanGrid(cells, (cells == FREE).astype(np.uint8) * 5, (left, -2.2), CELL_M)


def view(x: float, tags=(), now_s=0.0, free_to=100.0, y=0.0) -> ExplorationView:
    grid = window(x, free_to)
    costs = travel_costs(grid, *grid.cell_of(x, y))
    settings = PlanningConfig(local_map_m=4.0)
    return ExplorationView(
        Pose2(x, y, 0.0), (), lambda: NOTHING, now_s, grid, costs, tags=tuple(tags), settings=settings
    )


def tag(name: str, x: float, states: dict[tuple[int, int], int] | None = None) -> KnownTag:
    cells = np.zeros((21, 21), np.uint8)
    for (north, west), state in (states or {}).items():
        cells[north + 10, west + 10] = state
    return KnownTag(name, (x, 0.0), TagMemory(cells), 0.0)


def covered(north_from: int, north_to: int) -> dict[tuple[int, int], int]:
    return {(n, w): CLOSED for n in range(north_from, north_to + 1) for w in (-2, -1, 0, 1, 2)}


def test_edges_beyond_which_tags_tell_of_covered_ground_are_none():
    assert {f.goal_m[0] > 10.0 for f in FarSight().candidates(view(10.0))} == {True, False}
    ahead = tag("A", 12.0, covered(-1, 4))
    (edge,) = FarSight().candidates(view(10.0, [ahead]))
    assert edge.goal_m[0] < 10.0


def test_a_robot_remembers_what_it_covered_itself():
    sight = FarSight()
    for x in np.arange(10.0, 14.1, 0.5):
        sight.candidates(view(float(x)))
    (edge,) = sight.candidates(view(14.0))
    assert edge.goal_m[0] > 14.0


def test_out_of_a_dead_end_it_goes_along_tags_to_the_ground_that_was_left_open():
    """From x = 10, where the corridor also goes on to the left, to its end at 16, and back along tags."""
    sight, tags = FarSight(), [tag(f"T{k}", 10.0 + k) for k in range(7)]
    for x in np.arange(10.0, 15.1, 0.5):
        sight.candidates(view(float(x), tags, free_to=16.0))
    seen = []
    x = 15.0
    for second in range(40):
        (frontier,) = sight.candidates(view(x, tags, float(second), free_to=16.0))
        seen.append(frontier)
        if not isinstance(frontier, FarFrontier):
            break
        assert frontier.at_m[0] == pytest.approx(8.25, abs=0.6)
        x += float(np.clip(frontier.goal_m[0] - x, -0.5, 0.5))
    assert isinstance(seen[0], FarFrontier)
    assert not isinstance(seen[-1], FarFrontier)
    assert seen[-1].goal_m[0] < 9.0
    assert seen[0].cost_m == pytest.approx(15.0 - 8.25, abs=1.5)


def test_it_leads_on_without_tags_where_the_robot_was_itself():
    sight = FarSight()
    for x in np.arange(10.0, 15.1, 0.5):
        sight.candidates(view(float(x), free_to=16.0))
    (frontier,) = sight.candidates(view(15.0, free_to=16.0))
    assert isinstance(frontier, FarFrontier)
    assert frontier.goal_m[0] < 14.8


def test_open_ground_that_cannot_be_got_nearer_to_is_left_for_a_while():
    sight = FarSight()
    behind_a_wall = tag("A", 10.0, covered(-4, 4) | {(0, 6): OPEN})
    (frontier,) = sight.candidates(view(10.0, [behind_a_wall]))
    assert frontier.goal_m[1] == pytest.approx(0.95)
    assert sight.candidates(view(10.0, [behind_a_wall], 10.0, y=0.9)) == ()
    assert sight.candidates(view(10.0, [behind_a_wall], 20.0)) == ()
    assert len(sight.candidates(view(10.0, [behind_a_wall], 400.0))) == 1


def test_waymark_weighs_what_it_found_and_says_why():
    strategy, tags = Waymark(), [tag(f"T{k}", 10.0 + k) for k in range(7)]
    for x in np.arange(10.0, 15.1, 0.5):
        seen = view(float(x), tags, free_to=16.0)
        strategy.candidates(seen)
    seen = replace(seen, frontiers=strategy.candidates(seen))
    assert strategy.worths(seen).shape == (1,)
    assert strategy.reason(seen, 0) == "ground that was left open, along tags"


def test_told_ground_yields_to_own_eyes_at_its_border_only():
    atlas = Atlas()
    atlas.draw([tag("A", 10.25, {(n, w): CLOSED for n in (-2, -1, 0, 1, 2) for w in (-2, -1, 0, 1, 2)})])
    atlas.see(window(10.0))
    atlas.settle()
    unknown = PlanGrid(np.zeros((30, 60), np.uint8), np.zeros((30, 60), np.uint8), (8.0, -1.0), CELL_M)
    covered = atlas.with_covered(unknown)
    at = [unknown.cell_of(x, 0.2) for x in (10.2, 11.9, 12.6)]
    assert [bool(covered[cell] == OCCUPIED) for cell in at] == [True, True, False]
    assert (atlas.open_places()[:, 0] < 8.5).any()


def test_a_tag_that_is_believed_elsewhere_is_drawn_anew():
    atlas = Atlas()
    memory = TagMemory(np.full((3, 3), CLOSED, np.uint8))
    for x in (0.0, 5.0):
        atlas.draw([KnownTag("A", (x, 0.0), memory, 0.0)])
        atlas.settle()
        columns = np.nonzero(atlas.cells == CLOSED)[1]
        assert (columns + 0.5).mean() * 0.5 + atlas.corner[1] * 0.5 == pytest.approx(x, abs=0.3)


def test_ways_along_tags_are_the_shortest_and_only_over_ground_that_was_seen_to_be_free():
    ways = TagWays()
    for name, place in [(f"T{k}", (9.0 + k, 0.0)) for k in range(7)]:
        ways.note(name, place)
    for x in (10.0, 11.0, 12.0, 13.0):
        ways.note("wall", (x, 1.9))
        grid = window(x)
        reached = ways.see((x, 0.0), grid, travel_costs(grid, *grid.cell_of(x, 0.0)))
        assert np.isinf(reached[7])
    found, before = ways.ways(np.array([0.0] + 7 * [np.inf]))
    assert found[6] == pytest.approx(6.0, abs=0.7)
    assert before[6] in (2, 3, 4, 5)
    assert 10.0 <= ways.between(int(before[6]), 6)[0] <= 13.0
    assert np.isinf(found[7])
