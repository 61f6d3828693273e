import numpy as np
import pytest

from robots.sim.world import WorldError, world_of


def test_a_rim_of_wall_is_added_and_the_origin_moves_with_it():
    world = world_of(np.zeros((4, 6), dtype=bool), 0.5, (2.0, 3.0))
    assert world.cells.shape == (6, 8)
    assert world.origin_m == (1.5, 2.5)
    assert world.free_area_m2 == pytest.approx(24 * 0.25)
    assert world.centre(1, 1) == (2.25, 3.25)
    assert world.cell(2.25, 3.25) == (1, 1)
    assert world.cell(-100.0, 100.0) == (5, 0)


def test_clearance_is_the_distance_to_the_nearest_edge(hall):
    row, column = hall.cell(3.0, 0.5)
    assert hall.clearance_m[row, column] == pytest.approx(hall.centre(row, column)[1], abs=1e-6)


def test_reachable_is_the_largest_part_where_a_body_fits(draw):
    world = draw(
        """
        ##############
        #....#.......#
        #....#.......#
        #............#
        #....#.......#
        #....#.......#
        ##############
        """
    )
    assert world.reachable(0.01).sum() == world.free.sum()
    narrow = world.reachable(0.1)  # the door is one cell wide
    assert narrow[:, 7:].any()
    assert not narrow[:, :6].any()


def test_no_room_is_an_error(draw):
    with pytest.raises(WorldError, match=r"no free space for a robot of radius 0.5 m"):
        draw("#####\n#...#\n#####").reachable(0.5)
