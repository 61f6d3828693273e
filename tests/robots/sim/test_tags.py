import numpy as np
import pytest

from robots.sim.scenario import ScenarioConfig
from robots.sim.tags import Magazine, Reader, TagField
from robots.tags.chip import chip_of
from robots.tags.record import seal
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


def test_chips_hold_what_has_room_beside_their_link():
    field = TagField(2048, chip_of(2048))
    field.drop("r1-001", 0.0, 0.0)
    room = ScenarioConfig().tag_room_bytes
    for revision, length in enumerate((0, 100, room)):
        record = seal(bytes(length), revision, "r1-001", b"key")
        assert field.write("r1-001", record, 0.0, 0.0)
        assert field.sighting(0) == TagSighting("r1-001", record)
    assert not field.write("r1-001", seal(bytes(room + 10), 3, "r1-001", b"key"), 0.0, 0.0)
    assert field.sighting(0) == TagSighting("r1-001", record)
    assert field.write("r1-001", b"no record", 0.0, 0.0)
    assert field.sighting(0) == TagSighting("r1-001", b"")  # a reader hands over whole records alone


def test_large_chips_keep_the_older_record_too():
    field = TagField(4032, chip_of(4032))
    field.drop("a", 0.0, 0.0)
    records = [seal(bytes([k]), k, "a", b"key") for k in range(3)]
    for record in records:
        assert field.write("a", record, 0.0, 0.0)
    assert field.sighting(0).memory == records[2] + records[1]


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
