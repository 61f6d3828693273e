import numpy as np
import pytest

from robots.sim.generate import generate
from robots.sim.hostile import HostileConfig, make_hostile
from robots.sim.world import BRICK, GLASS, SMOKE, WALL


def office():
    return generate("office", 200.0, np.random.default_rng(4))


def make(**counts: int):
    return make_hostile(office(), HostileConfig(**counts), np.random.default_rng(9))


def test_nothing_asked_for_changes_nothing():
    plain, same = office(), make()
    assert np.array_equal(plain.cells, same.cells)
    assert same.grip is None
    assert same.slope is None


@pytest.mark.parametrize(("name", "flag"), [("glass", GLASS), ("bricks", BRICK), ("smoke", SMOKE)])
def test_more_of_a_kind_is_more_of_it(name, flag):
    few, many = ((make(**{name: count}).cells & flag > 0).sum() for count in (1, 8))
    assert 0 < few < many


def test_glass_replaces_wall_and_the_rest_stands_on_free_floor():
    plain, world = office(), make(glass=5, bricks=8, smoke=3)
    assert (plain.cells[(world.cells & GLASS) > 0] == WALL).all()
    assert (plain.cells[(world.cells & (BRICK | SMOKE)) > 0] == 0).all()
    assert world.reachable(0.22).sum() > 0.9 * plain.reachable(0.22).sum()


def test_slippery_and_ramps_are_within_what_is_stated():
    world = make(slippery=6, ramps=4)
    assert world.grip is not None
    assert world.slope is not None
    patches = world.grip[world.grip < 1.0]
    assert patches.size > 0
    assert 0.2 <= patches.min() <= patches.max() <= 0.6
    steep = np.degrees(np.arctan(np.hypot(world.slope[..., 0], world.slope[..., 1])))
    assert steep[steep > 0].min() + 1e-4 >= 6.0
    assert steep.max() <= 15.0 + 1e-4


def test_one_kind_leaves_the_others_alone():
    alone, among = make(smoke=2), make(smoke=2, glass=3, slippery=2)
    assert np.array_equal(alone.cells & SMOKE, among.cells & SMOKE)
