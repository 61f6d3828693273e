"""The plan grid against SciPy's nearest neighbours and a brute force."""

from math import pi

import numpy as np
import pytest
from scipy.spatial import cKDTree

from robots.config import BodyConfig, MappingConfig, PlanningConfig
from robots.mapping.fused import FusedGrid
from robots.planning.plan_grid import FREE, OCCUPIED, UNKNOWN, PlanGrid, PlanGrids, plan_grid
from robots.se2 import Pose2

BODY, PLANNING, MAPPING = BodyConfig(), PlanningConfig(), MappingConfig()
NOWHERE = np.zeros((0, 3))
COMFORT_M = BODY.radius_m + PLANNING.comfort_m


def clearance_m(grid: PlanGrid, fused: FusedGrid) -> np.ndarray:
    """Distance from the middle of each cell to the nearest occupied cell of the map the grid was made of.

    It begins half a cell before its middle.
    """
    middles = (np.argwhere(fused.cells >= MAPPING.occupied_logodds) + 0.5) * fused.resolution_m
    queries = (np.argwhere(np.ones(grid.cells.shape)) + 0.5) * grid.cell_m
    distances, _ = cKDTree(middles).query(queries)
    return distances.reshape(grid.cells.shape) - fused.resolution_m / 2.0


def fused_of(cells: np.ndarray) -> FusedGrid:
    fused = FusedGrid(MAPPING.resolution_m)
    fused.put("map", 0, Pose2(1.0, -2.0), cells.astype(np.int16))
    return fused


def random_map(rng: np.random.Generator, obstacles: int) -> np.ndarray:
    """Free ground with blocks and walls of obstacles and holes of unknown, log-odds in tenths."""
    cells = np.full((160, 190), -20)
    for _ in range(obstacles):
        r, c, h, w = rng.integers(0, 150, 4) // (1, 1, 10, 10)
        cells[r : r + h + 1, c : c + w + 1] = rng.choice([0, MAPPING.occupied_logodds, 40])
    return cells


@pytest.fixture(params=range(4))
def grid_and_fused(request) -> tuple[PlanGrid, FusedGrid]:
    fused = fused_of(random_map(np.random.default_rng(request.param), 5 + 10 * request.param))
    return plan_grid(fused, BODY, PLANNING, MAPPING, NOWHERE), fused


def test_a_coarse_cell_is_occupied_by_any_and_free_by_any_other(grid_and_fused):
    grid, fused = grid_and_fused
    assert grid.cell_m == pytest.approx(0.1)
    rows, columns = grid.cells.shape
    for row in range(rows):
        for column in range(columns):
            block = fused.cells[2 * row : 2 * row + 2, 2 * column : 2 * column + 2]
            if (block >= MAPPING.occupied_logodds).any():
                expected = OCCUPIED
            else:
                expected = FREE if (block <= -MAPPING.miss_logodds).any() else UNKNOWN
            assert grid.cells[row, column] == expected


@pytest.mark.parametrize("radius_m", [BODY.radius_m, 0.40])
def test_the_body_fits_exactly_where_its_clearance_is_kept(grid_and_fused, radius_m):
    grid = plan_grid(grid_and_fused[1], BodyConfig(radius_m=radius_m), PLANNING, MAPPING, NOWHERE)
    fits = (grid.cells == FREE) & (
        clearance_m(grid, grid_and_fused[1]) > radius_m + PLANNING.clearance_m - 1e-9
    )
    assert fits.any()
    assert (~fits & (grid.cells == FREE)).any()
    np.testing.assert_array_equal(grid.steps > 0, fits)


def test_steps_cost_most_next_to_obstacles_and_5_where_comfortable(grid_and_fused):
    grid, _ = grid_and_fused
    clearance = clearance_m(grid, grid_and_fused[1])
    open_ground = (grid.cells == FREE) & (clearance > COMFORT_M - 1e-9)
    assert open_ground.any()
    assert (grid.steps[open_ground] == 5).all()
    tight = (grid.steps > 0) & ~open_ground
    assert tight.any()
    order = np.argsort(clearance[tight], kind="stable")
    assert (np.diff(grid.steps[tight][order].astype(int)) <= 0).all()
    assert grid.steps[tight].max() >= 12
    assert grid.steps.max() <= 15


