"""Looking round where the trail or the map is new gives what looking round anew from everywhere gives."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from robots.exploration.strategies.sight import Sight
from robots.planning.plan_grid import FREE, OCCUPIED, PlanGrid

CELL_M, REACH_M = 0.2, 2.0
places = st.tuples(st.floats(-1.0, 13.0), st.floats(-1.0, 9.0), st.floats(-3.2, 3.2))
walls = st.tuples(st.integers(0, 39), st.integers(0, 59), st.booleans())


def grid_of(cells, origin=(0.0, 0.0)):
    return PlanGrid(cells, (cells == FREE).astype(np.uint8) * 5, origin, CELL_M)


@given(
    st.lists(
        st.tuples(st.lists(places, max_size=6), st.lists(walls, max_size=4), st.booleans()),
        min_size=2,
        max_size=6,
    )
)
def test_a_trail_and_a_map_that_change_are_kept_up(steps):
    sight, cells = Sight(), np.full((40, 60), FREE, np.uint8)
    cells[::9, ::7] = OCCUPIED
    for trail, changes, grown in steps:
        cells = cells.copy()
        for row, column, wall in changes:
            cells[row, column] = OCCUPIED if wall else FREE
        if grown:
            cells = np.pad(cells, ((1, 0), (0, 2)), constant_values=FREE)
        grid, way = grid_of(cells), np.array(trail).reshape(-1, 3)
        kept, anew = sight.look(grid, way, REACH_M), Sight().look(grid, way, REACH_M)
        np.testing.assert_array_equal(kept[0], anew[0])
        np.testing.assert_array_equal(kept[1], anew[1])


@given(places, st.lists(st.tuples(st.integers(-12, 12), st.integers(-12, 12)), min_size=1, max_size=8))
def test_one_cell_that_changes_about_a_place_is_seen(place, flips):
    sight, cells, way = Sight(), np.full((40, 60), FREE, np.uint8), np.array([place])
    sight.look(grid_of(cells), way, REACH_M)
    for up, right in flips:
        row, column = np.clip((int(place[1] / CELL_M) + up, int(place[0] / CELL_M) + right), 0, (39, 59))
        cells = cells.copy()
        cells[row, column] = OCCUPIED if cells[row, column] == FREE else FREE
        kept = sight.look(grid_of(cells), way, REACH_M)
        np.testing.assert_array_equal(kept, Sight().look(grid_of(cells), way, REACH_M))


@given(st.lists(places, max_size=8))
def test_what_is_in_sight_of_a_trail_is_what_is_in_sight_of_one_place_or_another(trail):
    cells = np.full((40, 60), FREE, np.uint8)
    cells[:, 30] = OCCUPIED
    grid, way = grid_of(cells), np.array(trail).reshape(-1, 3)
    safe, cleared = Sight().look(grid, way, REACH_M)
    alone = [Sight().look(grid, way[k : k + 1], REACH_M) for k in range(len(way))]
    np.testing.assert_array_equal(safe, np.any([one[0] for one in alone] or [safe & False], axis=0))
    np.testing.assert_array_equal(cleared, np.any([one[1] for one in alone] or [safe & False], axis=0))
    assert not (cleared & ~safe).any()
    assert not (safe & (cells != FREE)).any()
