"""What an agent does, step by step and on a whole mission."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np
import pytest

from robots.agent import RobotAgent, merge_commands
from robots.config import AgentConfig, BodyConfig
from robots.estimation.odometry import motion_mean
from robots.evaluation import absolute_error
from robots.mapping.submap import unpack
from robots.se2 import Pose2, wrap
from robots.sim.runner import run
from robots.sim.scenario import ScenarioConfig
from robots.sim.sensors import LaserConfig
from robots.sim.solution import solve
from robots.trajectory import Trajectory
from robots.types import (
    Command,
    Displacement,
    DistanceTurn,
    HeatReading,
    ImuReading,
    Observation,
    TagWrite,
)
from tests.robots.recorded import driving, mission_log, mission_updates, replayed

GOOD = DistanceTurn(0.1, 0.0)


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
