import numpy as np
import pytest

from robots.sim.tags import Magazine, Reader, TagField
from robots.types import TagSighting


def test_writes_need_reach_and_room():
    field = TagField(capacity_bits=32)
    field.drop("a", 1.0, 1.0)
    assert field.write("a", b"four", 1.0, 1.39)
    assert not field.write("a", b"five!", 1.0, 1.0)
    assert not field.write("a", b"far", 1.0, 1.41)
    assert not field.write("b", b"none", 1.0, 1.0)
    assert field.sighting(0) == TagSighting("a", b"four")
    assert field.refused_writes == 3


def test_an_id_is_used_once():
    field = TagField(2048)
    field.drop("a", 0.0, 0.0)
    with pytest.raises(ValueError, match="a tag a already"):
        field.drop("a", 1.0, 1.0)
    field.drop("b", 2.0, 3.0)
    assert field.places_m.tolist() == [[0.0, 0.0], [2.0, 3.0]]


def test_magazines_never_clash_and_run_empty():
    magazines = [Magazine(robot_id, 5) for robot_id in ("r1", "r2", "r11")]
    ids = [magazine.take() for magazine in magazines for _ in range(5)]
    assert ids[:2] == ["r1-001", "r1-002"]
    assert len(set(ids)) == 15
    assert magazines[0].take() is None
    assert magazines[0].left == 0


def test_a_tag_is_reported_when_it_comes_and_then_once_a_second():
    field = TagField(2048)
    field.drop("a", 0.0, 0.0)
    field.drop("b", 0.0, 0.0)
    reader = Reader()
    stamps = {"a": [], "b": []}
    for tick in range(1, 81):
        under = np.array([tick <= 70, 10 <= tick < 20 or tick == 22])
        for sighting in reader.sightings(field, under, tick / 20):
            stamps[sighting.tag_id].append(tick)
    assert stamps == {"a": [1, 21, 41, 61], "b": [10, 22]}
