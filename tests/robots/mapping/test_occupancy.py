"""Casting a scan into a grid, against a check of every cell with every beam."""

from math import cos, inf, nan, sin

import numpy as np
import pytest

from robots.mapping.occupancy import cast_scan, proved, stamp_disc

HIT, MISS, BOUND = 9, 4, 40
RESOLUTION, RANGE_MAX, LIMIT = 0.1, 4.0, 3.0


def cast(grid, ranges, pose=(0.0, 0.0, 0.0), angles=(-2.0, 0.05), origin=(-3.5, -3.5), mark=1, touched=None):
    touched = np.zeros(grid.shape, np.int32) if touched is None else touched
    cast_scan(
        grid, touched, mark, *origin, RESOLUTION, *pose, np.asarray(ranges, np.float32), *angles,
        RANGE_MAX, LIMIT, HIT, MISS, BOUND,
    )  # fmt: skip


def crossed(cells_from: np.ndarray, start: tuple[float, float], angle: float, reach: float) -> float:
    """Length (m) of the beam inside each of the cells, by clipping it against the cells' sides."""
    low, high = np.zeros(len(cells_from)), np.full(len(cells_from), reach)
    for axis, along in enumerate((cos(angle), sin(angle))):
        a = (cells_from[:, axis] - start[axis]) / along
        b = (cells_from[:, axis] + RESOLUTION - start[axis]) / along
        low, high = np.maximum(low, np.minimum(a, b)), np.minimum(high, np.maximum(a, b))
    return np.maximum(high - low, 0.0)


