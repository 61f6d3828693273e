"""Sharing out frontiers: laws for teams anywhere in a plan, and hand examples of the papers' algorithms."""

from dataclasses import replace
from itertools import permutations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robots.config import ConfigError
from robots.exploration.coordination import COORDINATIONS, coordination_of
from robots.exploration.coordination.burgard import UTILITY_M
from robots.exploration.coordination.exclusion import KEEP_OFF_M, Exclusion
from robots.exploration.coordination.hungarian import assigned
from robots.exploration.coordination.node_counting import NodeCounting
from robots.exploration.coordination.original import Original
from robots.exploration.coordination.team import NEVER, Mate, Selfish, Team, greedy_pairs
from robots.exploration.frontiers import Frontier
from robots.exploration.strategies.nearest import Nearest
from robots.exploration.strategy import ExplorationView, ways_of
from robots.exploration.told.claims import KnownTag
from robots.exploration.told.survey import Survey
from robots.planning.plan_grid import FREE, OCCUPIED, PlanGrid
from robots.planning.travel import UNREACHED, travel_costs
from robots.se2 import Pose2
from robots.tags.marks import Pass
from robots.tags.memory import TagMemory

WALL_COLUMN, GAP_ROW = 40, 6  # a hall of 10 m by 8 m, halved by a wall with a gap of 0.4 m near its lower end


class Ratio:
    """Eq. (1) of Amigoni 2013 with A P = 10 and b = 1."""

    def worths(self, view):
        return 10.0 / np.maximum(ways_of(view), 0.1)

    def reason(self, view, index):
        return "its ratio"


def hall() -> PlanGrid:
    cells = np.full((80, 100), FREE, np.uint8)
    cells[[0, -1]], cells[:, [0, -1]] = OCCUPIED, OCCUPIED
    cells[:GAP_ROW, WALL_COLUMN], cells[GAP_ROW + 4 :, WALL_COLUMN] = OCCUPIED, OCCUPIED
    return PlanGrid(cells, np.where(cells == FREE, 5, 0).astype(np.uint8), (0.0, 0.0), 0.1)


def view_from(pose: Pose2, goals_m, grid: PlanGrid | None = None) -> ExplorationView:
    grid = hall() if grid is None else grid
    costs = travel_costs(grid, *grid.cell_of(pose.x, pose.y))
    frontiers = []
    for x, y in goals_m:
        cell = grid.cell_of(x, y)
        way = costs[cell] / 50.0 if costs[cell] != UNREACHED else 1e3
        frontiers.append(Frontier(cell, grid.centre_of(*cell), 1.0, way))
    survey = Survey(np.ones((16, 20)), np.zeros((16, 20), np.uint8), (0.0, 0.0))
    return ExplorationView(pose, tuple(frontiers), lambda: survey, grid=grid, costs=costs)


def teams_of(mates, goals_m, strategy=None):
    """The team as each of its robots sees it."""
    strategy = strategy or Nearest()
    return [
        Team(
            me.robot_id,
            view_from(me.pose, goals_m),
            strategy,
            me.goal_m,
            [mate for mate in mates if mate.robot_id != me.robot_id],
        )
        for me in mates
    ]


place = st.tuples(st.integers(2, 97), st.integers(2, 77)).filter(lambda c: abs(c[0] - WALL_COLUMN) > 1)
places = st.lists(place, min_size=1, max_size=6, unique=True).map(
    lambda cells: [((c + 0.5) / 10, (r + 0.5) / 10) for c, r in cells]
)
mates = st.lists(place, min_size=1, max_size=5, unique=True).map(
    lambda cells: [
        Mate(f"r{k + 1}", Pose2((c + 0.5) / 10, (r + 0.5) / 10, 0.0), None) for k, (c, r) in enumerate(cells)
    ]
)
laws = settings(max_examples=40, deadline=None)


@given(mates, places, st.sampled_from(sorted(COORDINATIONS)))
@laws
def test_alone_everybody_goes_where_it_is_worth_most(team, goals, name):
    alone = teams_of(team[:1], goals)[0]
    assert COORDINATIONS[name]().choose(alone) == int(np.argmax(alone.own))


@given(mates, places, st.sampled_from(sorted(COORDINATIONS)), st.randoms())
@laws
def test_who_was_heard_first_changes_nothing(team, goals, name, chance):
    others = team[1:]
    shuffled = list(others)
    chance.shuffle(shuffled)
    view = view_from(team[0].pose, goals)
    choices = {
        COORDINATIONS[name]().choose(Team(team[0].robot_id, view, Nearest(), None, order))
        for order in (others, shuffled)
    }
    assert len(choices) == 1


