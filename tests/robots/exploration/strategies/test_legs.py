"""Tours driven leg by leg until nothing is left: what is kept to, and what is planned anew."""

from dataclasses import replace

import numpy as np
import pytest

from robots.config import AgentConfig
from robots.exploration.frontiers import Leg
from robots.exploration.goals import Goals
from robots.exploration.ground import Ground
from robots.exploration.strategies.sweep import Sweep
from robots.exploration.strategies.three_grids import three_grids
from robots.exploration.strategies.tours.stations import NEW, SAFE, without_ghosts
from robots.exploration.team.communication import Communication
from robots.planning.plan_grid import FREE, OCCUPIED, UNKNOWN
from tests.robots.exploration.strategies.halls import (
    COARSE_M,
    REACH_M,
    SWEEPING,
    grid_of,
    hall,
    view_at,
)


def followed(grid, x, y, most_legs=40):
    """Drive leg by leg until no tour is left; return the trail and the legs."""
    sweep, trail, legs = Sweep(), [(x, y)], []
    while len(legs) < most_legs:
        view = view_at(grid, *trail[-1], trail)
        found = sweep.candidates(view)
        if len(found) != 1 or not isinstance(found[0], Leg):
            return trail, legs
        legs.append(found[0])
        trail += Ground.of(grid, view.pose).way_to(found[0])[1:].tolist()
    return trail, legs


def test_a_hall_is_swept_in_lanes_and_then_there_is_no_tour_left():
    grid = hall()
    trail, legs = followed(grid, 2.1, 2.1)
    way = np.column_stack([trail, np.zeros(len(trail))])
    gone_m = np.concatenate([[0.0], np.hypot(*np.diff(way[:, :2], axis=0).T).cumsum()])

    def share(metres: float) -> float:
        safe = three_grids(grid, way[gone_m <= metres], REACH_M).safe
        return float(safe.sum() / (grid.cells == FREE).sum())

    assert share(36.0) > 0.9  # two lanes of 15 m, and 6 m between them
    assert share(gone_m[-1]) > 0.97
    assert gone_m[-1] < 75.0
    assert len(legs) < 8
    assert all(leg.cost_m < 16.5 for leg in legs)


def test_pillars_are_driven_round():
    pillars = tuple(np.s_[r : r + 3, c : c + 3] for r in (15, 40) for c in (20, 45, 70))
    grid = hall(pillars)
    trail, _ = followed(grid, 2.1, 2.1)
    for x, y in trail:
        assert grid.steps[grid.cell_of(x, y)] > 0
    safe = three_grids(grid, np.column_stack([trail, np.zeros(len(trail))]), REACH_M).safe
    assert safe.sum() > 0.95 * (grid.cells == FREE).sum()


def test_ground_that_cannot_be_reached_is_no_reason_to_go_on():
    _, legs = followed(hall((np.s_[:, 30:32],)), 2.1, 2.1)
    assert all(x < 6.0 for leg in legs for x, _ in leg.way_m)
    assert len(legs) < 6


def test_what_stays_unknown_though_it_was_looked_at_is_left():
    cells = hall().cells.copy()
    cells[20:30, 40:50] = UNKNOWN
    grid = grid_of(cells)
    kinds = np.where(cells.reshape(30, 2, 50, 2).max(axis=(1, 3)) == OCCUPIED, 0, NEW).astype(np.uint8)
    left = without_ghosts(grid, kinds, COARSE_M, np.array([(9.0, 3.0), (9.0, 7.0)]), REACH_M)
    assert (left[10:15, 20:25] == SAFE).all()
    assert ((left == SAFE) <= (kinds == NEW)).all()
    assert (left == SAFE).sum() == 25
    _, legs = followed(grid, 2.1, 2.1)
    assert len(legs) < 10