def test_unknown_ground_and_obstacles_are_never_entered(grid_and_fused):
    grid, _ = grid_and_fused
    assert not grid.steps[grid.cells != FREE].any()


def test_cells_and_points_agree():
    fused = fused_of(np.full((40, 50), -20))
    grid = plan_grid(fused, BODY, PLANNING, MAPPING, NOWHERE)
    for cell in ((0, 0), (7, 31), (99, 3)):
        assert grid.cell_of(*grid.centre_of(*cell)) == cell
    row, column = grid.cell_of(1.0 + 0.05, -2.0 + 0.05)  # inside the map's first coarse cell
    assert grid.cells[row, column] == FREE
    assert grid.cells[row - 1, column] == UNKNOWN
    rows, columns = grid.cells.shape
    assert grid.holds(0, 0)
    assert grid.holds(rows - 1, columns - 1)
    for outside in ((-1, 0), (0, -1), (rows, 0), (0, columns)):
        assert not grid.holds(*outside)


def test_places_put_aside_are_closed_and_nothing_else():
    fused = fused_of(np.full((80, 80), -20))
    plain = plan_grid(fused, BODY, PLANNING, MAPPING, NOWHERE)
    blocked = plan_grid(fused, BODY, PLANNING, MAPPING, np.array([[3.05, 0.05, 0.35], [-900.0, 5.0, 0.35]]))
    rows, columns = np.indices(plain.cells.shape)
    x, y = plain.origin[0] + (columns + 0.5) * 0.1, plain.origin[1] + (rows + 0.5) * 0.1
    inside = np.maximum(np.abs(x - 3.05), np.abs(y - 0.05)) < 0.35
    assert inside.sum() == 49
    np.testing.assert_array_equal(blocked.steps, np.where(inside, 0, plain.steps))
    assert (blocked.cells == plain.cells).all()


def test_a_wider_body_fits_in_fewer_places():
    fused = fused_of(random_map(np.random.default_rng(9), 30))
    narrow, wide = (
        plan_grid(fused, BodyConfig(radius_m=radius), PLANNING, MAPPING, NOWHERE).steps > 0
        for radius in (0.2, 0.45)
    )
    assert (narrow & ~wide).any()
    assert not (wide & ~narrow).any()


def test_a_doorway_is_passable_when_it_is_wide_enough():
    """A wall with a gap, drawn askew: its clearance is what decides."""
    passable = {}
    for gap_cells in (8, 20):
        cells = np.full((81, 81), -20)
        cells[40, :] = 40
        cells[40, 40 - gap_cells // 2 : 40 + gap_cells // 2] = -20
        fused = FusedGrid(MAPPING.resolution_m)
        fused.put("map", 0, Pose2(0.0, 0.0, pi / 7), cells.astype(np.int16))
        grid = plan_grid(fused, BODY, PLANNING, MAPPING, NOWHERE)
        middle = Pose2(0.0, 0.0, pi / 7).transform_point(2.025, 2.025)
        passable[gap_cells] = bool(grid.steps[grid.cell_of(*middle)] > 0)
    assert passable == {8: False, 20: True}


@pytest.mark.parametrize(("seed", "cell_m"), [(0, 0.1), (1, 0.1), (2, 0.15), (3, 0.2)])
def test_following_a_map_comes_to_the_same_as_making_the_grid_anew(seed, cell_m):
    rng = np.random.default_rng(seed)
    planning = PlanningConfig(cell_m=cell_m)
    grids = PlanGrids(BODY, planning, MAPPING)
    fused = fused_of(random_map(rng, 20))
    for turn in range(12):
        for patch in range(int(rng.integers(0, 3))):
            cells = rng.choice([-20, 0, 10], (int(rng.integers(1, 40)), int(rng.integers(1, 40))))
            x, y = rng.uniform(-0.5, 9.0, 2)
            key = f"patch {int(rng.integers(0, 5))}"
            fused.put(key, 10 * turn + patch, Pose2(x + 1.0, y - 2.0), cells.astype(np.int16))
        if turn == 8:
            fused.drop("patch 1")
        followed, anew = grids.of(fused, NOWHERE), plan_grid(fused, BODY, planning, MAPPING, NOWHERE)
        assert followed.origin == anew.origin
        assert np.array_equal(followed.cells, anew.cells)
        assert np.array_equal(followed.steps, anew.steps)
