import argparse
from dataclasses import replace
from math import nan

import numpy as np
import pytest

from robots.config import AgentConfig, RadioConfig
from robots.estimation.radio.model import radio_for
from robots.sim.arguments import add_scenario_arguments, parse_radio_cut, scenario_from_arguments
from robots.sim.hostile import HostileConfig
from robots.sim.per_robot import parse_pairs
from robots.sim.scenario import RadioCut, ScenarioConfig, ScenarioError, build_world
from robots.sim.sensors import LaserConfig
from robots.sim.world import WorldError


def test_derived_values():
    config = ScenarioConfig(robots=3, minutes=2.0, seed=7, poses="truth")
    assert config.robot_ids == ("r1", "r2", "r3")
    assert (config.ticks_per_period, config.period_s, config.periods) == (4, 0.2, 600)
    assert (config.agent_of("r1").poses, config.agent_of("r1").seed) == ("truth", 7)
    assert replace(config, laser_hz=10.0).ticks_per_period == 2


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"robots": 0}, "robots 0 is out of range; give 1 to 100"),
        ({"minutes": nan}, "minutes nan"),
        ({"noise_level": 6}, "noise_level 6"),
        ({"seed": -1}, "seed -1"),
        ({"laser": LaserConfig(beams=5000)}, "laser.beams 5000"),
        ({"hostile": HostileConfig(smoke=-1)}, "hostile.smoke -1"),
        ({"radio_cuts": (RadioCut("r9", 0.0, 1.0),)}, "there is no robot r9"),
        ({"radio_cuts": (RadioCut("r1", 5.0, 1.0),)}, "has to end after it starts"),
        ({"tags": "lidar"}, "tags: 'lidar' is unknown; use one of near, uhf, node"),
        ({"environment": "cave"}, "environment: 'cave' is unknown; use one of grocery"),
        ({"tags_in_place": 3000}, "tags_in_place 3000"),
        ({"slam": (("r9", "odometry"),)}, "slam: there is no robot r9; robots are r1 to r4"),
        ({"slam": (("r1", "magic"),)}, "slam: 'magic' is unknown; use one of tag-graph"),
        ({"tag_bits": 1000}, "no chip has 1000; use 0 for no memory, or 512, 896"),
        ({"tags": "uhf", "agent_config": AgentConfig(map_memory=True)}, "2048 leave no room for maps"),
    ],
)
def test_what_cannot_be_played_is_named(changes, says):
    with pytest.raises(ScenarioError, match=says):
        ScenarioConfig(**changes)


@pytest.mark.parametrize(
    ("spec", "says"),
    [
        ("office:big", "area in square metres"),
        ("castle:100", "no 'castle' worlds"),
        ("none.yaml", "No such file"),
    ],
)
def test_a_map_that_is_none(spec, says):
    with pytest.raises((ScenarioError, WorldError), match=says):
        build_world(ScenarioConfig(map=spec))


def test_slip_makes_the_floor_slippery_and_nothing_else():
    plain = build_world(ScenarioConfig(map="office:100"))
    slippery = build_world(ScenarioConfig(map="office:100", slip=True))
    assert plain.grip is None
    assert slippery.grip is not None
    assert np.array_equal(plain.cells, slippery.cells)


def test_arguments_describe_a_scenario():
    parser = argparse.ArgumentParser()
    add_scenario_arguments(parser)
    assert scenario_from_arguments(parser.parse_args([])) == ScenarioConfig()
    words = (
        "--map open:80 --robots 2 --noise 1 --agent onboard --radio-cut r2:60:120 --glass 3 --laser-beams 90"
    )
    config = scenario_from_arguments(parser.parse_args(words.split()))
    assert (config.map, config.robots, config.noise_level, config.agent) == ("open:80", 2, 1, "onboard")
    assert config.radio_cuts == (RadioCut("r2", 60.0, 120.0),)
    assert (config.hostile.glass, config.laser.beams) == (3, 90)
    with pytest.raises(ScenarioError, match="ROBOT:FROM:TO"):
        parse_radio_cut("r2:60")


def test_each_robot_is_told_its_kind_of_slam_and_its_radio():
    slam = parse_pairs("slam", "r1=odometry, tag-graph")
    config = ScenarioConfig(robots=3, tags="node", environment="office2", slam=slam)
    assert [config.agent_of(robot_id).slam for robot_id in config.robot_ids] == [
        "odometry",
        "tag-graph",
        "tag-graph",
    ]
    assert config.agent_of("r2").radio == radio_for("node", "office2")
    assert replace(config, tags="near").agent_of("r2").radio == RadioConfig()
    own = AgentConfig(radio=RadioConfig(path_loss_exponent=1.4))
    assert replace(config, agent_config=own).agent_of("r2").radio == own.radio


def test_each_robot_explores_by_its_own_methods():
    config = ScenarioConfig(
        robots=3,
        explore=parse_pairs("explore", "r1=nearest,*=information-gain"),
        coordinate=(("r2", "hungarian"),),
        communication=(("*", "full"),),
    )
    plans = [config.agent_of(robot_id).planning for robot_id in config.robot_ids]
    assert [plan.explore for plan in plans] == ["nearest", "information-gain", "information-gain"]
    assert [plan.coordinate for plan in plans] == ["none", "hungarian", "none"]
    assert {plan.communication for plan in plans} == {"full"}
    with pytest.raises(ScenarioError, match="explore: 'astrology' is unknown; use one of "):
        replace(config, explore=(("r1", "astrology"),))
    with pytest.raises(ScenarioError, match="coordinate: there is no robot r9"):
        replace(config, coordinate=(("r9", "none"),))


def test_tags_hold_what_their_kind_holds_unless_told_otherwise():
    assert ScenarioConfig().memory_bits == 2048
    assert ScenarioConfig(tags="node").memory_bits > 2048
    assert ScenarioConfig(tags="node", tag_bits=0).memory_bits == 0


@pytest.mark.parametrize("text", ["", "r1=", "=odometry", "odometry,tag-graph", "r1=odometry,r1=tag-graph"])
def test_slam_that_is_none(text):
    with pytest.raises(ScenarioError, match="slam"):
        parse_pairs("slam", text)
