"""A simulated person: understands a phone's sentence, errs as told, and goes by what the phone says alone."""

from math import hypot

import numpy as np
import pytest

from robots.estimation.radio.hearing import Ears, NodePlace
from robots.estimation.radio.locating import Plan, Since, locate
from robots.estimation.radio.model import NODE
from robots.routes.fix_words import right_to_m
from robots.sim.hearing import Device
from robots.sim.starts import Victim
from robots.sim.tags import TagField
from robots.sim.walker import Advice, Fix, Gait, Walker
from robots.sim.walker_words import Piece, pieces_of
from robots.sim.world import world_of

EXACT = Gait(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


def hall(walls=()):
    solid = np.zeros((200, 300), bool)  # 20 m to the west, 30 m to the north
    for rows, columns in walls:
        solid[rows, columns] = True
    return world_of(solid, 0.1)


def tags_at(**places):
    field = TagField(0)
    for tag_id, place in places.items():
        field.drop(tag_id, *place)
    return field


def walked(walker, ticks=4000):
    for _ in range(ticks):
        if not walker.advance():
            return walker
    raise AssertionError("still walking")


@pytest.mark.parametrize(
    ("text", "pieces"),
    [
        ("Go 6 m north to tag A4.", [Piece(6.0)]),
        ("Go about 12 m south-east, turn left and go 3 m to tag B.", [Piece(12.0), Piece(3.0, "left")]),
        (
            "Go 1 m west, turn round and go about 2 m to tag go 9. Take care: gas.",
            [Piece(1.0), Piece(2.0, "round")],
        ),
        ("From tag A4 go 3 m north: there is victim v1.", [Piece(3.0)]),
    ],
)
def test_a_sentence_is_understood(text, pieces):
    assert pieces_of(text) == pieces


def test_who_does_not_err_goes_straight_to_the_next_tag_and_the_victim():
    said = {
        "A": Advice(0.0, "Go 8 m north, turn left and go 5 m to tag B.", "B"),
        "B": Advice(270.0, "go 4 m", None),
    }
    tags = tags_at(A=(5.0, 5.0), B=(13.0, 10.0))
    victims = (Victim("v", 13.0, 14.0),)
    walker = walked(Walker(hall(), tags, victims, said.get, (5.0, 5.2), 1, EXACT))
    assert walker.read == ["A", "B"]
    assert walker.arrived
    assert hypot(walker.x_m - 13.0, walker.y_m - 14.0) < 0.7
    assert walker.walked_m < 18.0


def test_walls_are_gone_round():
    wall = [(slice(0, 150), slice(100, 104))]
    said = {"A": Advice(0.0, "Go 8 m north to tag B.", "B")}
    tags = tags_at(A=(6.0, 13.5), B=(14.0, 13.5))
    walker = walked(Walker(hall(wall), tags, (), said.get, (6.0, 13.5), 1, EXACT))
    assert walker.read == ["A", "B"]


def test_a_tag_that_is_not_where_it_should_be_is_looked_for():
    said = {"A": Advice(0.0, "Go 8 m north to tag B.", "B")}
    tags = tags_at(A=(5.0, 10.0), B=(13.0, 13.0))
    assert walked(Walker(hall(), tags, (), said.get, (5.0, 10.0), 1, EXACT)).read == ["A", "B"]


def test_who_finds_nothing_stays_and_is_not_there():
    said = {"A": Advice(0.0, "Go 8 m north to tag B.", "B")}
    walker = walked(
        Walker(hall(), tags_at(A=(5.0, 10.0)), (Victim("v", 26.0, 3.0),), said.get, (5.0, 10.0), 1)
    )
    assert not walker.arrived
    assert walker.last_tag == "A"


def test_a_phone_that_points_the_wrong_way_leads_nobody():
    """The walker goes by the phone: what it knows of the world does not bring it there by itself."""
    wrong = {"A": Advice(180.0, "go 12 m", None)}
    right = {"A": Advice(0.0, "go 12 m", None)}
    victims = (Victim("v", 27.0, 10.0),)
    for seed in range(3):
        start = {"start_m": (15.0, 10.0), "seed": seed}
        tags = tags_at(A=(15.0, 10.0))
        assert not walked(Walker(hall(), tags, victims, wrong.get, **start)).arrived
        assert walked(Walker(hall(), tags, victims, right.get, **start)).arrived


def test_the_same_seed_walks_the_same_way():
    said = {"A": Advice(0.0, "Go 8 m north to tag B.", "B")}
    ends = []
    for seed in (1, 1, 2):
        walker = walked(
            Walker(hall(), tags_at(A=(5.0, 10.0), B=(13.0, 10.0)), (), said.get, (5.0, 10.0), seed)
        )
        ends.append((walker.x_m, walker.y_m))
    assert ends[0] == ends[1] != ends[2]


def test_who_is_not_where_the_next_tag_should_be_goes_on_by_the_nodes_that_are_heard():
    """The way was said to be half as long as it is; the signals are the channel's, the places the robots'."""
    nodes = {"N0": (2, 2), "N1": (28, 3), "N2": (27, 18), "N3": (3, 17), "N4": (15, 19), "N5": (16, 1)}
    plan = Plan(np.ones((20, 30), np.uint8), (0.0, 0.0), 1.0)
    tags = tags_at(A=(5.0, 10.0), B=(21.0, 10.0), **nodes)
    said = {"A": Advice(0.0, "Go 8 m north to tag B.", "B", (16.0, 0.0))}
    ears, device = Ears(), Device(hall(), tags, NODE, 4)
    asked = []

    def listen(tag, x_m, y_m, steps):
        heard = {}
        for node_id, rssi_dbm in device.heard_at(x_m, y_m):
            heard.setdefault(node_id, []).append(rssi_dbm)
        known = [NodePlace(name, *map(float, nodes[name]), 0.2) for name in heard if name in nodes]
        ranges = [ears.by_signal(node, heard[node.node_id]) for node in known]
        found = locate([r for r in ranges if r], ears.shared, Since(5.0, 10.0, 0.5, 0.91 * steps), plan)
        place = found.places[0]
        asked.append(hypot(place.x_m - x_m, place.y_m - y_m))
        return Fix((place.x_m - 5.0, place.y_m - 10.0), right_to_m(place))

    deaf = Walker(hall(), tags, (), said.get, (5.0, 10.0), 1, EXACT)
    assert "B" not in walked(deaf).read
    hearing = Walker(hall(), tags, (), said.get, (5.0, 10.0), 1, EXACT, listen)
    assert walked(hearing).read[:2] == ["A", "B"]
    assert asked[0] < 4.0
