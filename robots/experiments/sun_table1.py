"""Sun 2009 table 1: odometry, RSLAM alone, and RSLAM with the maps that earlier robots left, in six worlds.

The paper's worlds are not to be had: ours are generated with their free floor, offices for the indoor ones
and halls with pillars and debris for the others, with as many nodes and robots. How far the robots drove is
not printed: ours drive 500 m, which is a run of the competition, 20 minutes, at 0.4 m/s. Odometry is as bad
as in the paper's column on average.
The radio's path loss is measured in another building of the kind, as the paper's was where it was tested.
Every robot knows where it starts, in one frame, as in the competition; it has no compass, which the paper's
robots had. What it leaves in nodes is a batch solve of its own measurements (``LeftMap``).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robots.config import RadioConfig
from robots.experiments.experiment import Column, Experiment, Options, Row
from robots.experiments.parallel import in_parallel
from robots.experiments.radio_course import RadioCourse, RadioWorld, calibrated, measured, reckoned
from robots.experiments.sun_plot import draw
from robots.experiments.sun_slam import Memories, leave_map, run_slam
from robots.se2 import Array
from robots.sim.generate import RESOLUTION_M, generate
from robots.sim.world import world_of

_LENGTH_M = 500.0


@dataclass(frozen=True, slots=True)
class PaperRobot:
    """What the paper reports of one robot: mean errors in metres, and how far it drove here."""

    odometry_m: float
    single_m: float
    multi_m: float
    length_m: float


@dataclass(frozen=True, slots=True)
class PaperWorld:
    """A world of the paper, and what ours is generated as."""

    name: str
    kind: str
    area_m2: float
    nodes: int
    robots: tuple[PaperRobot, ...]


def _world(name: str, kind: str, area: float, nodes: int, *rows: tuple[float, float, float]) -> PaperWorld:
    return PaperWorld(name, kind, area, nodes, tuple(PaperRobot(*row, _LENGTH_M) for row in rows))


WORLDS = (
    _world("RC07-Plywood", "office", 109.0, 7, (4.7, 0.3, 0.3), (3.5, 0.8, 0.6)),
    _world("RC07-Mapping", "office", 250.0, 8, (7.0, 0.5, 0.5), (4.1, 0.6, 0.3)),
    _world("RC06-Day4a", "office", 846.0, 14, (8.2, 0.4, 0.4), (13.2, 2.0, 0.8)),
    _world("RC07-Factory", "open", 1975.0, 58, (17.4, 2.1, 2.1), (28.2, 4.6, 1.6)),
    _world("RC07-Mobility", "open", 3819.0, 58, (12.9, 1.4, 1.4), (13.3, 1.7, 1.3)),
    _world(
        "RC06-Day4b",
        "open",
        4529.0,
        60,
        (5.0, 0.5, 0.5),
        (6.7, 1.2, 0.3),
        (5.2, 0.4, 0.1),
        (12.7, 0.8, 0.2),
    ),
)


@dataclass(frozen=True, slots=True)
class Trial:
    """One run of one world: the noise level of each robot's odometry is known already."""

    world: PaperWorld
    index: int
    seed: int
    run: int
    levels: tuple[float, ...]


def measure(options: Options, worlds: tuple[PaperWorld, ...] = WORLDS) -> list[Row]:
    """Return a row for each robot of each world."""
    rows: list[Row] = []
    trials = [
        Trial(world, index, options.seed, run, levels)
        for index, world in enumerate(worlds)
        for levels in [_levels(world, index, options)]
        for run in range(options.runs)
    ]
    errors = in_parallel(trial, trials, options.jobs, options.progress)
    for index, world in enumerate(worlds):
        found = np.array([e for t, e in zip(trials, errors, strict=True) if t.index == index])
        rows += [_row(world, number, found[:, number]) for number in range(len(world.robots))]
    return rows


def trial(item: Trial) -> Array:
    """Return mean and deviation over its way of the error of odometry, single and multi, (robots, 3, 2)."""
    memories: Memories = {}
    found = np.empty((len(item.world.robots), 3, 2))
    courses = _courses(item.world, item.index, item.seed, item.run)
    radio = _surveyed(item.world, item.index, item.seed, item.run)
    for number, course in enumerate(courses):
        seed = _seed(item.seed, item.index, item.run, number)
        told = measured(course, item.levels[number], np.random.default_rng(seed))
        robot = f"r{number + 1}", course, told, item.levels[number], radio, seed
        single = run_slam(*robot, {})
        multi = run_slam(*robot, memories) if number else single
        if number < len(courses) - 1:
            leave_map(*robot, memories)
        for kind, places in enumerate((reckoned(course, told), single, multi)):
            off = np.hypot(*(places - course.poses[:, :2]).T)
            found[number, kind] = off.mean(), off.std()
    return found


