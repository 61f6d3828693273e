"""The arena's inner loops against brute force."""

from math import hypot, pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.sim.arena.kernels import absorb, edge_is_left, tags_in_field, walk, way_is_clear
from robots.sim.rays import in_sight
from robots.sim.world import world_of

POINTS = st.lists(st.tuples(st.floats(-5, 5), st.floats(-5, 5)), min_size=1, max_size=8)


@given(POINTS, st.floats(0.01, 3.0))
def test_a_walk_is_as_long_as_the_step_unless_the_way_ends(points, step):
    path = np.array(points)
    x, y, _, gone = walk(path, *points[0], 0.0, step)
    assert gone <= step + 1e-9
    assert hypot(x - points[0][0], y - points[0][1]) <= gone + 1e-9
    if gone < step - 1e-6:
        assert (x, y) == pytest.approx(points[-1], abs=1e-9)


def test_a_walk_follows_the_corners_and_looks_where_it_last_went():
    path = np.array([[0.0, 0.0], [0.5, 0.0], [1.0, 0.0], [1.0, 0.5], [1.0, 1.0]])
    assert walk(path, 0.6, 0.0, 0.0, 0.7) == pytest.approx((1.0, 0.3, pi / 2, 0.7))
    assert walk(path, 1.0, 1.0, 0.4, 0.3) == pytest.approx((1.0, 1.0, 0.4, 0.0))


def test_an_edge_is_free_ground_beside_the_unknown():
    cells = np.full((40, 40), -20, np.int32)
    told = {"origin": (-2.0, -2.0), "resolution": 0.1, "reach": 0.5, "occupied": 7, "free": 4}

    def left(x, y):
        return edge_is_left(cells, x=x, y=y, **told)

    assert not left(0.0, 0.0)
    cells[:, 30:] = 0  # unknown from x = 1 on
    assert left(0.6, 0.0)
    assert not left(0.3, 0.0)
    cells[:, 29] = 20  # a wall before it
    assert not left(0.6, 0.0)


def test_a_way_is_shut_by_an_obstacle_near_it_and_ahead():
    cells = np.full((40, 40), -20, np.int32)
    path = np.column_stack([np.arange(-1.5, 1.6, 0.2), np.full(16, 0.05)])

    def clear(x=-1.5, ahead=5.0):
        return way_is_clear(cells, (-2.0, -2.0), 0.1, path, x, 0.05, ahead, 0.22, 7)

    assert clear()
    cells[24, 25] = 20  # at (0.55, 0.45): beside the way
    assert clear()
    cells[22, 25] = 20  # at (0.55, 0.25)
    assert not clear()
    assert clear(ahead=1.0)
    assert clear(x=0.9)


def test_what_one_sees_is_counted_once_for_the_team():
    rng = np.random.default_rng(0)
    team, counts = np.zeros((20, 30), np.uint8), rng.random((20, 30)) < 0.7
    total = 0
    for _ in range(4):
        own = (rng.random((20, 30)) < 0.3).astype(np.uint8)
        total += absorb(own, team, counts, 0, 0, 20, 30)
        assert total == int(((team > 0) & counts).sum())
        assert (team[own > 0] == 1).all()
    assert absorb(np.ones((20, 30), np.uint8), np.zeros((20, 30), np.uint8), counts, 2, 3, 2, 9) == 0


def test_tags_are_read_over_the_way_or_in_line_of_sight():
    solid = np.zeros((80, 80), bool)
    solid[:, 38:42] = True
    solid[30:34, 38:42] = False  # a door
    world = world_of(solid, 0.05, (-2.0, -2.0))
    tags = np.random.default_rng(1).uniform(-1.9, 1.9, (300, 2))
    at = (-0.9, 0.3), (-0.4, -0.4)
    told = world.cells, world.origin_m, world.resolution_m, *at[0], *at[1], tags
    over, seen = tags_in_field(*told, 0.3, False), tags_in_field(*told, 1.5, True)
    on_way = np.linspace(at[0], at[1], 500)
    near = np.hypot(*(tags[:, None] - on_way[None]).transpose(2, 0, 1)).min(axis=1)
    clear = np.abs(near - 0.3) > 0.01
    assert np.array_equal(over[clear], (near <= 0.3)[clear])
    free = [k for k in range(300) if world.free[world.cell(*tags[k])]]
    expected = [hypot(*(tags[k] - at[1])) <= 1.5 and in_sight(world, at[1], tuple(tags[k])) for k in free]
    assert seen[free].tolist() == expected
    assert 20 < sum(expected) < 150
