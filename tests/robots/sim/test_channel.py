"""Laws of the air: what is heard where, and what stands in the way."""

from dataclasses import replace
from itertools import pairwise
from math import inf, pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.config import RadioConfig
from robots.estimation.radio.model import NODE, UHF, RadioModel, radio_for
from robots.estimation.radio.walls import WALL_DB
from robots.sim.channel import Channel
from robots.sim.tags import TagField
from robots.sim.world import GLASS, SMOKE, WALL, World

BARE = RadioConfig(shadowing_sd_db=0.0, fading_sd_db=0.0)
BARE_UHF = replace(UHF, shadowing_sd_db=0.0, fading_sd_db=0.0)


def hall(*walls_m, code=WALL):
    """A hall of 40 x 10 m with walls, 10 cm thick, across it."""
    cells = np.zeros((100, 400), np.uint8)
    for x in walls_m:
        cells[:, int(x * 10)] = code
    return World(cells, (0.0, 0.0), 0.1)


def field_of(*tags_m):
    field = TagField(2048)
    for number, (x, y) in enumerate(tags_m):
        field.drop(f"N{number}", x, y)
    return field


def heard(world, hardware, config, field, *antennas, seed=1):
    return Channel(world, field, hardware, config, seed).signals_dbm(np.array(antennas, float))


@given(st.lists(st.floats(0.1, 34.0), min_size=2, max_size=8, unique=True))
def test_without_walls_and_noise_the_signal_is_the_models_and_falls_with_distance(distances):
    distances = sorted(distances)
    field = field_of(*((2.0 + d, 5.0) for d in distances))
    found = heard(hall(), "node", BARE, field, (2.0, 5.0, 0.0))[0]
    model = RadioModel(BARE)
    assert found == pytest.approx([model.signal_dbm(d) for d in distances])
    assert all(a >= b for a, b in pairwise(found))
    assert [model.distance_m(signal) for signal in found] == pytest.approx(distances)


def test_every_wall_takes_its_part_from_a_node_and_glass_and_smoke_take_none():
    field = field_of((20.0, 5.0))
    free, one, two = (
        heard(hall(*walls), "node", BARE, field, (10.0, 5.0, 0.0))[0, 0]
        for walls in ((), (15.0,), (12.0, 17.0))
    )
    assert (free - one, free - two) == pytest.approx((WALL_DB, 2.0 * WALL_DB))
    for code in (GLASS, SMOKE):
        assert heard(hall(15.0, code=code), "node", BARE, field, (10.0, 5.0, 0.0))[0, 0] == free


def test_a_thick_wall_is_one():
    cells = np.zeros((100, 400), np.uint8)
    cells[:, 130:160] = WALL
    field = field_of((20.0, 5.0))
    thick = heard(World(cells, (0.0, 0.0), 0.1), "node", BARE, field, (10.0, 5.0, 0.0))
    assert thick == pytest.approx(heard(hall(15.0), "node", BARE, field, (10.0, 5.0, 0.0)))


def test_walls_enough_silence_a_node():
    field = field_of((30.0, 5.0))
    assert heard(hall(), "node", BARE, field, (2.0, 5.0, 0.0))[0, 0] > -inf
    assert heard(hall(*range(4, 29, 2)), "node", BARE, field, (2.0, 5.0, 0.0))[0, 0] == -inf


def test_a_node_is_heard_to_its_reach_and_no_farther():
    field = field_of((36.9, 5.0), (37.1, 5.0))
    found = heard(hall(), "node", BARE, field, (2.0, 5.0, 0.0))[0]
    assert (found > -inf).tolist() == [True, False]


def test_a_passive_tag_needs_sight_reach_and_the_cone():
    ahead, aside, behind, far = (13.0, 5.0), (12.0, 8.0), (7.0, 5.0), (14.1, 5.0)
    field = field_of(ahead, aside, behind, far)
    front, rear = (10.0, 5.0, 0.0), (10.0, 5.0, pi)
    found = heard(hall(), "uhf", BARE_UHF, field, front, rear) > -inf
    assert found.tolist() == [[True, False, False, False], [False, False, True, False]]
    assert not (heard(hall(12.0), "uhf", BARE_UHF, field, front) > -inf).any()


@given(st.floats(-pi, pi), st.floats(-pi, pi))
def test_the_cone_turns_with_the_antenna(heading, bearing):
    field = field_of((20.0 + 3.0 * np.cos(heading + bearing), 5.0 + 3.0 * np.sin(heading + bearing)))
    found = heard(hall(), "uhf", BARE_UHF, field, (20.0, 5.0, heading))[0, 0]
    if abs(abs(bearing) - pi / 6) > 1e-6:
        assert (found > -inf) == (abs(bearing) < pi / 6)


def test_shadowing_belongs_to_the_place_of_antenna_and_tag():
    field = field_of((20.0, 5.0))
    config = replace(NODE, fading_sd_db=0.0)
    here = heard(hall(), "node", config, field, (10.1, 5.1, 0.0))
    assert heard(hall(), "node", config, field, (10.1, 5.1, 2.0)) == here
    near = heard(hall(), "node", config, field, (10.3, 5.1, 0.0))  # in the same half metre
    assert near - here == pytest.approx(20.0 * np.log10(9.9 / 9.7), abs=0.02)
    assert abs(heard(hall(), "node", config, field, (10.6, 5.1, 0.0)) - here).max() > 0.2
    assert heard(hall(), "node", config, field, (10.1, 5.1, 0.0), seed=2) != here
    field.move(0, 20.4, 5.6)
    assert abs(heard(hall(), "node", config, field, (10.1, 5.1, 0.0)) - here).max() > 0.2


@pytest.mark.parametrize("environment", ["open", "office1", "retail"])
def test_shadowing_has_the_deviation_of_the_building(environment):
    config = replace(radio_for("node", environment), power_at_1m_dbm=50.0)
    field = field_of(*((x, y) for x in (20.0, 21.0, 22.0, 23.0) for y in (3.0, 4.0, 5.0, 6.0)))
    antennas = [(x, y, 0.0) for x in np.arange(10.0, 13.0, 0.5) for y in np.arange(2.0, 8.0, 0.5)]
    found = heard(hall(), "node", config, field, *antennas)
    model = RadioModel(config)
    distance = np.hypot(*(field.places_m[None] - np.array(antennas)[:, None, :2]).transpose(2, 0, 1))
    mean = np.vectorize(model.signal_dbm)(distance)
    scores = (found - mean) / np.vectorize(model.shadowing_sd_db)(distance)
    assert scores.mean() == pytest.approx(0.0, abs=0.1)
    assert scores.std() == pytest.approx(1.0, abs=0.08)


def test_antennas_sit_where_the_radio_has_them():
    channel = Channel(hall(), field_of(), "uhf", UHF, 1)
    front, rear = channel.antennas(1.0, 2.0, pi / 2)
    assert front == pytest.approx((1.0, 2.2, pi / 2))
    assert rear == pytest.approx((1.0, 1.8, 1.5 * pi))
    assert Channel(hall(), field_of(), "node", NODE, 1).antennas(1.0, 2.0, 0.3).tolist() == [[1.0, 2.0, 0.3]]
