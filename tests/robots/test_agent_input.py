"""What an agent cannot take is refused and changes nothing; what it can take never breaks it."""

from __future__ import annotations

from math import inf, nan

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robots.agent import ObservationError, RobotAgent
from robots.codec import encode
from robots.config import AgentConfig, ConfigError, PlanningConfig
from robots.se2 import Pose2
from robots.types import (
    Displacement,
    DistanceTurn,
    ImuReading,
    LaserScan,
    Observation,
    RobotSighting,
    TagSighting,
    WheelEncoders,
)
from tests.robots.recorded import driving

GOOD = DistanceTurn(0.1, 0.0)
BAD: dict[str, tuple[Observation, str]] = {
    "a gap": (Observation(42, 10.0, GOOD), "seq 42 does not follow 40"),
    "again": (Observation(40, 10.0, GOOD), "seq 40 does not follow 40"),
    "before": (Observation(39, 10.0, GOOD), "seq 39 does not follow 40"),
    "backwards": (Observation(41, 7.9, GOOD), "stamp_s 7.9 lies before 8.0 of seq 40"),
    "no stamp": (Observation(41, nan, GOOD), "stamp_s is not finite"),
    "endless stamp": (Observation(41, inf, GOOD), "stamp_s is not finite"),
    "distance": (Observation(41, 10.0, DistanceTurn(nan, 0.0)), "odometry.distance_m is not finite"),
    "turn": (Observation(41, 10.0, DistanceTurn(0.0, -inf)), "odometry.turn_rad is not finite"),
    "wheel": (Observation(41, 10.0, WheelEncoders(0, 0, nan, 0)), "odometry.rear_left_m is not finite"),
    "shift": (Observation(41, 10.0, Displacement(0, inf, 0)), "odometry.dy_m is not finite"),
    "yaw": (Observation(41, 10.0, GOOD, ImuReading(nan)), "imu holds a value that is not finite"),
    "roll": (Observation(41, 10.0, GOOD, ImuReading(0.0, nan)), "imu holds a value that is not finite"),
    "tag range": (
        Observation(41, 10.0, GOOD, tag_sightings=(TagSighting("A", b"", inf, 0.0),)),
        "a sighting holds a value that is not finite",
    ),
    "robot bearing": (
        Observation(41, 10.0, GOOD, robot_sightings=(RobotSighting("r2", 1.0, nan),)),
        "a sighting holds a value that is not finite",
    ),
    "a bearing alone": (
        Observation(41, 10.0, GOOD, tag_sightings=(TagSighting("A", b"", None, 1.0),)),
        "sighting of A has a bearing without a range",
    ),
    "an antenna alone": (
        Observation(41, 10.0, GOOD, tag_sightings=(TagSighting("A", antenna="rear"),)),
        "sighting of A names an antenna without a range or rssi",
    ),
    "a signal that is none": (
        Observation(41, 10.0, GOOD, tag_sightings=(TagSighting("A", rssi_dbm=float("nan")),)),
        "a sighting holds a value that is not finite",
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_what_cannot_follow_is_refused_and_changes_nothing(case):
    observation, message = BAD[case]
    agent = RobotAgent("r1", AgentConfig())
    for earlier in driving(41, GOOD, {10: "A"}):
        agent.step(earlier)
    before = agent.snapshot()
    with pytest.raises(ObservationError, match=message):
        agent.step(observation)
    assert agent.snapshot() == before
    untouched = RobotAgent.restore(before)
    for later in driving(20, GOOD, {50: "A"}, start=41):
        assert encode(agent.step(later)) == encode(untouched.step(later))


def test_the_first_observation_is_checked_too():
    agent = RobotAgent("r1", AgentConfig())
    with pytest.raises(ObservationError, match="odometry"):
        agent.step(Observation(0, 0.0, DistanceTurn(nan, 0.0)))
    with pytest.raises(ObservationError, match="has not observed anything yet"):
        agent.report()
    assert agent.step(Observation(7, 3.0)).seq == 7  # a log may begin anywhere


def test_two_observations_may_share_a_stamp():
    agent = RobotAgent("r1", AgentConfig())
    for seq in range(3):
        update = agent.step(Observation(seq, 1.0, GOOD, ImuReading(0.1 * seq)))
    assert np.isfinite(update.covariance).all()


def test_an_unknown_strategy_is_named_at_once():
    with pytest.raises(ConfigError, match=r"'telepathy'; known are aojrf, .*waymark, ziparo"):
        RobotAgent("r1", AgentConfig(planning=PlanningConfig(explore="telepathy")))


@pytest.mark.parametrize("far", [4.0, inf, nan])
def test_scans_without_an_echo_leave_the_pose_to_odometry(far):
    """Glass all round, or smoke: free space is not claimed beyond reason and nothing breaks."""
    scan = LaserScan(np.full(240, far, np.float32), -2.0, 4.0 / 239, 4.0)
    agent = RobotAgent("r1", AgentConfig())
    for seq in range(100):
        update = agent.step(Observation(seq, seq * 0.2, DistanceTurn(0.05, 0.01) if seq else None, scan=scan))
    assert update.distance_m == pytest.approx(99 * 0.05)
    expected = Pose2()
    for _ in range(99):
        expected = expected @ Pose2(0.05, 0.0, 0.01)
    assert update.pose.distance(expected) < 1e-9


ranges = st.lists(
    st.one_of(st.floats(width=32), st.sampled_from([0.0, -1.0, 0.3, 4.0, inf, nan])), min_size=0, max_size=40
)


@settings(max_examples=40, deadline=None)
@given(st.lists(ranges, min_size=1, max_size=6))
def test_no_scan_whatever_breaks_it(scans):
    agent = RobotAgent("r1", AgentConfig())
    for seq, values in enumerate(scans):
        scan = LaserScan(np.array(values, np.float32), -2.0, 0.1, 4.0)
        update = agent.step(Observation(seq, seq * 0.2, DistanceTurn(0.05, 0.1), scan=scan))
        assert np.isfinite(update.pose.as_array()).all()
        assert np.isfinite(update.covariance).all()
        assert np.isfinite([update.command.linear_mps, update.command.angular_radps]).all()