def _levels(world: PaperWorld, index: int, options: Options) -> tuple[float, ...]:
    """Return how noisy each robot's odometry has to be for the paper's error, on average over the runs."""
    runs = range(max(options.runs, 3))
    by_run = [_courses(world, index, options.seed, run, listen=False) for run in runs]
    return tuple(
        calibrated(
            [courses[number] for courses in by_run],
            [_seed(options.seed, index, run, number) for run in runs],
            robot.odometry_m,
        )
        for number, robot in enumerate(world.robots)
    )


def _courses(world: PaperWorld, index: int, seed: int, run: int, listen: bool = True) -> list[RadioCourse]:
    air = _air(world, np.random.default_rng([seed, index, run]))
    ways = [np.random.default_rng([seed, index, run, number]) for number in range(len(world.robots))]
    return [air.drive(robot.length_m, way, listen) for robot, way in zip(world.robots, ways, strict=True)]


def _surveyed(world: PaperWorld, index: int, seed: int, run: int) -> RadioConfig:
    """Return the radio as it was measured in another building of the kind."""
    random = np.random.default_rng([seed, index, run, len(world.robots)])
    return _air(world, random).survey(random)


def _air(world: PaperWorld, random: np.random.Generator) -> RadioWorld:
    if world.kind == "ground":
        side = round((world.area_m2**0.5 + 1.0) / RESOLUTION_M)
        solid = np.ones((side, side), bool)
        solid[5:-5, 5:-5] = False
        place = world_of(solid, RESOLUTION_M)
    else:
        place = generate(world.kind, world.area_m2, random)
    return RadioWorld(place, world.nodes, int(random.integers(2**31)), random)


def _seed(seed: int, index: int, run: int, number: int) -> int:
    return int(np.random.SeedSequence([seed, index, run, number, 1]).generate_state(1)[0])


def _row(world: PaperWorld, number: int, errors: Array) -> Row:
    robot = world.robots[number]
    means, spreads = errors[:, :, 0].mean(axis=0), errors[:, :, 1].mean(axis=0)
    row: Row = {
        "world": world.name,
        "area_m2": world.area_m2,
        "nodes": world.nodes,
        "robot": number + 1,
        "runs": len(errors),
        "length_m": robot.length_m,
    }
    for kind, name in enumerate(("odometry", "single", "multi")):
        row[f"{name}_m"], row[f"{name}_sd_m"] = float(means[kind]), float(spreads[kind])
    row["worst_multi_m"] = float(errors[:, 2, 0].max())
    row["multi_by_single"] = float(means[2] / means[1]) if number else None
    row["paper_odometry_m"], row["paper_single_m"] = robot.odometry_m, robot.single_m
    return row | {
        "paper_multi_m": robot.multi_m,
        "paper_multi_by_single": robot.multi_m / robot.single_m if number else None,
    }


COLUMNS = (
    Column("world", "world"),
    Column("robot", "robot"),
    Column("nodes", "nodes"),
    Column("odometry m", "odometry_m", "odometry_sd_m"),
    Column("single m", "single_m", "single_sd_m"),
    Column("multi m", "multi_m", "multi_sd_m"),
    Column("multi / single", "multi_by_single"),
    Column("paper: odometry", "paper_odometry_m", digits=1),
    Column("single", "paper_single_m", digits=1),
    Column("multi", "paper_multi_m", digits=1),
    Column("multi / single", "paper_multi_by_single"),
)
NOTES = (
    "Mean distance from the truth online, from the known start, ± its deviation over the way; mean of runs.",
    "Odometry's noise was chosen for the paper's column; the others follow from the radio and the filter.",
)

EXPERIMENT = Experiment(
    name="sun-table1",
    summary="Odometry, RSLAM alone and RSLAM with the maps others left in nodes, in six worlds.",
    paper="Sun 2009, table 1",
    default_runs=5,
    run=measure,
    plot=draw,
    columns=COLUMNS,
    notes=(
        *NOTES,
        "Worlds are generated with the paper's floor, nodes and robots; its maps are not to be had.",
    ),
)
