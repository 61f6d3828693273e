"""Ziparo 2007 table 2: EKF-SLAM over UHF tags that the robot drops, in buildings B1 to B4.

One robot with encoders of noise level 1 explores about 500 m2 with two slippery patches, led by its true
pose, and drops a tag wherever none is within a metre; the same way is then heard by the radios of four kinds
of building and estimated from wheels, inertial unit and radio alone, without the laser. Cross-track error is
orthogonal to the true heading, along-track error along it (the paper's ATE).

Which four kinds of Seidel and Rappaport 1992 the paper took is not printed; by the size of its errors and of
their sigma / n we take B1 grocery store, B2 retail store, B3 office 1 and B4 office 2, all on one floor.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from robots.agent import RobotAgent
from robots.config import AgentConfig, DeploymentConfig, PlanningConfig
from robots.estimation.radio.model import radio_for
from robots.estimation.slam import begin_slam
from robots.estimation.slip.detector import SlipDetector
from robots.experiments.course import as_moved
from robots.experiments.experiment import Column, Experiment, ExperimentError, Options, Row
from robots.experiments.parallel import in_parallel
from robots.experiments.ziparo_table2_plot import draw
from robots.se2 import Array, Pose2
from robots.sim.channel import Channel
from robots.sim.hostile import HostileConfig
from robots.sim.receivers import Receiver
from robots.sim.scenario import ODOMETRY_HZ, ScenarioConfig, ScenarioError
from robots.sim.simulation import Order, Simulation
from robots.sim.world import WorldError
from robots.types import Command, Observation, TagSighting

BUILDINGS = {"B1": "grocery", "B2": "retail", "B3": "office1", "B4": "office2"}
MEASURES = ("cross_track_m", "along_track_m", "cartesian_m")
PAPER = {  # mean, deviation, maximum
    "B1": {
        "cross_track_m": (0.3, 0.2, 1.0),
        "along_track_m": (0.3, 0.2, 1.1),
        "cartesian_m": (0.4, 0.2, 1.2),
    },
    "B2": {
        "cross_track_m": (0.4, 0.2, 1.0),
        "along_track_m": (0.4, 0.5, 0.9),
        "cartesian_m": (0.6, 0.2, 1.2),
    },
    "B3": {
        "cross_track_m": (0.4, 0.3, 1.2),
        "along_track_m": (0.4, 0.3, 1.3),
        "cartesian_m": (0.7, 0.3, 1.3),
    },
    "B4": {
        "cross_track_m": (0.3, 0.2, 0.7),
        "along_track_m": (0.3, 0.2, 0.8),
        "cartesian_m": (0.4, 0.2, 0.8),
    },
}
_ROBOT, _MAP, _NOISE_LEVEL = "r1", "office:500", 1
_LASER_HZ = 2.5
_SLIPPERY = 2  # patches of floor: "driving through heterogeneous surfaces"
_SPACING_M = 1.0  # "we take care of having the RFIDs at one meter distance from each other"
_MAGAZINE = DeploymentConfig(magazine=1000)


@dataclass(frozen=True, slots=True)
class Setting:
    """One exploration: the building, what is drawn in it, and how long it may take."""

    seed: int
    map: str = _MAP
    minutes: float = 30.0


@dataclass(frozen=True, slots=True, eq=False)
class Way:
    """What was truly driven, ``poses`` (n, 3) in the map frame, what wheels and inertial unit told of it.

    ``heard``: the signals at each observation, by the kind of building; ``tags`` how many were dropped.
    """

    log: tuple[Observation, ...]
    commands: tuple[Command, ...]
    poses: Array
    heard: dict[str, tuple[tuple[TagSighting, ...], ...]]
    tags: int


def measure(options: Options) -> list[Row]:
    """Return a row per kind of building.

    Raises:
        ExperimentError: a process was killed.
    """
    seeds = [int(np.random.SeedSequence([options.seed, k]).generate_state(1)[0]) for k in range(options.runs)]
    runs = in_parallel(run, [Setting(seed) for seed in seeds], options.jobs, options.progress)
    return [_row(name, [each[name] for each in runs]) for name in BUILDINGS]


def run(setting: Setting) -> dict[str, dict[str, float]]:
    """Explore once; return the errors in each kind of building.

    Raises:
        ExperimentError: the building cannot be had.
    """
    try:
        way = explore(setting)
    except (WorldError, ScenarioError) as error:
        raise ExperimentError(str(error)) from error
    reckoned = _errors(way, estimate(way, "odometry", "open", setting.seed))
    steps = np.diff(way.poses[:, :2], axis=0)
    told = {
        "odometry_cartesian_m": reckoned["cartesian_m"],
        "distance_m": float(np.hypot(steps[:, 0], steps[:, 1]).sum()),
        "tags": float(way.tags),
    }
    return {
        name: _errors(way, estimate(way, "ekf", kind, setting.seed)) | told
        for name, kind in BUILDINGS.items()
    }


def explore(setting: Setting) -> Way:
    """Let a robot that knows its true pose explore a building and drop tags; log what another would get."""
    scenario = ScenarioConfig(
        map=setting.map,
        robots=1,
        minutes=setting.minutes,
        seed=setting.seed,
        hostile=HostileConfig(slippery=_SLIPPERY),
        noise_level=_NOISE_LEVEL,
        victims=0,
        laser_hz=_LASER_HZ,
        agent_config=AgentConfig(deployment=_MAGAZINE, planning=PlanningConfig(replan_every_s=2.0)),
    )
    simulation = Simulation(scenario)
    radios = {kind: _receiver(simulation, kind, number) for number, kind in enumerate(BUILDINGS.values())}
    agent = RobotAgent(_ROBOT, replace(scenario.agent_of(_ROBOT), poses="truth"))
    log: list[Observation] = []
    commands: list[Command] = []
    command = Command()
    heard: dict[str, list[tuple[TagSighting, ...]]] = {kind: [] for kind in radios}
    before = simulation.truth(_ROBOT)
    for period in range(scenario.periods):
        observations = simulation.advance()[_ROBOT]
        for observation in observations:
            pose = Pose2.from_array(simulation.track[observation.seq][0])
            for kind, radio in radios.items():
                heard[kind].append(radio.sightings(pose, observation.stamp_s, 1.0 / ODOMETRY_HZ))
            commands.append(command)
            log.append(replace(observation, scan=None, beams=(), heat=(), tag_sightings=()))
        here = simulation.truth(_ROBOT)
        moved, before = before.between(here), here
        update = agent.step(as_moved(observations, period, moved))
        away_m = np.hypot(*(simulation.tags.places_m - (here.x, here.y)).T)
        drop = bool(away_m.min(initial=np.inf) >= _SPACING_M)
        command = replace(update.command, drop_tag=drop)
        simulation.apply({_ROBOT: Order(command)})
        if update.activity == "done":
            break
    map_from_world = simulation.world_from_map(_ROBOT).inverse()
    poses = [(map_from_world @ Pose2.from_array(row[0])).as_array() for row in simulation.track]
    return Way(
        tuple(log),
        tuple(commands),
        np.array(poses),
        {kind: tuple(signals) for kind, signals in heard.items()},
        len(simulation.tags.tags),
    )


def estimate(way: Way, slam: str, environment: str, seed: int) -> Array:
    """Return the poses, (n, 3) in the map frame, as a robot without a laser estimates them on the way."""
    scenario = ScenarioConfig(
        robots=1, seed=seed, noise_level=_NOISE_LEVEL, tags="uhf", environment=environment
    )
    config = replace(scenario.agent_of(_ROBOT), radio=radio_for("uhf", environment))
    config = replace(config, slam="ekf" if slam == "ekf" else "odometry")
    first = way.log[0]
    robot = begin_slam(_ROBOT, config, first.stamp_s, first.imu)
    slip = SlipDetector("extended")
    signals = way.heard.get(environment, ((),) * len(way.log))
    poses = []
    for observation, command, sightings in zip(way.log, way.commands, signals, strict=True):
        assert observation.imu is not None
        slips = slip.observe(observation.stamp_s, observation.odometry, observation.imu, command)
        robot.predict(observation, observation is not first, slips or observation.bumper, slip.share)
        robot.pass_tags(replace(observation, tag_sightings=sightings))
        poses.append(robot.pose.as_array())
    return np.array(poses)


def _receiver(simulation: Simulation, environment: str, number: int) -> Receiver:
    seed = simulation.config.seed
    channel = Channel(simulation.world, simulation.tags, "uhf", radio_for("uhf", environment), seed)
    rng = np.random.default_rng([seed, 30, number])
    return Receiver(channel, simulation.tags, simulation.life, 0.0, rng)


def _errors(way: Way, poses: Array) -> dict[str, float]:
    """Return mean, deviation and maximum of the errors over the way."""
    off = poses[:, :2] - way.poses[:, :2]
    c, s = np.cos(way.poses[:, 2]), np.sin(way.poses[:, 2])
    values = {
        "cross_track_m": np.abs(c * off[:, 1] - s * off[:, 0]),
        "along_track_m": np.abs(c * off[:, 0] + s * off[:, 1]),
        "cartesian_m": np.hypot(off[:, 0], off[:, 1]),
    }
    errors: dict[str, float] = {}
    for name, value in values.items():
        stem = name.removesuffix("_m")
        errors |= {name: float(value.mean()), f"{stem}_sd_m": float(value.std())}
        errors[f"{stem}_max_m"] = float(value.max())
    return errors


def _row(name: str, runs: list[dict[str, float]]) -> Row:
    row: Row = {"building": f"{name} ({BUILDINGS[name]})", "runs": len(runs)}
    for key in runs[0]:
        values = np.array([each[key] for each in runs])
        row[key] = float(values.mean())
        row[f"{key}_deviation"] = float(values.std(ddof=1)) if len(runs) > 1 else None
    row["cartesian_worst_run_m"] = max(each["cartesian_m"] for each in runs)
    for measure_, (mean, deviation, maximum) in PAPER[name].items():
        stem = measure_.removesuffix("_m")
        row[f"paper_{measure_}"] = mean
        row[f"paper_{stem}_sd_m"], row[f"paper_{stem}_max_m"] = deviation, maximum
    return row


def _columns() -> tuple[Column, ...]:
    columns = [Column("building", "building"), Column("tags", "tags", digits=0)]
    for name, title in zip(MEASURES, ("cross-track", "along-track", "Cartesian"), strict=True):
        stem = name.removesuffix("_m")
        columns += [
            Column(f"{title} m", name, f"{name}_deviation"),
            Column("paper", f"paper_{name}", digits=1),
            Column("sd", f"{stem}_sd_m"),
            Column("max", f"{stem}_max_m"),
        ]
    columns.append(Column("odometry", "odometry_cartesian_m", "odometry_cartesian_m_deviation"))
    return tuple(columns)


EXPERIMENT = Experiment(
    name="ziparo-table2",
    summary="EKF-SLAM over UHF tags in four kinds of building",
    paper="Ziparo 2007, table 2",
    default_runs=5,
    run=measure,
    plot=draw,
    columns=_columns(),
    notes=(
        "Means over the way, then over the runs (± their deviation); sd and max over the way, mean of runs.",
        "Which kinds of building the paper took it does not print: B1 grocery store, B2 retail store,"
        " B3 office 1 and B4 office 2 are assumed, and so are the robot's wheels and floor.",
        "No laser takes part in the estimate; odometry: wheels and inertial unit alone, same way.",
    ),
)
