"""A snapshot continues bit for bit, and a strange or damaged one fails without doing anything."""

import os
import pickle
import zlib
from collections import deque

import numpy as np
import pytest

from robots.agent import ObservationError, RobotAgent
from robots.codec import encode
from robots.config import AgentConfig
from robots.se2 import Pose2
from robots.snapshot import SnapshotError, freeze, header, thaw
from robots.types import Observation


def packed(body: bytes) -> bytes:
    """Return a snapshot whose header and checksum are right, whatever the pickle says."""
    body = zlib.compress(body)
    return header() + zlib.crc32(body).to_bytes(4, "big") + body


def naming(module: str, name: str) -> bytes:
    """Return a snapshot that asks for a global."""
    return packed(f"c{module}\n{name}\n.".encode())


@pytest.fixture(scope="module")
def snapshot(robot_log) -> bytes:
    agent = RobotAgent("r1", robot_log.config)
    for observation in robot_log.observations[:100]:
        agent.step(observation)
    return agent.snapshot()


@pytest.mark.parametrize("cut", [0, 1, 137, 640, 1003])
def test_restored_agents_continue_bit_for_bit(robot_log, cut):
    log = robot_log.observations[: cut + 200]
    agent = RobotAgent("r1", robot_log.config)
    for observation in log[:cut]:
        agent.step(observation)
    restored = RobotAgent.restore(agent.snapshot())
    for observation in log[cut:]:
        assert encode(restored.step(observation)) == encode(agent.step(observation))
    assert encode(restored.report()) == encode(agent.report())
    np.testing.assert_array_equal(*(each._maps.fused.unsure(4) for each in (restored, agent)))


def test_a_restored_agent_can_be_stored_again(snapshot):
    again = RobotAgent.restore(snapshot).snapshot()
    assert encode(RobotAgent.restore(again).report()) == encode(RobotAgent.restore(snapshot).report())


def test_taking_a_snapshot_changes_nothing(robot_log):
    plain, watched = (RobotAgent("r1", robot_log.config) for _ in range(2))
    for observation in robot_log.observations[:60]:
        watched.snapshot()
        assert encode(watched.step(observation)) == encode(plain.step(observation))


def test_a_refused_observation_leaves_the_agent_as_it_was(robot_log, snapshot):
    agent = RobotAgent.restore(snapshot)
    late = Observation(seq=100, stamp_s=-1.0)
    with pytest.raises(ObservationError, match="lies before"):
        agent.step(late)
    with pytest.raises(ObservationError, match="seq 7 does not follow 99"):
        agent.step(Observation(seq=7, stamp_s=99.0))
    untouched = RobotAgent.restore(snapshot)
    following = robot_log.observations[100]
    assert encode(agent.step(following)) == encode(untouched.step(following))


def test_plain_containers_arrays_and_generators_survive():
    rng = np.random.default_rng(3)
    rng.random(5)
    state = {
        "rng": rng,
        "queue": deque([1, 2], maxlen=3),
        "pose": Pose2(1.0),
        "cells": np.eye(2, dtype=np.int8),
    }
    back = thaw(freeze(state), dict)
    assert back["rng"].random() == rng.random()
    assert back["queue"] == state["queue"]
    assert back["queue"].maxlen == 3
    assert back["pose"] == state["pose"]
    np.testing.assert_array_equal(back["cells"], state["cells"])


def test_a_malicious_pickle_is_refused_and_not_run(tmp_path):
    touched = tmp_path / "touched"

    class Malice:
        def __reduce__(self):
            return os.system, (f"touch {touched}",)

    evil = freeze(Malice())
    with pytest.raises(SnapshotError, match=r"may not hold (posix|nt)\.system"):
        thaw(evil, RobotAgent)
    assert not touched.exists()
    pickle.loads(zlib.decompress(evil[len(header()) + 4 :]))  # what a plain unpickler would have done
    assert touched.exists()


@pytest.mark.parametrize(
    ("module", "name"),
    [
        ("os", "system"),
        ("builtins", "eval"),
        ("builtins", "getattr"),
        ("subprocess", "Popen"),
        ("numpy", "load"),
        ("numpy", "memmap"),
        ("roboticon", "Thing"),
    ],
)
def test_strangers_are_refused(module, name):
    with pytest.raises(SnapshotError, match=f"may not hold {module}.{name}"):
        thaw(naming(module, name), object)


@pytest.mark.parametrize(
    ("module", "name"),
    [
        ("robots.snapshot", "thaw"),  # a function
        ("robots.snapshot", "pickle"),  # a module
        ("robots.evaluation", "Path"),  # a class from elsewhere
        ("robots.sim.live", "ThreadPoolExecutor"),
        ("robots.codec", "_CLASSES"),
    ],
)
def test_only_classes_made_here_are_called(module, name):
    with pytest.raises(SnapshotError, match=f"may not call {module}.{name}"):
        thaw(naming(module, name), object)


def test_dotted_names_do_not_lead_elsewhere():
    dotted = pickle.PROTO + b"\x04" + b"\x8c\x0frobots.snapshot" + b"\x8c\x0cpickle.loads" + b"\x93."
    with pytest.raises(SnapshotError, match=r"may not hold robots\.snapshot\.pickle\.loads"):
        thaw(packed(dotted), object)


def test_a_snapshot_of_another_program_is_refused(snapshot):
    other = b"waymark-" + bytes(8) + snapshot[16:]
    with pytest.raises(SnapshotError, match="not a snapshot of this version; replay the log instead"):
        RobotAgent.restore(other)


def test_any_damaged_byte_is_noticed(snapshot):
    rng = np.random.default_rng(8)
    places = [*range(len(header()) + 6), *rng.integers(0, len(snapshot), 60), len(snapshot) - 1]
    for place in places:
        damaged = bytearray(snapshot)
        damaged[place] ^= 1 << int(rng.integers(8))
        with pytest.raises(SnapshotError):
            RobotAgent.restore(bytes(damaged))


@pytest.mark.parametrize("kept", [0, 5, 9, 15, 16, 18, 20, 21, 200, -1])
def test_a_cut_snapshot_is_refused(snapshot, kept):
    with pytest.raises(SnapshotError, match="replay the log instead"):
        RobotAgent.restore(snapshot[:kept])


@pytest.mark.parametrize("body", [b"", b"rubbish", pickle.dumps([1, 2])[:-3], b"(lp0\n"])
def test_a_broken_pickle_under_a_right_checksum_is_refused(body):
    with pytest.raises(SnapshotError, match="cannot be read"):
        thaw(packed(body), object)


def test_another_state_than_expected_is_refused():
    with pytest.raises(SnapshotError, match="a snapshot of AgentConfig, expected RobotAgent"):
        RobotAgent.restore(freeze(AgentConfig()))
