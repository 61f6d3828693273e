"""What happens to nodes during a mission, and what they measure."""

import numpy as np
import pytest

from robots.sim.hostile import HostileConfig
from robots.sim.node_life import NodeLife
from robots.sim.tags import TagField
from robots.sim.world import world_of

HALL = world_of(np.zeros((200, 300), bool), 0.1)
PLACES = np.array([[float(x), float(y)] for x in range(3, 28, 5) for y in range(3, 18, 5)])
LENGTH_S = 1000.0


def life_of(seed=1, **hostile):
    field = TagField(2048)
    rng = np.random.default_rng(seed)
    return field, NodeLife(HALL, field, PLACES, HostileConfig(**hostile), 0.2, LENGTH_S, rng)


def test_a_dead_node_stays_dead_and_one_switched_off_comes_back():
    field, life = life_of(dead_tags=3, switched_tags=len(PLACES))
    dead = ~field.on
    assert dead.sum() == 3
    off = np.zeros(len(PLACES), bool)
    for clock_s in np.arange(0.0, LENGTH_S, 5.0):
        life.advance(clock_s)
        assert not field.on[dead].any()
        off |= ~field.on
    assert off.all()
    assert (field.on == ~dead).all()


def test_nodes_are_carried_off_once_to_where_robots_can_go():
    field, life = life_of(moved_tags=4)
    life.advance(0.1 * LENGTH_S)
    assert (field.places_m == PLACES).all()
    life.advance(LENGTH_S)
    moved = np.hypot(*(field.places_m - PLACES).T) > 0.0
    assert moved.sum() == 4
    assert all(HALL.free[HALL.cell(x, y)] for x, y in field.places_m)


def test_twins_bear_the_id_of_another():
    field, _ = life_of(twin_tags=2)
    ids = [tag.tag_id for tag in field.tags]
    assert len(ids) == len(PLACES) + 2
    assert len(set(ids)) == len(PLACES)
    twin = ids[-1]
    first, second = (field.tag(k) for k, tag_id in enumerate(ids) if tag_id == twin)
    assert (first.x_m, first.y_m) != (second.x_m, second.y_m)
    assert field.write(twin, b"second", second.x_m, second.y_m)
    assert (first.memory, second.memory) == (b"", b"second")


def test_sensors_tell_a_fire_and_a_fall():
    field, life = life_of(fires=1, knocked_tags=1)
    rng = np.random.default_rng(1)
    before = [life.sensors(tag, 0.0, rng) for tag in field.tags]
    assert {round(s.temperature_c / 10.0) for s in before} == {2}
    assert max(s.tilt_rad for s in before) < 0.1
    life.advance(LENGTH_S)
    fire = life.fires[0]
    field.move(0, fire.x_m, fire.y_m)
    field.move(1, fire.x_m, fire.y_m + 100.0)
    after = [life.sensors(tag, LENGTH_S, rng) for tag in field.tags]
    assert after[0].temperature_c > 300.0
    assert after[1].temperature_c < 25.0
    assert after[0].pressure_hpa > after[1].pressure_hpa + 4.0
    assert sum(s.tilt_rad > 1.0 for s in after) == 1


def test_the_same_seed_has_the_same_in_store():
    kinds = {"moved_tags": 2, "knocked_tags": 2, "fires": 2, "twin_tags": 1, "dead_tags": 1}
    states = []
    for seed in (1, 1, 2):
        field, life = life_of(seed, **kinds)
        life.advance(LENGTH_S)
        states.append(([repr(tag) for tag in field.tags], life.fires))
    assert states[0] == states[1]
    assert states[0] != states[2]


def test_one_kind_of_mischief_leaves_the_others_alone():
    alone, both = life_of(fires=2)[1], life_of(fires=2, moved_tags=5)[1]
    assert alone.fires == both.fires


def test_a_fire_grows_and_is_felt_near_it():
    fire = life_of(fires=1)[1].fires[0]
    assert fire.strength(fire.x_m, fire.y_m, fire.start_s) == 0.0
    growing = [fire.strength(fire.x_m, fire.y_m, fire.start_s + t) for t in (10.0, 60.0, 600.0)]
    assert growing == sorted(growing)
    assert growing[-1] == pytest.approx(1.0, abs=0.01)
    assert fire.strength(fire.x_m + fire.radius_m, fire.y_m, 1e6) == pytest.approx(np.exp(-1.0))
