"""How often tags are read, and what a reading says."""

from dataclasses import replace

import numpy as np
import pytest

from robots.config import RadioConfig
from robots.estimation.radio.model import UHF
from robots.se2 import Pose2
from robots.sim.channel import Channel
from robots.sim.hostile import HostileConfig
from robots.sim.node_life import NodeLife
from robots.sim.receivers import UHF_TAGS_PER_S, Receiver, read_rate_hz
from robots.sim.tags import TagField
from robots.sim.world import World

QUIET = RadioConfig(shadowing_sd_db=0.0)
HALL = World(np.zeros((200, 200), np.uint8), (0.0, 0.0), 0.1)
HERE, DT_S = Pose2(10.0, 10.0, 0.0), 0.05


def ring(count, radius_m=3.0):
    angles = 2.0 * np.pi * np.arange(count) / max(count, 1)
    return HERE.x + radius_m * np.column_stack([np.cos(angles), np.sin(angles)])


def receiver(places_m, hardware="node", config=QUIET, spike_share=0.0, seed=1):
    field = TagField(2048)
    life = NodeLife(HALL, field, places_m, HostileConfig(), 0.2, 600.0, np.random.default_rng(0))
    channel = Channel(HALL, field, hardware, config, 1)
    return field, Receiver(channel, field, life, spike_share, np.random.default_rng(seed))


def listen(radio, seconds, pose=HERE, start_s=0.0):
    ticks = range(1, round(seconds / DT_S) + 1)
    return [s for k in ticks for s in radio.sightings(pose, start_s + k * DT_S, DT_S)]


@pytest.mark.parametrize(("nodes", "rate_hz"), [(1, 28.6), (4, 27.5), (8, 16.5), (16, 8.25)])
def test_nodes_are_read_as_often_as_the_table_says(nodes, rate_hz):
    _, radio = receiver(ring(nodes))
    heard = listen(radio, 60.0)
    assert read_rate_hz(nodes) == rate_hz
    assert len(heard) / 60.0 / nodes == pytest.approx(rate_hz, rel=0.03)
    each = [sum(s.tag_id == f"N{k + 1:02d}" for s in heard) / 60.0 for k in range(nodes)]
    assert each == pytest.approx([rate_hz] * nodes, rel=0.1)


def test_a_reader_of_passive_tags_has_time_for_fifty_a_second():
    field, radio = receiver(np.array([[12.0, 10.0], [12.0, 10.4], [8.0, 10.0]]), "uhf", UHF)
    heard = listen(radio, 20.0)
    assert len(heard) == UHF_TAGS_PER_S * 20.0
    assert {(s.tag_id, s.antenna) for s in heard} == {("N01", "front"), ("N02", "front"), ("N03", "rear")}
    assert {s.sensors for s in heard} == {None}
    assert all(radio.reaches(index) for index in range(len(field.tags)))


def test_readings_fade_about_the_mean_of_their_place():
    _, radio = receiver(ring(1))
    signals = np.array([s.rssi_dbm for s in listen(radio, 60.0)])
    assert signals.mean() == pytest.approx(-12.0 - 20.0 * np.log10(3.0), abs=0.2)
    assert signals.std() == pytest.approx(QUIET.fading_sd_db, rel=0.08)


def test_some_readings_are_far_off():
    _, radio = receiver(ring(1), spike_share=0.05)
    signals = np.array([s.rssi_dbm for s in listen(radio, 60.0)])
    off = np.abs(signals - np.median(signals)) > 8.0
    assert off.mean() == pytest.approx(0.05, abs=0.02)


def test_memory_and_sensors_come_once_a_second():
    field, radio = receiver(ring(2))
    assert field.write("N01", b"left here", 13.0, 10.0)
    heard = [s for s in listen(radio, 10.0) if s.tag_id == "N01"]
    assert [s.memory for s in heard[:2]] == [b"left here", b""]
    assert sum(bool(s.memory) for s in heard) == pytest.approx(10, abs=1)
    assert all((s.sensors is None) == (s.memory == b"") for s in heard)
    assert field.write("N01", b"written since", 13.0, 10.0)
    assert b"written since" in {s.memory for s in listen(radio, 0.3, start_s=10.0)}


def test_a_memory_is_within_reach_of_the_radio_only():
    field, radio = receiver(np.array([[12.0, 10.0], [15.0, 10.0]]), "uhf", UHF)
    listen(radio, 1.0)
    assert field.write("N01", b"mine", HERE.x, HERE.y, radio.reaches)
    assert not field.write("N02", b"mine", HERE.x, HERE.y, radio.reaches)
    assert not field.write("N01", b"mine", HERE.x, HERE.y)


def test_a_node_that_is_switched_off_or_carried_off_falls_silent():
    field, radio = receiver(ring(2))
    assert {s.tag_id for s in listen(radio, 1.0)} == {"N01", "N02"}
    field.switch(0, False)
    assert {s.tag_id for s in listen(radio, 1.0, start_s=1.0)} == {"N02"}
    field.move(1, 60.0, 10.0)
    assert not listen(radio, 1.0, start_s=2.0)
    field.switch(0, True)
    assert {s.tag_id for s in listen(radio, 1.0, start_s=3.0)} == {"N01"}


def test_the_same_seed_reads_the_same():
    config = replace(QUIET, shadowing_sd_db=4.0)
    first, same, other = (listen(receiver(ring(3), config=config, seed=k)[1], 3.0) for k in (1, 1, 2))
    assert first == same
    assert first != other
