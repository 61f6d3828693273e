"""A scenario from command-line arguments."""

from __future__ import annotations

import argparse
from math import radians
from typing import get_args

from robots.config import AgentConfig, PlanningConfig
from robots.estimation.radio.model import ENVIRONMENTS, TagHardware
from robots.exploration.methods import KNOWN
from robots.sim.hostile import HostileConfig
from robots.sim.per_robot import parse_pairs
from robots.sim.scenario import (
    SLAM_KINDS,
    RadioCut,
    ScenarioConfig,
    ScenarioError,
    SilenceConfig,
)
from robots.sim.sensors import LaserConfig


def add_scenario_arguments(parser: argparse.ArgumentParser) -> None:
    """Add an argument for everything in a scenario that a person may want to choose."""
    usual = ScenarioConfig()
    parser.add_argument(
        "--map", default=usual.map, help="FILE.yaml, office:AREA or open:AREA (square metres)"
    )
    parser.add_argument("--robots", type=int, default=usual.robots)
    parser.add_argument("--minutes", type=float, default=usual.minutes)
    parser.add_argument("--seed", type=int, default=usual.seed)
    parser.add_argument("--poses", choices=("slam", "truth"), default=usual.poses)
    parser.add_argument("--slip", action="store_true", help="slippery patches on the floor")
    parser.add_argument("--noise", type=int, default=usual.noise_level, help="odometry noise level, 0 to 5")
    parser.add_argument("--victims", type=int, default=usual.victims)
    parser.add_argument("--start", choices=("same", "spread"), default=usual.start)
    parser.add_argument("--agent", choices=("server", "onboard"), default=usual.agent)
    parser.add_argument(
        "--radio-cut", action="append", default=[], metavar="ROBOT:FROM:TO", help="seconds; may be repeated"
    )
    parser.add_argument("--silence-policy", choices=("hold", "go_on"), default=usual.silence.policy)
    parser.add_argument("--silence-after", type=float, default=usual.silence.after_s, metavar="SECONDS")
    parser.add_argument("--no-imu", action="store_true")
    parser.add_argument("--laser-beams", type=int, default=usual.laser.beams)
    parser.add_argument("--laser-range", type=float, default=usual.laser.range_max_m, metavar="METRES")
    parser.add_argument("--laser-view", type=float, default=240.0, metavar="DEGREES")
    parser.add_argument("--laser-hz", type=float, default=usual.laser_hz)
    parser.add_argument("--sonars", type=int, default=usual.sonars)
    parser.add_argument("--infrareds", type=int, default=usual.infrareds)
    parser.add_argument("--tags", choices=get_args(TagHardware), default=usual.tags)
    parser.add_argument("--environment", choices=tuple(ENVIRONMENTS), default=usual.environment)
    parser.add_argument("--tags-in-place", type=int, default=usual.tags_in_place, metavar="COUNT")
    parser.add_argument("--tag-bits", type=int, default=usual.tag_bits)
    parser.add_argument("--slam", metavar="[ROBOT=]KIND,...", help=f"of {', '.join(SLAM_KINDS)}")
    parser.add_argument("--memory", choices=("none", "tags"), default="none", help="maps left in tags")
    parser.add_argument(
        "--local-map", type=float, default=0.0, metavar="METRES", help="plan on a square that goes along"
    )
    for name, known in KNOWN.items():
        parser.add_argument(f"--{name}", metavar="[ROBOT=]NAME,...", help=f"of {', '.join(known)}")
    parser.add_argument("--radio-range", type=float, default=usual.team_radio_m, metavar="METRES")
    for name in HostileConfig.__slots__:
        option = f"--{name.replace('_', '-')}"
        parser.add_argument(option, type=int, default=getattr(usual.hostile, name), metavar="COUNT")


def scenario_from_arguments(arguments: argparse.Namespace) -> ScenarioConfig:
    """Return the scenario the arguments describe. Raises ScenarioError for one that cannot be played."""
    return ScenarioConfig(
        map=arguments.map,
        robots=arguments.robots,
        minutes=arguments.minutes,
        seed=arguments.seed,
        poses=arguments.poses,
        slip=arguments.slip,
        noise_level=arguments.noise,
        victims=arguments.victims,
        start=arguments.start,
        agent=arguments.agent,
        radio_cuts=tuple(parse_radio_cut(text) for text in arguments.radio_cut),
        silence=SilenceConfig(arguments.silence_after, arguments.silence_policy),
        laser=LaserConfig(radians(arguments.laser_view), arguments.laser_beams, arguments.laser_range),
        laser_hz=arguments.laser_hz,
        hostile=HostileConfig(**{name: getattr(arguments, name) for name in HostileConfig.__slots__}),
        imu=not arguments.no_imu,
        sonars=arguments.sonars,
        infrareds=arguments.infrareds,
        tags=arguments.tags,
        environment=arguments.environment,
        tags_in_place=arguments.tags_in_place,
        tag_bits=arguments.tag_bits,
        team_radio_m=arguments.radio_range,
        slam=parse_pairs("slam", arguments.slam) if arguments.slam else (),
        explore=parse_pairs("explore", arguments.explore) if arguments.explore else (),
        coordinate=parse_pairs("coordinate", arguments.coordinate) if arguments.coordinate else (),
        communication=parse_pairs("communication", arguments.communication)
        if arguments.communication
        else (),
        agent_config=AgentConfig(
            planning=PlanningConfig(local_map_m=arguments.local_map), map_memory=arguments.memory == "tags"
        ),
    )


def parse_radio_cut(text: str) -> RadioCut:
    """Return the cut of ``r2:60:120`` (robot, from, to in seconds). Raises ScenarioError."""
    try:
        robot_id, start, end = text.split(":")
        return RadioCut(robot_id, float(start), float(end))
    except ValueError:
        raise ScenarioError(f"radio cut {text!r}: give ROBOT:FROM:TO in seconds, as in r2:60:120") from None
