from math import cos, hypot, inf, pi, sin

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robots.sim.rays import cast, in_sight, look_round
from robots.sim.world import GLASS, SMOKE, WALL, World


def random_world(seed: int, share: float = 0.12) -> World:
    rng = np.random.default_rng(seed)
    cells = np.where(rng.random((40, 50)) < share, WALL, 0).astype(np.uint8)
    cells[[0, -1], :] = WALL
    cells[:, [0, -1]] = WALL
    return World(cells, (-1.0, 0.5), 0.1)


def slabs(world: World, x: float, y: float, angle: float, reach: float) -> float:
    """Brute force: the beam against the square of every wall cell."""
    d = np.array([cos(angle), sin(angle)])
    p = np.array([x, y])
    nearest = inf
    for row, column in np.argwhere(world.cells & WALL):
        low = np.array(world.origin_m) + np.array([column, row]) * world.resolution_m
        with np.errstate(divide="ignore"):
            a, b = (low - p) / d, (low + world.resolution_m - p) / d
        enter, leave = np.minimum(a, b).max(), np.maximum(a, b).min()
        if enter < leave and leave > 0:
            nearest = min(nearest, max(enter, 0.0))
    return nearest if nearest < reach else inf


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_ranges_against_brute_force(seed):
    world = random_world(seed)
    rng = np.random.default_rng(seed)
    rows, columns = np.nonzero(world.free)
    pick = int(rng.integers(rows.size))
    x, y = world.centre(int(rows[pick]), int(columns[pick]))
    x, y = x + rng.uniform(-0.04, 0.04), y + rng.uniform(-0.04, 0.04)
    angles = rng.uniform(-pi, pi, 8)
    expected = [slabs(world, x, y, angle, 2.0) for angle in angles]
    assert cast(world, x, y, angles, 2.0) == pytest.approx(expected, abs=1e-9)


def test_straight_along_the_axes(hall):
    ranges = cast(hall, 2.0, 3.0, np.array([0.0, pi / 2, pi, -pi / 2]), 20.0)
    assert ranges == pytest.approx([8.0, 3.0, 2.0, 3.0], abs=1e-9)


def test_what_is_farther_than_the_reach_is_far(hall):
    assert cast(hall, 2.0, 3.0, np.array([0.0]), 7.9)[0] == inf
    assert cast(hall, 2.0, 3.0, np.array([0.0]), 8.1)[0] == pytest.approx(8.0)


def test_robots_are_discs(hall):
    others = np.array([[5.0, 3.0], [2.0, 4.0]])
    angles = np.array([0.0, pi / 2, pi, 0.3])
    ranges = cast(hall, 2.0, 3.0, angles, 6.0, discs_m=others, disc_radius_m=0.2)
    assert ranges == pytest.approx([2.8, 0.8, 2.0, inf])


def test_glass_comes_back_far_and_smoke_swallows(draw):
    world = draw(
        """
        ############
        #..........#
        #....g....##
        #....s....##
        #..sssssss##
        ############
        """
    )
    assert cast(world, 0.15, 0.35, np.array([0.0]), 5.0)[0] == inf
    assert cast(world, 0.15, 0.35, np.array([0.0]), 5.0, stops=WALL | GLASS)[0] == pytest.approx(0.35)
    assert cast(world, 0.15, 0.25, np.array([0.0]), 5.0)[0] == pytest.approx(0.85)  # a wisp
    assert cast(world, 0.15, 0.15, np.array([0.0]), 5.0)[0] == inf  # a cloud
    assert cast(world, 0.15, 0.15, np.array([0.0]), 5.0, smoke_depth_m=inf)[0] == pytest.approx(0.85)
    behind_smoke = cast(
        world, 0.15, 0.15, np.array([0.0]), 5.0, discs_m=np.array([[0.85, 0.15]]), disc_radius_m=0.05
    )
    assert behind_smoke[0] == inf
    assert not in_sight(world, (0.15, 0.35), (0.75, 0.35))
    assert in_sight(world, (0.15, 0.15), (0.75, 0.15))


def test_seen_cells_are_those_a_beam_passes(hall):
    seen = np.zeros_like(hall.cells)
    angle = 0.4
    cast(hall, 2.0, 3.0, np.array([angle]), 4.0, seen=seen)
    steps = np.arange(0.0, 4.0, 0.0005)
    expected = np.zeros_like(seen)
    for t in steps:
        expected[hall.cell(2.0 + t * cos(angle), 3.0 + t * sin(angle))] = 1
    missed = (expected == 1) & (seen == 0)
    assert not missed.any()
    assert seen.sum() - expected.sum() <= 3  # corners cut by less than the sampling


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_sight_is_mutual(seed):
    world = random_world(seed, 0.05)
    rng = np.random.default_rng(seed)
    rows, columns = np.nonzero(world.free)
    i, j = (int(k) for k in rng.integers(rows.size, size=2))
    a, b = (world.centre(int(rows[k]), int(columns[k])) for k in (i, j))
    a, b = (a[0] + 0.0123, a[1] - 0.0217), (b[0] + 0.0071, b[1] + 0.0302)
    assert in_sight(world, a, b) == in_sight(world, b, a)


def test_look_round_sees_a_disc_and_not_behind_walls(hall):
    cells = hall.cells.copy()
    column = hall.cell(6.0, 0.0)[1]
    cells[:, column] |= WALL
    cells[30:40, 60:70] |= SMOKE
    walled = World(cells, hall.origin_m, hall.resolution_m)
    row, start = walled.cell(5.0, 4.0)
    seen = look_round(walled, np.array([row]), np.array([start]), 1.5)
    rows, columns = np.nonzero(seen)
    gaps = np.hypot(rows - row, columns - start) * 0.05
    assert gaps.max() <= 1.5 + 0.05
    assert columns.max() < column
    inside = [walled.centre(r, c) for r, c in zip(rows, columns, strict=True)]
    assert len(inside) == pytest.approx(
        (pi * 1.5**2 - 0.5 * 1.5**2 * (2 * np.arccos(1 / 1.5) - np.sin(2 * np.arccos(1 / 1.5)))) / 0.05**2,
        rel=0.06,
    )
    assert all(hypot(x - 5.0, y - 4.0) < 1.6 for x, y in inside)