@given(mates, places, st.sampled_from(["simplified", "original", "hungarian"]))
@laws
def test_robots_that_know_the_same_never_share_a_frontier_while_there_are_enough(team, goals, name):
    chosen = [COORDINATIONS[name]().choose(seen) for seen in teams_of(team, goals, Ratio())]
    if len(goals) >= len(team):
        assert len(set(chosen)) == len(team)
    else:
        assert set(chosen) == set(range(len(goals)))


@given(st.integers(1, 4), st.integers(1, 5), st.integers(0, 2**32 - 1))
@laws
def test_the_assignment_is_worth_most_of_all(robots, frontiers, seed):
    worths = np.random.default_rng(seed).normal(0.0, 10.0, (robots, frontiers))
    chosen = assigned(worths)
    got = sum(worths[r, f] for r, f in enumerate(chosen) if f >= 0)
    if robots <= frontiers:
        best = max(worths[range(robots), list(p)].sum() for p in permutations(range(frontiers), robots))
    else:
        best = max(worths[list(p), range(frontiers)].sum() for p in permutations(range(robots), frontiers))
    assert got == pytest.approx(best)


def test_what_cannot_be_reached_is_given_to_nobody():
    worths = np.array([[NEVER, -3.0], [NEVER, -2.0]])
    assert assigned(worths).tolist() == [-1, 1]
    assert greedy_pairs(worths).tolist() == [-1, 1]


@given(mates, places, st.lists(place, min_size=5, max_size=5))
@laws
def test_an_excluded_frontier_is_taken_only_where_all_are(team, goals, targets):
    heading = [replace(m, goal_m=(c / 10, r / 10)) for m, (c, r) in zip(team[1:], targets, strict=False)]
    seen = Team(team[0].robot_id, view_from(team[0].pose, goals), Nearest(), None, heading)
    far = [
        all(np.hypot(x - m.goal_m[0], y - m.goal_m[1]) >= KEEP_OFF_M for m in heading)
        for x, y in seen.frontiers_m
    ]
    chosen = Exclusion().choose(seen)
    assert far[chosen] or not any(far)
    if any(far):
        assert seen.own[chosen] == max(w for w, ok in zip(seen.own, far, strict=True) if ok)


def test_of_two_that_go_to_one_place_the_nearer_stays():
    goals = [(2.0, 2.0), (8.0, 7.0)]
    both = [Mate("r1", Pose2(3.0, 2.0, 0.0), goals[0]), Mate("r2", Pose2(3.0, 5.0, 0.0), goals[0])]
    assert [Exclusion().choose(seen) for seen in teams_of(both, goals)] == [0, 1]


@given(mates, places)
@laws
def test_pairs_by_planning_where_it_counts_are_those_by_planning_all(team, goals):
    """The paper's claim for eq. (1): "guaranteed to select the best pair according to d_PP"."""
    for row, seen in enumerate(teams_of(team, goals, Ratio())):
        by_ways = np.array(
            [seen.worths_by(r, np.maximum(seen.ways_of(r), seen.straight(r))) for r in range(len(team))]
        )
        expected = greedy_pairs(np.where(np.isfinite(by_ways) & (by_ways > 0), by_ways, NEVER))[row]
        chosen = Original().choose(seen)
        if expected >= 0 and len(np.unique(np.round(by_ways, 9))) == by_ways.size:
            assert chosen == expected
        assert seen.planned <= by_ways.size


def test_planning_pays_only_round_the_wall():
    """Through the wall it is 2 m, by the gap 13 m: only the planned way tells."""
    goals = [(5.0, 7.0), (1.0, 4.0)]
    team = [Mate("r1", Pose2(3.0, 7.0, 0.0), None), Mate("r2", Pose2(9.0, 7.0, 0.0), None)]
    assert [COORDINATIONS["simplified"]().choose(seen) for seen in teams_of(team, goals, Ratio())] == [0, 1]
    assert [COORDINATIONS["original"]().choose(seen) for seen in teams_of(team, goals, Ratio())] == [1, 0]