def brute_force(shape, ranges, pose, angles, origin) -> tuple[np.ndarray, np.ndarray]:
    """What a scan adds to each cell, and for which cells that is beyond doubt."""
    rows, columns = np.indices(shape)
    corners = np.column_stack(
        [origin[0] + columns.ravel() * RESOLUTION, origin[1] + rows.ravel() * RESOLUTION]
    )
    hits, near, full, half, grazed = (np.zeros(len(corners), bool) for _ in range(5))
    order = np.full(len(corners), len(ranges))
    for i, r in enumerate(np.float32(ranges).astype(float)):
        if r <= 0.02:
            continue
        far = not np.isfinite(r) or r >= RANGE_MAX - 1e-3
        angle = pose[2] + angles[0] + i * angles[1]
        reach = min(LIMIT, RANGE_MAX) if far else min(r, LIMIT)
        length = crossed(corners, pose[:2], angle, reach)
        first = (length > 1e-6) & (order == len(ranges))
        order[first] = i
        (half if far else full)[first] = True
        grazed |= (length > 0.0) & (length <= 1e-6)
        if not far and r < LIMIT:
            end = np.array([pose[0] + r * cos(angle), pose[1] + r * sin(angle)]) - corners
            hits |= ((end >= 0.0) & (end < RESOLUTION)).all(axis=1)
            near |= ((end >= -1e-6) & (end < RESOLUTION + 1e-6)).all(axis=1)
    change = np.where(hits, HIT, np.where(full, -MISS, np.where(half, -(MISS // 2), 0)))
    return change.reshape(shape), (~grazed & (hits == near)).reshape(shape)


@pytest.mark.parametrize("seed", range(12))
def test_every_cell_changes_as_brute_force_says(seed):
    rng = np.random.default_rng(seed)
    ranges = rng.uniform(0.05, 5.0, 60).astype(np.float32)
    ranges[rng.integers(0, 60, 6)] = [nan, inf, 0.0, 0.02, -1.0, RANGE_MAX]
    pose = tuple(rng.uniform([-1.0, -1.0, -3.1], [1.0, 1.0, 3.1]))
    angles, origin = (-2.0, 0.067), tuple(rng.uniform(-3.0, -1.5, 2))  # beams leave the grid on some sides
    grid = np.zeros((50, 47), np.int16)
    cast(grid, ranges, pose, angles, origin)
    expected, sure = brute_force(grid.shape, ranges, pose, angles, origin)
    assert sure.mean() > 0.9
    assert {HIT, -MISS, -(MISS // 2), 0} <= set(expected[sure].tolist())
    np.testing.assert_array_equal(grid[sure], expected[sure])


@pytest.mark.parametrize("seed", range(6))
def test_proved_is_what_a_beam_of_any_scan_crossed_that_came_back(seed):
    rng = np.random.default_rng(seed)
    angles, origin = (-2.0, 0.067), (-2.0, -2.0)
    grid, touched = np.zeros((45, 45), np.int16), np.zeros((45, 45), np.int32)
    expected, sure = np.zeros(grid.shape, bool), np.ones(grid.shape, bool)
    for mark in (1, 2, 3):
        ranges = rng.uniform(0.1, 3.0, 60).astype(np.float32)
        ranges[rng.random(60) < 0.6] = inf  # first of those that cross some cells
        pose = tuple(rng.uniform([-0.5, -0.5, -3.1], [0.5, 0.5, 3.1]))
        cast(grid, ranges, pose, angles, origin, mark, touched)
        back = np.where(np.isfinite(ranges), ranges, 0.0)
        change, beyond_doubt = brute_force(grid.shape, back, pose, angles, origin)
        expected, sure = expected | (change != 0), sure & beyond_doubt
    assert 200 < expected[sure].sum() < (grid[sure] != 0).sum() - 200
    np.testing.assert_array_equal(proved(touched)[sure], expected[sure])


def test_a_beam_by_hand():
    grid = np.zeros((3, 10), np.int16)
    cast(grid, [0.7], pose=(0.05, 0.15, 0.0), angles=(0.0, 0.1), origin=(0.0, 0.0))
    np.testing.assert_array_equal(grid[1], [-4] * 7 + [9, 0, 0])
    assert not grid[[0, 2]].any()


def test_a_far_reading_clears_half_as_much_and_only_to_the_limit():
    grid = np.zeros((1, 60), np.int16)
    cast(grid, [inf], pose=(0.05, 0.05, 0.0), angles=(0.0, 0.1), origin=(0.0, 0.0))
    np.testing.assert_array_equal(grid[0], [-2] * 31 + [0] * 29)


def test_a_reading_beyond_the_limit_clears_but_does_not_mark():
    grid = np.zeros((1, 60), np.int16)
    cast(grid, [3.5], pose=(0.05, 0.05, 0.0), angles=(0.0, 0.1), origin=(0.0, 0.0))
    np.testing.assert_array_equal(grid[0], [-4] * 31 + [0] * 29)


def test_a_hit_outweighs_beams_that_graze_its_cell_in_either_order():
    beside = np.arctan2(0.1, 1.0)
    for ranges in ([1.0, 2.0], [2.0, 1.0]):
        grid = np.zeros((60, 60), np.int16)
        cast(grid, ranges, pose=(0.05, 0.05, 0.0), angles=(0.0, beside / 10.0), origin=(0.0, 0.0))
        assert grid[0, 10] == HIT


def test_a_cell_changes_once_a_scan_and_again_in_the_next():
    grid, touched = np.zeros((10, 40), np.int16), np.zeros((10, 40), np.int32)
    for mark in (1, 2, 3):
        cast(grid, [2.0] * 50, (0.05, 0.55, 0.0), (-0.01, 0.0004), (0.0, 0.0), mark=mark, touched=touched)
        assert grid[5, 20] == mark * HIT
        assert grid[5, 10] == -mark * MISS


def test_what_was_felt_is_cleared_by_beams_that_came_back_alone():
    """Glass and bricks below the laser's plane let beams through: one from nowhere says nothing of them."""
    grid, touched = np.zeros((1, 30), np.int16), np.zeros((1, 30), np.int32)

    def look(ranges, marks):
        for mark in marks:
            cast(grid, ranges, (0.05, 0.05, 0.0), (0.0, 1e-4), (0.0, 0.0), mark=mark, touched=touched)

    stamp_disc(grid, touched, 0, 10, 1, BOUND)
    look([inf], range(1, 30))
    assert grid[0, 9:12].tolist() == [BOUND] * 3
    assert (grid[0, 8], grid[0, 12]) == (-2 * MISS, 0)  # and of nothing beyond
    look([inf, 2.0], range(30, 33))  # one of each in a scan
    assert grid[0, 9:12].tolist() == [BOUND - 3 * MISS] * 3
    look([2.0], range(33, 60))
    assert grid[0, 9:12].tolist() == [-BOUND] * 3
    assert proved(touched)[0, :21].all()


def test_a_beam_from_nowhere_ends_at_a_wall_and_wears_it_down_slowly():
    """A pane before it sends the beam away and the wall stays; somebody who walks off is gone at last."""
    grid, touched = np.zeros((1, 35), np.int16), np.zeros((1, 35), np.int32)
    marks = iter(range(1, 200))

    def look(distance_m, times):
        for mark in (next(marks) for _ in range(times)):
            cast(grid, [distance_m], (0.05, 0.05, 0.0), (0.0, 0.1), (0.0, 0.0), mark=mark, touched=touched)

    look(2.0, 10)
    assert grid[0, 20] == BOUND
    look(inf, 20)
    assert grid[0, 20] == BOUND - 20
    assert not grid[0, 21:].any()
    look(inf, 40)
    assert grid[0, 20:31].tolist() == [-2 * MISS] * 11


def test_log_odds_stay_within_the_bound():
    grid, touched = np.zeros((1, 30), np.int16), np.zeros((1, 30), np.int32)
    for mark in range(1, 30):
        cast(grid, [2.0], (0.05, 0.05, 0.0), (0.0, 0.1), (0.0, 0.0), mark=mark, touched=touched)
    assert grid[0, 20] == BOUND
    assert grid[0, 5] == -BOUND


def test_a_disc_is_stamped_over_what_is_less_sure():
    rng = np.random.default_rng(2)
    before = rng.integers(-40, 41, (12, 15)).astype(np.int16)
    grid = before.copy()
    stamp_disc(grid, np.zeros(grid.shape, np.int32), 2, 13, 3, 25)  # reaches over two sides
    rows, columns = np.indices(grid.shape)
    disc = (rows - 2) ** 2 + (columns - 13) ** 2 <= 9
    np.testing.assert_array_equal(grid, np.where(disc, np.maximum(before, 25), before))
