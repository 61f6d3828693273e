"""The agent as a function of its log: the same answers every time, also from a snapshot."""

from __future__ import annotations

import zlib
from dataclasses import replace
from itertools import pairwise
from pickletools import genops

import pytest

from robots.agent import RobotAgent
from robots.codec import decode, encode
from robots.config import AgentConfig
from robots.se2 import Pose2
from robots.snapshot import SnapshotError, freeze, header
from robots.types import (
    AgentUpdate,
    ImuReading,
)
from tests.robots.recorded import mission_log, mission_updates, replayed


def test_the_same_log_gives_the_same_updates_bit_for_bit():
    first, second = mission_updates(True), replayed(*mission_log(True))
    assert [encode(update) for update in first] == [encode(update) for update in second]
    assert any(update.graph is not None for update in first[1:])
    assert any(update.submaps for update in first)
    assert any(update.command.drop_tag for update in first)
    assert {update.activity for update in first} >= {"exploring"}


def test_the_mission_itself_was_answered_the_same():
    """The simulated robot lost its tags where the replay drops them."""
    log, _ = mission_log(True)
    updates = mission_updates(True)
    dropped = [update.seq for update in updates if update.command.drop_tag]
    assert dropped
    gone = [b.seq for a, b in pairwise(log) if a.tags_left is not None and a.tags_left != b.tags_left]
    assert gone == [seq + 1 for seq in dropped]


def test_another_seed_drops_its_tags_elsewhere():
    """By chance, as Kleiner 2006 drops them; strategies that want tags evenly leave nothing to chance."""
    log, config = mission_log(True)
    config = replace(
        config,
        planning=replace(config.planning, explore="nearest"),
        deployment=replace(config.deployment, spacing_m=0.5),  # those of the log stand in the way of few
    )
    dropped = [
        [u.seq for u in replayed(log[:1000], replace(config, seed=seed)) if u.command.drop_tag]
        for seed in (1, 1, 2)
    ]
    assert dropped[0] == dropped[1] != dropped[2]


def test_updates_survive_the_codec():
    for update in mission_updates(True)[:800]:
        data = encode(update)
        assert encode(decode(data, AgentUpdate)) == data


@pytest.mark.parametrize("imu", [True, False], ids=["imu", "wheels"])
def test_a_snapshot_taken_anywhere_goes_on_as_if_nothing_had_happened(imu):
    log, config = mission_log(imu)
    expected = [encode(update) for update in mission_updates(imu)]
    sightings = [k for k, observation in enumerate(log) if observation.tag_sightings]
    for stop in (1, 403, sightings[len(sightings) // 2] + 1, len(log) - 400):
        agent = RobotAgent("r1", config)
        for observation in log[:stop]:
            agent.step(observation)
        data = agent.snapshot()
        restored = RobotAgent.restore(data)
        assert restored.snapshot() == data
        opcodes = {opcode.name for opcode, _, _ in genops(zlib.decompress(data[len(header()) + 4 :]))}
        assert not opcodes & {"EMPTY_SET", "FROZENSET"}  # whose order would be another in another process
        assert encode(restored.report()) == encode(agent.report())
        until = min(stop + 600, len(log))
        after = [encode(restored.step(observation)) for observation in log[stop:until]]
        assert after == expected[stop:until]


def test_a_fresh_agent_has_a_snapshot_too():
    log, config = mission_log(True)
    restored = RobotAgent.restore(RobotAgent("r1", config).snapshot())
    again = [encode(restored.step(observation)) for observation in log[:50]]
    assert again == [encode(update) for update in mission_updates(True)[:50]]


def test_what_is_no_snapshot_is_refused():
    data = RobotAgent("r1", AgentConfig()).snapshot()
    for damaged in (b"", b"hello", data[:-1], data[:40] + bytes([data[40] ^ 1]) + data[41:], b"x" + data):
        with pytest.raises(SnapshotError):
            RobotAgent.restore(damaged)
    for foreign in (print, [Pose2()], ImuReading(0.1)):
        with pytest.raises(SnapshotError):
            RobotAgent.restore(freeze(foreign))


def test_reports_hold_everything_that_was_told():
    log, config = mission_log(True)
    agent = RobotAgent("r1", config)
    updates = [agent.step(observation) for observation in log]
    report = agent.report()
    assert report.graph is not None
    last_graph = next(u.graph for u in reversed(updates) if u.graph is not None)
    assert encode(report.graph) == encode(last_graph)
    told = {submap.anchor: submap for update in updates for submap in update.submaps}
    whole = {submap.anchor: submap for submap in report.submaps}
    assert set(told) <= set(whole)
    for anchor, submap in told.items():
        assert submap.version <= whole[anchor].version
    assert len(report.victims) == len({v.victim_id for u in updates for v in u.victims})
    assert report.pose == updates[-1].pose
    assert report.seq == log[-1].seq