def test_a_leg_never_turns_back_on_itself():
    pillars = tuple(np.s_[r : r + 3, c : c + 3] for r in (15, 40) for c in (20, 45, 70))
    _, legs = followed(hall((*pillars, np.s_[10:50, 30:32])), 2.1, 2.1)
    assert len(legs) >= 4
    for leg in legs:
        way = np.array(leg.way_m)
        assert all(
            np.hypot(*(way[: max(0, k - 10)] - way[k]).T).min(initial=9.0) > 0.5 for k in range(len(way))
        )
        steps = np.diff(way, axis=0)
        assert (np.sum(steps[1:] * steps[:-1], axis=1) > -0.005).all()


def on_a_leg():
    grid = hall()
    sweep, view = Sweep(), view_at(grid, 2.1, 2.1, [(2.1, 2.1)])
    (leg,) = sweep.candidates(view)
    return grid, sweep, leg


def test_a_leg_is_kept_to_its_end_and_planned_once():
    grid, sweep, leg = on_a_leg()
    assert not leg.begun
    for at in leg.way_m[5:-5:5]:
        (kept,) = sweep.candidates(replace(view_at(grid, *at, [(2.1, 2.1), at]), goal_m=leg.goal_m))
        assert (kept.begun, kept.goal_m) == (True, leg.goal_m)
        assert kept.way_m == leg.way_m[leg.way_m.index(at) :]
        assert kept.cost_m == pytest.approx(0.2 * (len(kept.way_m) - 1), rel=0.1)
    end = leg.way_m[-2]
    (following,) = sweep.candidates(replace(view_at(grid, *end, leg.way_m), goal_m=leg.goal_m))
    assert not following.begun


def test_planning_is_charged_once_a_leg():
    grid, trail = hall(), [(2.1, 2.1)]
    goals = Goals(replace(SWEEPING, explore="waymark"), Communication("r1", AgentConfig()))
    charged = []
    for _ in range(40):
        choice = goals.choose(view_at(grid, *trail[-1], trail))
        assert choice is not None
        goals.goal_m = choice.frontier.goal_m
        charged.append((goals.take_planned(), choice.frontier.goal_m))
        trail.append(choice.frontier.way_m[5])
    legs = {goal for _, goal in charged}
    assert len(legs) >= 2
    assert sum(planned for planned, _ in charged) == len(legs)
    assert all(
        planned == (goal != before)
        for (planned, goal), (_, before) in zip(charged[1:], charged, strict=False)
    )


@pytest.mark.parametrize("goal", ["lost", "shut"])
def test_a_leg_that_was_given_up_or_shut_is_planned_anew(goal):
    grid, sweep, leg = on_a_leg()
    if goal == "shut":
        row, column = grid.cell_of(*leg.way_m[len(leg.way_m) // 2])
        grid.cells[row - 1 : row + 2, column - 1 : column + 2] = OCCUPIED
        grid.steps[row - 1 : row + 2, column - 1 : column + 2] = 0
    view = replace(view_at(grid, 2.1, 2.1, [(2.1, 2.1)]), goal_m=leg.goal_m if goal == "shut" else None)
    (found,) = sweep.candidates(view)
    assert not found.begun
    for x, y in found.way_m:
        assert grid.steps[grid.cell_of(x, y)] > 0


def test_a_leg_whose_end_came_to_nothing_gives_way_to_other_places():
    grid, sweep, leg = on_a_leg()
    found = sweep.candidates(replace(view_at(grid, 2.1, 2.1, [(2.1, 2.1)]), aside_m=(leg.goal_m,)))
    assert len(found) > 20
    assert not any(isinstance(place, Leg) for place in found)


def test_robots_side_by_side_take_tours_to_their_own_ends_of_a_hall():
    """Alone, both would begin with the longer part, which lies beyond the other."""
    grid, middle = hall(), 10.0
    places = [(9.1, 6.1), (10.9, 6.1)]
    for mine, other in (places, places[::-1]):
        view = replace(
            view_at(grid, *mine, [mine]),
            mates_trail=np.array([(*other, 0.0, 0.0)]),
            mates_ways=np.array([(*other, 0.0)]),
        )
        (leg,) = Sweep().candidates(view)
        assert (np.mean([x for x, _ in leg.way_m]) < middle) == (mine[0] < middle)
