"""How far it is through covered ground to ground that nobody has told of."""

import numpy as np
import pytest

from robots.exploration.told.claims import Claims
from robots.exploration.told.outlook import ways_beyond
from robots.exploration.told.survey import LATTICE_M
from robots.planning.plan_grid import FREE, OCCUPIED, UNKNOWN, PlanGrid
from robots.tags.memory import CLOSED, OPEN, TagMemory

FARTHEST_M = 15.0


def corridor() -> PlanGrid:
    """40 m along x, 2 m wide between walls: the robot knows x 0 to 10."""
    cells = np.full((30, 400), UNKNOWN, np.uint8)
    cells[5:25, :100] = FREE
    cells[4, :100] = cells[25, :100] = OCCUPIED
    cells[5:25, 0] = OCCUPIED
    return PlanGrid(cells, np.zeros_like(cells), (0.0, -1.5), 0.1)


def beyond(*told, grid=None) -> float:
    """The way beyond the frontier at x = 10, given tags (x, window)."""
    claims, places = Claims(), {}
    for k, (x, cells) in enumerate(told):
        claims.hear(f"T{k}", TagMemory(cells))
        places[f"T{k}"] = (x, 0.0)
    grid = grid or corridor()
    survey = claims.survey(grid, claims.tags(places.get))
    return float(ways_beyond(grid, survey, np.array([[15, 98]]), FARTHEST_M)[0])


def covered(reach: int, rim: int = CLOSED) -> np.ndarray:
    """A corridor of 3 cells along x, so far to both sides, closed but for its far end."""
    cells = np.zeros((2 * reach + 1, 2 * reach + 1), np.uint8)
    cells[:, reach - 1 : reach + 2] = CLOSED
    cells[-1, reach - 1 : reach + 2] = rim
    return cells


def test_where_nobody_told_of_ground_there_is_no_way_beyond():
    assert beyond() == 0.0
    assert beyond((30.0, covered(3))) == pytest.approx(0.2, abs=0.11)


def test_it_is_as_far_as_the_open_end_of_what_is_covered():
    assert beyond((12.5, covered(5, OPEN))) == pytest.approx(17.0 - 9.85, abs=0.3)
    more = beyond((12.5, covered(5, OPEN)), (16.5, covered(5, OPEN)))
    assert more == pytest.approx(21.0 - 9.85, abs=0.3)


def test_from_closed_ground_there_is_no_way_into_the_unseen():
    assert beyond((12.5, covered(5))) == FARTHEST_M


def test_walls_that_the_robot_knows_are_in_the_way():
    grid = corridor()
    grid.cells[5:25, 99] = OCCUPIED
    assert beyond((12.5, covered(5, OPEN)), grid=grid) == FARTHEST_M


def test_better_ground_farther_on_counts_for_more_than_the_nearest():
    claims = Claims()
    claims.hear("A", TagMemory(covered(5, OPEN)))
    claims.hear("B", TagMemory(covered(5, OPEN)))
    survey = claims.survey(corridor(), claims.tags({"A": (12.5, 0.0), "B": (23.5, 0.0)}.get))
    handicaps = np.zeros(survey.claimed.shape)
    ways = []
    for handicap_m in (0.0, 5.0, 20.0):
        handicaps[:, : round(20.0 / LATTICE_M)] = handicap_m
        ways += list(ways_beyond(corridor(), survey, np.array([[15, 98]]), 30.0, handicaps))
    assert ways == pytest.approx([17.0 - 9.85, 22.0 - 9.85, 28.0 - 9.85], abs=0.3)
