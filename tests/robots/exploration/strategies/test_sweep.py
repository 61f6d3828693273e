"""Ground to be made safe: worth as counted by brute force, and lanes through new ground."""

from dataclasses import replace
from math import hypot

import numpy as np
import pytest

from robots.config import PlanningConfig
from robots.exploration.settings import SafeGroundConfig
from robots.exploration.strategies.sweep import Sweep, kinds_of
from robots.exploration.strategies.waymark import Waymark
from robots.exploration.strategy import ExplorationView, goals_of
from robots.exploration.told.survey import Survey
from robots.planning.plan_grid import FREE, OCCUPIED, PlanGrid
from robots.planning.travel import travel_costs
from robots.se2 import Pose2

SURVEY = Survey(np.ones((2, 2)), np.zeros((2, 2), np.uint8), (0.0, 0.0))
SWEEPING = PlanningConfig(safe=SafeGroundConfig(sweep=True))
CELL_M = 0.2


def hall(walls: tuple[tuple[slice, slice], ...] = ()) -> PlanGrid:
    """20 m by 12 m of free ground in walls."""
    cells = np.full((60, 100), FREE, np.uint8)
    for wall in (np.s_[[0, -1], :], np.s_[:, [0, -1]], *walls):
        cells[wall] = OCCUPIED
    return PlanGrid(cells, np.where(cells == FREE, 5, 0).astype(np.uint8), (0.0, 0.0), CELL_M)


def view_at(grid: PlanGrid, x: float, y: float, trail: list[tuple[float, float]]) -> ExplorationView:
    return ExplorationView(
        Pose2(x, y),
        (),
        lambda: SURVEY,
        grid=grid,
        costs=travel_costs(grid, *grid.cell_of(x, y)),
        trail=np.array([(*point, 0.0, 0.0) for point in trail]),
        settings=SWEEPING,
    )


def swept(view: ExplorationView) -> tuple[Sweep, ExplorationView]:
    """Return the view with places to weigh one by one, as where no tour gains anything."""
    sweep = Sweep()
    sweep.candidates(view)
    assert view.grid is not None
    assert view.costs is not None
    return sweep, replace(view, frontiers=sweep.places(view, view.grid, view.costs))


def test_places_to_go_to_are_what_is_not_safe_and_can_be_reached():
    shut = hall(((slice(None), slice(70, 71)),))
    _, seen = swept(view_at(shut, 2.0, 6.0, [(2.0, 6.0)]))
    assert len(seen.frontiers) > 20
    for place in seen.frontiers:
        assert hypot(place.goal_m[0] - 2.0, place.goal_m[1] - 6.0) > 2.7
        assert place.goal_m[0] < 14.0
    assert [p.cost_m for p in seen.frontiers] == sorted(p.cost_m for p in seen.frontiers)


def test_the_ground_on_the_way_is_counted_in_sight_once_and_where_it_is_new():
    grid = hall()
    sweep, seen = swept(view_at(grid, 4.0, 6.0, [(4.0, 6.0)]))
    areas = sweep.areas(seen, goals_of(seen))
    for place, area in zip(seen.frontiers, areas, strict=True):
        kinds = kinds_of(grid, np.zeros_like(grid.cells, bool))
        rows, columns = np.indices(kinds.shape)
        x, y = (columns + 0.5) * 0.4, (rows + 0.5) * 0.4
        way = np.linspace((4.0, 6.0), place.goal_m, 40)
        off = np.min([np.hypot(x - wx, y - wy) for wx, wy in way], axis=0)
        new = (kinds != 0) & (off < 3.0) & (np.hypot(x - 4.0, y - 6.0) > 3.0)
        assert area == pytest.approx(new.sum() * 0.16, rel=0.25, abs=2.5)


def test_a_wall_hides_what_lies_behind():
    open_, walled = hall(), hall(((slice(30, 31), slice(None)),))  # at y = 6
    at, trail = (4.0, 4.6), [(4.0, 4.6)]
    goal = (12.0, 4.6)
    areas = []
    for grid in (open_, walled):
        sweep, seen = swept(view_at(grid, *at, trail))
        nearest = min(
            range(len(seen.frontiers)), key=lambda k: np.hypot(*np.subtract(seen.frontiers[k].goal_m, goal))
        )
        areas.append(sweep.areas(seen, goals_of(seen))[nearest])
    assert areas[1] < 0.85 * areas[0]


def test_a_lane_through_new_ground_is_worth_more_than_the_rim_and_waymark_says_how_much():
    view = view_at(hall(), 4.0, 6.0, [(4.0, 6.0)])
    sweep, seen = swept(view)
    worths = sweep.worths(seen)
    best = int(np.argmax(worths))
    assert seen.frontiers[best].cost_m > 6.0
    assert worths[best] > worths[0]
    waymark = Waymark()
    (leg,) = waymark.candidates(view)
    gained_m = waymark.worths(replace(view, frontiers=(leg,)))[0] + leg.cost_m
    assert gained_m > 0.27 * 40.0  # of way, for at least 40 m2
    assert waymark.reason(replace(view, frontiers=(leg,)), 0).startswith("make about ")


def test_where_all_is_safe_there_is_nowhere_to_go():
    trail = [(x, y) for x in np.arange(1.0, 20.0) for y in np.arange(1.0, 12.0)]
    _, seen = swept(view_at(hall(), 4.0, 6.0, trail))
    assert seen.frontiers == ()


def test_ground_on_the_way_of_another_robot_is_left_to_it():
    view = view_at(hall(), 4.0, 6.0, [(4.0, 6.0)])
    way = np.column_stack([np.arange(4.0, 19.0), np.full(15, 9.0), np.zeros(15)])
    _, alone = swept(view)
    sweep, beside = swept(replace(view, mates_ways=way))
    left = [place.goal_m for place in beside.frontiers]
    assert {place.goal_m for place in alone.frontiers} > set(left)
    assert all(np.hypot(*(way[:, :2] - goal).T).min() > 2.7 for goal in left)
    best = beside.frontiers[int(np.argmax(sweep.worths(beside)))]
    assert best.goal_m[1] < 6.0
