"""Whom an agent believes of what it reads in tags, and what it leaves there."""

import numpy as np
import pytest

from robots.agent import RobotAgent
from robots.config import AgentConfig, TagMemoryConfig
from robots.tags.marks import key_of
from robots.tags.memory import CLOSED, TagMemory
from robots.tags.sealed import close_memory, open_memory
from robots.types import DistanceTurn, HeatReading, ImuReading, LaserScan, Observation, TagSighting

KEY = "00ff17"
LIE = TagMemory(
    np.full((7, 7), CLOSED, np.uint8)
)  # so large that its middle holds for the doubt of its place


def drive(memory: bytes, heat: tuple[HeatReading, ...] = ()):
    """Drive a metre over open ground, past tag A half way; return the agent and what it wrote.

    ``heat`` is seen at each of the first steps.
    """
    agent = RobotAgent("r1", AgentConfig(tag_memory=TagMemoryConfig(key=KEY)))
    writes = []
    for seq in range(11):
        scan = LaserScan(np.full(240, 3.0, np.float32), -2.0, 4.0 / 239, 4.0)
        seen = (TagSighting("A", memory),) if seq == 5 else ()
        odometry = DistanceTurn(0.1, 0.0) if seq else None
        update = agent.step(
            Observation(
                seq,
                0.2 * seq,
                odometry,
                ImuReading(0.0),
                scan=scan,
                tag_sightings=seen,
                heat=heat if seq < 5 else (),
            )
        )
        writes += update.command.writes
    return agent, writes


def claimed(agent: RobotAgent) -> int:
    grid = agent._scout.explorer._grid
    claims = agent._scout.explorer.claims
    return int((claims.survey(grid, claims.tags({"A": (0.5, 0.0)}.get)).claimed == CLOSED).sum())


def test_what_the_mission_wrote_is_believed_and_kept():
    agent, (write,) = drive(close_memory(LIE, 7, "A", bytes.fromhex(KEY), 196))
    assert claimed(agent) > 0
    says = open_memory(write.memory, "A", bytes.fromhex(KEY))
    assert (says.trusted, says.next_revision) == (True, 9)
    assert says.memory.merge(LIE) == says.memory


@pytest.mark.parametrize(
    "forged",
    [
        close_memory(LIE, 7, "A", b"stranger", 196),
        close_memory(LIE, 7, "A", b"", 196),
        close_memory(LIE, 7, "B", bytes.fromhex(KEY), 196),  # copied from another tag
    ],
    ids=["forged", "unsealed", "copied"],
)
def test_a_stranger_is_not_believed_and_its_memory_is_left_as_it_is(forged):
    agent, writes = drive(forged)
    assert claimed(agent) == 0
    assert writes == []


def test_an_empty_tag_gets_what_is_known():
    agent, (write,) = drive(b"")
    assert claimed(agent) == 0
    assert open_memory(write.memory, "A", bytes.fromhex(KEY)).memory.cells.any()


def test_a_victim_that_it_knows_is_left_in_a_tag_near_it_with_where_it_lies():
    warm = (HeatReading(0.6, 2.0, 0.9),)
    agent, (write,) = drive(b"", warm)
    (known,) = agent._victims.known(agent._slam.anchors)
    (mark,) = open_memory(write.memory, "A", bytes.fromhex(KEY)).memory.victims
    assert mark.key == key_of(known.victim_id) == key_of("r1-V1")
    tag_m = agent._slam.tag_place("A")
    offset = np.subtract(known.place_m, tag_m)
    np.testing.assert_allclose((0.1 * mark.north_dm, 0.1 * mark.west_dm), offset, atol=0.06)
    assert np.hypot(*offset) > 1.0
    assert mark.confidence / 255 == pytest.approx(known.confidence, abs=0.01)
    _, (silent,) = drive(b"")
    assert open_memory(silent.memory, "A", bytes.fromhex(KEY)).memory.victims == ()


def test_what_is_told_counts_as_far_as_the_robot_knows_where_the_tag_lies():
    agent, _ = drive(close_memory(LIE, 7, "A", bytes.fromhex(KEY), 196))
    sd_m = float(np.sqrt(np.linalg.eigvalsh(agent._slam.belief.covariance[:2, :2])[-1]))
    assert 0.3 * sd_m < agent._scout.explorer.claims._sds_m["A"] <= sd_m  # as it was when it read the tag
    assert 0 < claimed(agent) < LIE.cells.size * 4  # its rim is in doubt
