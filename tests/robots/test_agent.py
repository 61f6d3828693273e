"""The agent as a function of its log: the same answers every time, nothing lost, bad input refused."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import pairwise
from math import inf, nan, pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robots.agent import ObservationError, RobotAgent, merge_commands
from robots.codec import decode, encode
from robots.config import AgentConfig, BodyConfig, ConfigError, PlanningConfig
from robots.estimation.odometry import motion_mean
from robots.evaluation import absolute_error
from robots.mapping.submap import unpack
from robots.se2 import Pose2, wrap
from robots.sim.runner import run
from robots.sim.scenario import ScenarioConfig
from robots.sim.sensors import LaserConfig
from robots.sim.solution import solve
from robots.snapshot import SnapshotError, freeze
from robots.trajectory import Trajectory
from robots.types import (
    AgentUpdate,
    Command,
    Displacement,
    DistanceTurn,
    HeatReading,
    ImuReading,
    LaserScan,
    Observation,
    Odometry,
    RobotSighting,
    TagSighting,
    TagWrite,
    WheelEncoders,
)

MISSION = ScenarioConfig(map="office:100", robots=1, minutes=2.0, seed=4, noise_level=3, victims=2)
Log = tuple[Observation, ...]


class Listener:
    """An agent that keeps what it was told."""

    def __init__(self, robot_id: str, config: AgentConfig) -> None:
        self.agent = RobotAgent(robot_id, config)
        self.heard: list[Observation] = []

    def step(self, observation: Observation) -> AgentUpdate:
        self.heard.append(observation)
        return self.agent.step(observation)

    def smoothed(self) -> AgentUpdate:
        return self.agent.smoothed()


@lru_cache(maxsize=4)
def mission_log(imu: bool) -> tuple[Log, AgentConfig]:
    listeners: list[Listener] = []

    def listener(robot_id: str, config: AgentConfig) -> Listener:
        listeners.append(Listener(robot_id, config))
        return listeners[-1]

    scenario = replace(MISSION, imu=imu)
    run(scenario, listener)
    return tuple(listeners[0].heard), scenario.agent_of("r1")


def replayed(log: Sequence[Observation], config: AgentConfig, robot_id: str = "r1") -> list[AgentUpdate]:
    agent = RobotAgent(robot_id, config)
    return [agent.step(observation) for observation in log]


@lru_cache(maxsize=4)
def mission_updates(imu: bool) -> tuple[AgentUpdate, ...]:
    return tuple(replayed(*mission_log(imu)))


def driving(
    steps: int, odometry: Odometry, tags: dict[int, str] | None = None, start: int = 0
) -> list[Observation]:
    """A log without a laser: the same odometry ``steps`` times, at 5 Hz, with tags at some of them."""
    return [
        Observation(
            seq=seq,
            stamp_s=seq * 0.2,
            odometry=odometry,
            tag_sightings=(TagSighting(tags[seq]),) if tags and seq in tags else (),
        )
        for seq in range(start, start + steps)
    ]


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
    log, config = mission_log(True)
    dropped = [update.seq for update in mission_updates(True) if update.command.drop_tag]
    until = dropped[0] + 200
    other = replayed(log[:until], replace(config, seed=config.seed + 1))
    assert [u.seq for u in other if u.command.drop_tag] != [seq for seq in dropped if seq < until]


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
    with pytest.raises(ConfigError, match="'telepathy'; known are nearest"):
        RobotAgent("r1", AgentConfig(planning=PlanningConfig(explore="telepathy")))


def test_all_forms_of_odometry_lead_to_the_same_place():
    """The wheels of a mission, said in the other words; only four wheels can tell of slippage."""
    log, config = mission_log(False)
    log, config = log[:1200], replace(config, odometry=replace(config.odometry, slip="off"))

    def said(observation: Observation, form: str) -> Observation:
        motion = motion_mean(observation.odometry, None, config.body)
        if form == "displacement":
            return replace(observation, odometry=Displacement(motion.x, motion.y, motion.theta))
        return replace(observation, odometry=DistanceTurn(motion.x, motion.theta))

    same = replayed([said(o, "displacement") for o in log], config)
    for a, b in zip(replayed(log, config), same, strict=True):
        assert a.pose.distance(b.pose) < 1e-6
    assert same[-1].distance_m > 3.0
    blind = [replace(o, scan=None) for o in log]
    wheels = replayed(blind, config)
    near = replayed([said(o, "distance_turn") for o in blind], config)
    for a, b in zip(wheels, near, strict=True):
        assert a.pose.distance(b.pose) < 0.1  # (d, alpha) drives first and then turns, within a tick


def test_what_was_driven_before_the_first_observation_is_not_part_of_the_map():
    update = RobotAgent("r1", AgentConfig()).step(Observation(0, 0.0, DistanceTurn(3.0, 1.0)))
    assert update.pose == Pose2()
    assert update.distance_m == 0.0


def test_with_a_compass_the_map_points_north_and_without_it_ahead():
    with_compass = RobotAgent("r1", AgentConfig()).step(Observation(0, 0.0, imu=ImuReading(2.0)))
    without = RobotAgent("r1", AgentConfig()).step(Observation(0, 0.0))
    assert with_compass.pose == Pose2(0.0, 0.0, 2.0)
    assert without.pose == Pose2()
    assert with_compass.graph is not None
    assert without.graph is not None
    assert with_compass.graph.yaws_rad.tolist() == [2.0]
    assert np.isnan(without.graph.yaws_rad).all()


def test_without_an_inertial_unit_the_wheels_and_the_scans_do():
    log, _ = mission_log(False)
    updates = mission_updates(False)
    assert all(observation.imu is None for observation in log)
    graphs = [update.graph for update in updates if update.graph is not None]
    assert len(graphs) > 2
    assert np.isnan(graphs[-1].yaws_rad).all()
    assert updates[-1].distance_m > 10.0
    assert updates[-1].explored_m2 > 30.0


def test_without_a_laser_it_reckons_and_stands():
    """A circle of 400 steps: dead reckoning closes it, the covariance grows, and nobody explores blindly."""
    turn = 2 * pi / 400
    agent = RobotAgent("r1", AgentConfig())
    spreads = []
    for observation in driving(401, Displacement(0.05, 0.0, turn)):
        update = agent.step(observation)
        spreads.append(float(np.trace(update.covariance)))
        assert update.command == Command()
        assert update.activity == "starting"
    assert update.pose.distance(Pose2()) < 1e-9
    assert wrap(update.pose.theta) == pytest.approx(0.0, abs=1e-9)
    assert (np.diff(spreads[:200]) > 0.0).all()
    assert update.distance_m == pytest.approx(20.0)
    assert update.anchor == 1  # after 12 m without a tag
    assert agent.report().graph is not None


def test_held_it_stands_still_and_says_so():
    log, config = mission_log(True)
    assert mission_updates(True)[399].activity == "exploring"
    held = replayed([*log[:400], *(replace(o, held=True) for o in log[400:480])], config)[400:]
    with_scan = [u for u, o in zip(held, log[400:480], strict=True) if o.scan is not None]
    for update in with_scan:
        assert (update.command.linear_mps, update.command.angular_radps) == (0.0, 0.0)
        assert not update.command.drop_tag
        assert update.activity == "holding"


def test_pressed_against_something_the_wheels_do_not_count():
    agent = RobotAgent("r1", AgentConfig())
    agent.step(Observation(0, 0.0))
    free = agent.step(Observation(1, 0.2, GOOD))
    pressed = agent.step(Observation(2, 0.4, GOOD, bumper=True))
    assert (free.slipping, pressed.slipping) == (False, True)
    assert pressed.pose.distance(free.pose) == 0.0
    slip_sd = AgentConfig().odometry.slip_sd_per_sqrt_s
    assert pressed.covariance[0, 0] > free.covariance[0, 0] + 0.9 * slip_sd**2 * 0.2
    truth = RobotAgent("r1", AgentConfig(poses="truth"))
    truth.step(Observation(0, 0.0))
    moved = truth.step(Observation(1, 0.2, GOOD, bumper=True))
    assert moved.pose.x == pytest.approx(0.1)
    assert not moved.slipping


def test_pressed_for_a_while_it_backs_off():
    log, config = mission_log(True)
    start = next(k for k, u in enumerate(mission_updates(True)) if k > 300 and u.command.linear_mps > 0.3)
    agent = RobotAgent("r1", config)
    for observation in log[: start + 1]:
        agent.step(observation)
    commands = []
    for observation in log[start + 1 : start + 41]:
        commands.append(agent.step(replace(observation, bumper=True)).command)
    assert min(command.linear_mps for command in commands) < 0.0


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


# What it does on a whole mission


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


def test_it_explores_maps_and_spends_its_tags():
    _, config = mission_log(True)
    updates = mission_updates(True)
    explored = [update.explored_m2 for update in updates]
    assert explored[-1] > 30.0
    assert updates[-1].distance_m > 15.0
    dropped = sum(update.command.drop_tag for update in updates)
    assert dropped >= 1
    assert updates[-1].tags_left == config.deployment.magazine - dropped
    body: BodyConfig = config.body
    for update in updates:
        assert abs(update.command.linear_mps) <= body.max_speed_mps
        assert abs(update.command.angular_radps) <= body.max_turn_radps + 1e-9
        assert update.reason
    cells = unpack(next(submap for update in reversed(updates) for submap in update.submaps))
    assert (cells > 0).any()
    assert (cells < 0).any()


def test_victims_are_where_the_readings_cross():
    """Three readings of one place from three poses, one false alarm."""
    agent = RobotAgent("r1", AgentConfig())
    victim, updates = np.array([2.0, 1.0]), []
    for seq in range(11):
        x = 0.1 * seq
        bearing, away = np.arctan2(victim[1], victim[0] - x), np.hypot(victim[0] - x, victim[1])
        heat = (HeatReading(float(bearing), float(away), 0.8),) if seq in (0, 5, 10) else ()
        if seq == 3:
            heat = (HeatReading(-1.0, 2.5, 0.9),)
        odometry = DistanceTurn(0.1, 0.0) if seq else None
        updates.append(agent.step(Observation(seq, seq * 0.2, odometry, heat=heat)))
    assert [len(update.victims) for update in updates] == [0] * 10 + [1]
    (found,) = updates[-1].victims
    assert found.sightings == 3
    assert found.position_m == pytest.approx(victim, abs=0.02)
    assert agent.report().victims[0].victim_id == found.victim_id
    assert (found.first_seen_s, found.last_seen_s) == (0.0, 2.0)


@pytest.mark.parametrize(("laser_sd_m", "at_most_m"), [(0.0, 0.04), (0.01, 0.08)])
def test_without_noise_the_trajectory_is_true(laser_sd_m, at_most_m):
    """Exact wheels, no compass: what is left is the matcher's own error, over 40 m and more."""
    scenario = ScenarioConfig(
        map="office:100",
        robots=1,
        minutes=2.0,
        seed=2,
        noise_level=0,
        imu=False,
        victims=0,
        laser=LaserConfig(sd_m=laser_sd_m),
    )
    result = run(scenario)
    assert result.robots[0].distance_m > 15.0
    (solved,) = solve(result).robots
    assert absolute_error(solved.final, solved.truth).rmse_m < at_most_m
    robot = result.robots[0]
    world = np.array([(robot.world_from_map @ Pose2.from_array(pose)).as_array() for pose in robot.poses])
    online = Trajectory(robot.stamps_s, world)
    assert absolute_error(online, Trajectory(robot.stamps_s, robot.truths)).rmse_m < 2.0 * at_most_m


def test_commands_of_a_batch_become_one():
    some = mission_updates(True)[:3]
    writes = TagWrite("A", b"1"), TagWrite("B", b"2"), TagWrite("A", b"3")
    commands = [
        Command(0.1, 0.2, True, (writes[0],)),
        Command(0.3, -0.2, False, ()),
        Command(0.4, 0.5, False, writes[1:]),
    ]
    updates = [replace(update, command=command) for update, command in zip(some, commands, strict=False)]
    assert merge_commands(updates) == Command(0.4, 0.5, True, writes)
    assert merge_commands(updates[1:]) == Command(0.4, 0.5, False, writes[1:])
    assert merge_commands(updates[:1]) == commands[0]