def test_utilities_fall_where_another_will_look():
    """Burgard's Algorithm 1 by hand: r1 takes a; b, 1 m from it, is worth 3/4 less to r2, which takes c."""
    open_hall = hall()
    open_hall.cells[1:-1, WALL_COLUMN], open_hall.steps[1:-1, WALL_COLUMN] = FREE, 5
    a, b, c = (2.05, 2.05), (3.05, 2.05), (8.05, 2.05)
    r1, r2 = Mate("r1", Pose2(1.05, 2.05, 0.0), None), Mate("r2", Pose2(1.05, 3.05, 0.0), None)
    values = {
        me.robot_id: Team(me.robot_id, view_from(me.pose, (a, b, c), open_hall), Nearest(), None, [other])
        for me, other in ((r1, r2), (r2, r1))
    }
    ways = -values["r1"].worths
    assert ways[0].argmin() == ways[1].argmin() == 0  # both would go to a
    assert ways[1, 1] + 0.75 * UTILITY_M > ways[1, 2]
    assert [COORDINATIONS["burgard"]().choose(values[name]) for name in ("r1", "r2")] == [0, 2]
    assert [Selfish().choose(values[name]) for name in ("r1", "r2")] == [0, 0]


def test_everybody_has_the_frontiers_it_is_nearest_to():
    goals = [(1.0, 7.0), (3.0, 1.0), (9.0, 7.0)]
    team = [Mate("r1", Pose2(2.0, 4.0, 0.0), None), Mate("r2", Pose2(5.0, 0.7, 0.0), None)]
    assert [COORDINATIONS["voronoi"]().choose(seen) for seen in teams_of(team, goals)] == [0, 1]


def test_where_fewer_have_been_comes_first_and_where_nobody_was_before_that():
    goals = [(2.05, 4.05), (6.05, 4.05), (9.05, 1.05)]
    seen = view_from(Pose2(1.05, 4.05, 0.0), goals)

    def tag(x, *counts):
        passes = tuple(Pass(count, 0, 0, 0, key) for key, count in enumerate(counts))
        return KnownTag(f"t{x}", (x, 4.0), replace(TagMemory.empty(), passes=passes), 0.0)

    def chosen(*tags):
        return NodeCounting().choose(Team("r1", replace(seen, tags=tags), Nearest(), None))

    assert chosen() == chosen(tag(2.0), tag(6.0)) == 0
    assert chosen(tag(2.0, 3, 2), tag(6.0, 4)) == 2
    assert chosen(tag(2.0, 3, 2), tag(6.0, 4), replace(tag(9.0, 9), place_m=(9.0, 1.0))) == 1


def test_chance_spreads_and_stays_with_what_it_drew():
    goals = [(1.0, 7.0), (3.0, 1.0), (9.0, 7.0), (6.0, 2.0)]
    here, there = Mate("r1", Pose2(2.0, 4.0, 0.0), None), Mate("r2", Pose2(5.0, 0.7, 0.0), goals[2])
    random, view = COORDINATIONS["random"](), view_from(here.pose, goals)
    drawn = [random.choose(Team("r1", view, Nearest(), None, [there])) for _ in range(30)]
    assert set(drawn) == {0, 1, 3}
    on_the_way = Team("r1", view, Nearest(), goals[3], [there])
    assert [random.choose(on_the_way) for _ in range(5)] == [3] * 5


def test_a_goal_on_the_way_is_kept_unless_another_is_much_better():
    goals = [(2.05, 4.05), (2.55, 7.05)]
    me = Pose2(2.05, 5.35, 0.0)
    assert Selfish().choose(Team("r1", view_from(me, goals), Nearest(), None)) == 0
    assert Selfish().choose(Team("r1", view_from(me, goals), Nearest(), goals[1])) == 1
    nearer = Pose2(2.05, 4.75, 0.0)
    assert Selfish().choose(Team("r1", view_from(nearer, goals), Nearest(), goals[1])) == 0


def test_an_unknown_name_is_refused_with_those_that_are_known():
    with pytest.raises(
        ConfigError, match=r"planning\.coordinate: no coordination is called 'auction'; known"
    ):
        coordination_of("auction")


def test_an_old_goal_is_kept_for_a_little_less_unless_the_best_is_printed():
    """Ways of 3 and 4 m; the robot is on its way to the farther one."""
    view = view_from(Pose2(5.0, 4.0, 0.0), [(8.0, 4.0), (5.0, 7.6)])
    kept = Team("r1", view, Nearest(), view.frontiers[1].goal_m)
    assert Selfish().choose(kept) == 1

    class Printed(Nearest):
        takes_the_best = True

    assert Selfish().choose(Team("r1", view, Printed(), view.frontiers[1].goal_m)) == 0
