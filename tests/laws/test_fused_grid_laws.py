"""The fused grid is the sum of its submaps where they lie now, whatever was put, moved and dropped before."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from robots.mapping.fused import FusedGrid
from robots.se2 import Pose2

RESOLUTION = 0.1
metres = st.floats(-12.0, 12.0)
poses = st.builds(Pose2, metres, metres, st.floats(-3.14, 3.14))
submaps = arrays.arrays(
    np.int8, st.tuples(st.integers(1, 7), st.integers(1, 7)), elements=st.integers(-40, 40)
)
drawings = st.lists(st.tuples(poses, submaps), min_size=1, max_size=4)
keys = st.integers(0, 3)
changes = st.lists(
    st.one_of(st.tuples(st.just("put"), keys, poses, submaps), st.tuples(st.just("drop"), keys)), max_size=10
)


def known(grid: FusedGrid) -> dict[tuple[int, int], int]:
    """Values that are not 0 by their cell, counted from the frame's origin."""
    row0, column0 = (round(v / RESOLUTION) for v in (grid.origin[1], grid.origin[0]))
    rows, columns = np.nonzero(grid.cells)
    return {
        (row0 + int(r), column0 + int(c)): int(grid.cells[r, c]) for r, c in zip(rows, columns, strict=True)
    }


def assert_is_the_sum(grid: FusedGrid, drawn: list[tuple[Pose2, np.ndarray]]) -> None:
    """Compare every cell with the submaps' cells under its centre, but those that a border runs through."""
    h, w = grid.cells.shape
    rows, columns = np.indices((h, w))
    centres = np.column_stack([columns.ravel() + 0.5, rows.ravel() + 0.5]) * RESOLUTION + grid.origin
    expected, sure = np.zeros(len(centres), int), np.ones(len(centres), bool)
    low, high = np.array(grid.origin), np.array(grid.origin) + np.array([w, h]) * RESOLUTION
    for pose, cells in drawn:
        far = np.array(cells.shape[::-1]) * RESOLUTION
        corners = pose.transform(np.array([[0.0, 0.0], far, [far[0], 0.0], [0.0, far[1]]]))
        assert (corners > low - 1e-6).all()
        assert (corners < high + 1e-6).all()
        uv = pose.inverse().transform(centres) / RESOLUTION
        sure &= (np.abs(uv - np.round(uv)) > 1e-6).all(axis=1)
        u, v = np.floor(uv).astype(int).T
        within = (u >= 0) & (v >= 0) & (u < cells.shape[1]) & (v < cells.shape[0])
        expected[within] += cells[v[within], u[within]]
    np.testing.assert_array_equal(grid.cells.ravel()[sure], expected[sure])


@given(changes)
@settings(max_examples=60)
def test_the_grid_is_the_sum_of_what_is_in_it(done):
    grid, inside = FusedGrid(RESOLUTION), {}
    for version, (what, key, *drawing) in enumerate(done):
        if what == "put":
            assert grid.put(key, version, *drawing)
            inside[key] = drawing
        else:
            grid.drop(key)
            inside.pop(key, None)
    assert_is_the_sum(grid, [(pose, cells) for pose, cells in inside.values()])


@given(drawings)
def test_what_is_put_and_dropped_leaves_nothing(put):
    grid = FusedGrid(RESOLUTION)
    for key, (pose, cells) in enumerate(put):
        grid.put(key, 0, pose, cells)
    for key in reversed(range(len(put))):
        grid.drop(key)
    assert not grid.cells.any()


@given(drawings, st.randoms(use_true_random=False))
def test_the_order_does_not_matter(put, random):
    first, second = FusedGrid(RESOLUTION), FusedGrid(RESOLUTION)
    numbered = list(enumerate(put))
    for key, (pose, cells) in numbered:
        first.put(key, 0, pose, cells)
    random.shuffle(numbered)
    for key, (pose, cells) in numbered:
        second.put(key, 0, pose, cells)
    assert known(first) == known(second)


@given(st.lists(st.tuples(poses, submaps, st.integers(0, 2**32 - 1)), min_size=1, max_size=4))
def test_unsure_is_what_is_free_and_no_submap_proves(put):
    """Each submap's proof, drawn alone as a map of its own, lies where its log-odds lie."""
    grid, expected = FusedGrid(RESOLUTION), set()
    for key, (pose, cells, seed) in enumerate(put):
        touched = np.random.default_rng(seed).integers(0, 9, cells.shape).astype(np.int32)
        grid.put(key, 0, pose, cells, touched=touched)
        proof = FusedGrid(RESOLUTION)
        proof.put("proof", 0, pose, (touched & 1).astype(np.int16))
        expected |= set(known(proof))
    free = {cell for cell, value in known(grid).items() if value <= -4} - expected
    unsure, (x, y) = grid.unsure(4), grid.origin
    row0, column0 = round(y / RESOLUTION), round(x / RESOLUTION)
    assert {(row0 + int(r), column0 + int(c)) for r, c in np.argwhere(unsure)} == free
    for key in range(len(put)):
        grid.drop(key)
    assert grid.unsure(4) is None


@given(drawings, poses)
def test_moving_is_dropping_and_putting(put, there):
    moved, anew = FusedGrid(RESOLUTION), FusedGrid(RESOLUTION)
    for key, (pose, cells) in enumerate(put):
        moved.put(key, 0, pose, cells)
        anew.put(key, 0, pose, cells)
    cells = put[0][1]
    moved.put(0, 0, there, cells, tolerance_m=0.0)
    anew.drop(0)
    anew.put("again", 0, there, cells)
    assert known(moved) == known(anew)


@given(poses, submaps)
def test_putting_the_same_twice_changes_nothing(pose, cells):
    grid = FusedGrid(RESOLUTION)
    assert grid.put("a", 3, pose, cells)
    before = known(grid)
    assert not grid.put("a", 3, pose, cells)
    assert known(grid) == before
