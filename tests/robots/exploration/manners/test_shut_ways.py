"""Ways that something shuts, gaps that were driven, and where to stand so that nothing is shut."""

import numpy as np
import pytest

from robots.exploration.ground import Ground
from robots.exploration.last_looks import gaps
from robots.exploration.manners.parking import parking_place
from robots.exploration.manners.shut_ways import as_far_as_it_goes, hopeful, shut_off, squeezed
from robots.planning.plan_grid import FREE, OCCUPIED, UNKNOWN, PlanGrid
from robots.planning.travel import UNREACHED
from robots.se2 import Pose2

CELL_M = 0.2


def drawn(*rows: str) -> tuple[PlanGrid, dict[str, tuple[int, int]]]:
    """A grid as drawn, north up: # wall, ? unknown, a comma too near to drive on, else free."""
    letters = np.array([list(row) for row in reversed(rows)])
    cells = np.full(letters.shape, FREE, np.uint8)
    cells[letters == "#"], cells[letters == "?"] = OCCUPIED, UNKNOWN
    steps = np.where((cells == FREE) & (letters != ","), 5, 0).astype(np.uint8)
    named = {str(letters[r, c]): (int(r), int(c)) for r, c in np.argwhere(np.char.isalpha(letters))}
    return PlanGrid(cells, steps, (0.0, 0.0), CELL_M), named


def standing(grid: PlanGrid, cell: tuple[int, int]) -> Ground:
    return Ground.of(grid, Pose2(*grid.centre_of(*cell), 0.0))


ROOM_WITH_TWO_DOORS = (
    "####################",
    "#........#.........#",
    "#........#.........#",
    "#...A....,....B....#",
    "#........#.........#",
    "#........#.........#",
    "#........,.........#",
    "####################",
)


def test_it_goes_as_far_as_it_can_by_the_way_it_came_not_through_the_nearest_wall():
    grid, at = drawn(*ROOM_WITH_TWO_DOORS)
    ground = standing(grid, at["A"])
    assert ground.costs[at["B"]] == UNREACHED
    nearest = as_far_as_it_goes(ground, hopeful(grid, np.zeros((0, 4))), at["B"])
    assert nearest == (4, 8)  # before the door straight ahead
    below = grid.centres_of(np.array([(1, c) for c in range(14, 3, -1)]))
    came = as_far_as_it_goes(ground, hopeful(grid, below), at["B"])
    assert came in ((1, 8), (2, 8))  # before the door that it came through


def test_a_place_off_the_map_leads_nowhere():
    grid, at = drawn(*ROOM_WITH_TWO_DOORS)
    assert as_far_as_it_goes(standing(grid, at["A"]), hopeful(grid, np.zeros((0, 4))), (99, 99)) is None


def test_where_it_drove_it_fits_unless_something_stands_there():
    grid, at = drawn(*ROOM_WITH_TWO_DOORS)
    ground = standing(grid, at["A"])
    trail = grid.centres_of(np.array([(1, 14), (1, 12), (1, 10), (1, 8), (1, 6)]))  # it is not on each cell
    assert squeezed(ground, trail).costs[at["B"]] != UNREACHED
    assert squeezed(ground, np.zeros((0, 4))).costs[at["B"]] == UNREACHED
    grid.cells[1, 9] = OCCUPIED
    assert squeezed(ground, trail).costs[at["B"]] == UNREACHED


def test_an_edge_that_is_shut_off_is_looked_at_from_as_far_as_the_way_goes():
    grid, at = drawn(
        "#################",
        "#.......#......??",
        "#..A....#......??",
        "#.......,......??",
        "#################",
    )
    ground = standing(grid, at["A"])
    (edge,) = shut_off(ground, np.zeros((0, 4)), 0.5)
    assert edge.goal == (1, 7)
    assert edge.length_m == pytest.approx(0.6)
    assert edge.cost_m == pytest.approx(ground.cost_m((1, 7)))
    assert shut_off(ground, np.zeros((0, 4)), 0.9) == ()


def test_a_gap_is_worth_a_look_where_much_is_hidden_and_from_where_it_is_seen():
    niche = (
        "###########",
        *["#?????????#"] * 7,
        "#####,#####",
        "#,,,,,,,,,#",
        "#....A....#",
        "###########",
    )
    grid, at = drawn(*niche)
    (gap,) = gaps(standing(grid, at["A"]), 0.5)
    assert gap.goal[1] == at["A"][1]  # straight below
    assert gap.length_m == pytest.approx(0.2)
    noise, at = drawn(*niche[:6], "###########", *niche[7:])
    noise.cells[4, 5] = UNKNOWN  # a hole of one cell
    assert gaps(standing(noise, at["A"]), 0.5) == ()
    assert gaps(standing(grid, at["A"]), 0.2) == ()  # as long as an edge: looked at as one


@pytest.mark.parametrize("start", ["A", "B", "C"])
def test_who_has_nothing_to_do_stands_where_others_get_past(start):
    wall, end = "#" * 24, "#" * 20
    corridor = (
        wall + "#" * 8 + end,
        *[wall + "." * 8 + end] * 5,
        "#" + "." * 50 + "#",
        "#" + "." * 17 + "A.B............C" + "." * 17 + "#",
        "#" + "." * 50 + "#",
        "#" * 52,
    )
    grid, at = drawn(*corridor)
    ground = standing(grid, at[start])
    place = parking_place(ground, grid.centre_of(*at["B"]), (1.0, 4.0), 0.6)
    assert place is not None
    assert place[0] >= 4  # in the niche
    ring = parking_place(ground, grid.centre_of(*at["B"]), (0.6,), 0.6)
    assert ring is None  # so near it would shut the corridor
    wide = parking_place(ground, grid.centre_of(*at["B"]), (0.6,), 0.15)
    assert wide is not None


def test_a_dead_end_may_be_stood_in():
    grid, at = drawn("#" * 42, "#" + "." * 20 + "A" + "." * 19 + "#", "#" * 42)
    place = parking_place(standing(grid, at["A"]), grid.centre_of(*at["A"]), (2.0, 5.0), 0.55)
    assert place is not None
    assert min(place[1] - 1, 40 - place[1]) < 16  # what is left behind it is a corner
