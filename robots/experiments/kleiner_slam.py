"""Kleiner 2006 figures 3 (a), (b) and 5: the tag graph's correction of odometry at five levels of noise.

Per run and level, on the same course and with the same draws:

* *odometry*: the wheels alone;
* *reckoning*: the wheels' distance with the heading the correction has, the inertial unit's or the wheels';
* *corrected*: the graph of eq. (5) solved once at the end, linearly (headings as measured) or by Gauss-Newton
  with the heading of the inertial unit; and on the small map, as in figure 5, without any: then it is solved
  at every known tag, as the agent does, for odometry alone is no start for a descent.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from robots.config import AgentConfig
from robots.estimation.graph.solve import solve
from robots.estimation.tag_graph.graph import TagGraph, graph_problem
from robots.experiments.buildings import GENERATED, Building, explore_all, plans, stage
from robots.experiments.course import Course
from robots.experiments.errors import NAMES, Judged, judge
from robots.experiments.experiment import Column, Experiment, Options, Row
from robots.experiments.kleiner_slam_plot import draw
from robots.experiments.parallel import in_parallel
from robots.experiments.reckoning import Reckoned, firm_floor, read_sensors, reckon
from robots.graph_report import GraphReport
from robots.se2 import Array
from robots.trajectory import edges_of, final_trajectory

LEVELS = (1, 2, 3, 4, 5)
COURSES = 2  # buildings of each size; run r is driven in the r-th of them, and round again
_FIGURES = {"small": "3a", "normal": "", "large": "3b"}


@dataclass(frozen=True, slots=True)
class Method:
    """A way to correct: the graph's method, and whether an inertial unit gives the heading."""

    name: str
    imu: bool

    @property
    def heading(self) -> str:
        """Whose heading is used."""
        return "IMU" if self.imu else "wheels"


LINEAR, NON_LINEAR, WITHOUT_IMU = (
    Method("linear", True), Method("gauss-newton", True), Method("gauss-newton", False),
)  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class _Drive:
    course: Course
    seed: int
    run: int
    levels: tuple[int, ...]
    methods: tuple[Method, ...]


@dataclass(frozen=True, slots=True)
class _Outcome:
    """One run at one level: wheels alone, and (method, before, after) of every correction."""

    level: int
    odometry: Judged
    corrections: tuple[tuple[Method, Judged, Judged], ...]


def measure(
    options: Options,
    buildings: Sequence[Building] = GENERATED,
    levels: tuple[int, ...] = LEVELS,
    minutes: float | None = None,
    searches: int = 2,
) -> list[Row]:
    """Return a row per building, method and level.

    Raises:
        ExperimentError: a building cannot be had.
    """
    count = min(COURSES, options.runs)
    trips, drives = count * len(buildings), options.runs * len(buildings)
    total = trips + drives
    courses = explore_all(
        buildings, count, options.seed, options.jobs, stage(options.progress, 0, total), searches, minutes
    )
    work = [
        _Drive(courses[building.name][run % count], options.seed, run, levels, _methods(building))
        for building in buildings
        for run in range(options.runs)
    ]
    outcomes = in_parallel(_drive, work, options.jobs, stage(options.progress, trips, total))
    rows: list[Row] = []
    for index, building in enumerate(buildings):
        ours = outcomes[index * options.runs : (index + 1) * options.runs]
        for position, method in enumerate(_methods(building)):
            for number, level in enumerate(levels):
                runs = [run[number] for run in ours]
                rows.append(
                    _row(building, courses[building.name], method, level)
                    | _errors([(run.odometry, *run.corrections[position][1:]) for run in runs])
                )
    return rows


def _methods(building: Building) -> tuple[Method, ...]:
    return (LINEAR, NON_LINEAR, WITHOUT_IMU) if building.name == "small" else (LINEAR, NON_LINEAR)


def _drive(drive: _Drive) -> list[_Outcome]:
    return [_level(drive, level) for level in drive.levels]


def _level(drive: _Drive, level: int) -> _Outcome:
    course = drive.course
    config = AgentConfig()
    config = replace(config, odometry=firm_floor(level, config.body))
    reckoned: dict[bool, Reckoned] = {}
    for imu in (True, False):  # the same draws for all levels and methods
        wheels, unit = (np.random.default_rng([drive.seed, drive.run, stream]) for stream in (1, 2))
        readings = read_sensors(course, level, config, wheels, unit if imu else None)
        reckoned[imu] = reckon(course, readings, config)
    graphs = {imu: each.graph(online=False) for imu, each in reckoned.items()}
    before = {imu: _judged(course, each, each.poses, graphs[imu].report()) for imu, each in reckoned.items()}
    corrections = tuple(
        (method, before[method.imu], _corrected(course, reckoned[method.imu], graphs[method.imu], method))
        for method in drive.methods
    )
    return _Outcome(level, before[False], corrections)


def _corrected(course: Course, reckoned: Reckoned, graph: TagGraph, method: Method) -> Judged:
    if not method.imu:
        graph = reckoned.graph(online=True)
    solution = solve(graph_problem(graph.report()), "linear" if method == LINEAR else "gauss-newton")
    report = replace(graph.report(), poses=solution.poses, tags=solution.tags)
    final = final_trajectory(reckoned.steps, report.poses, edges_of(report))
    return _judged(course, reckoned, final.poses, report)


def _judged(course: Course, reckoned: Reckoned, poses: Array, graph: GraphReport) -> Judged:
    order = np.array([int(tag_id) for tag_id in graph.tag_ids], np.int64)
    return judge(course, reckoned.ticks, poses, graph.tags, order, reckoned.world_from_map)


def _row(building: Building, courses: Sequence[Course], method: Method, level: int) -> Row:
    def mean(values: Sequence[float]) -> float:
        return float(np.mean(values))

    return {
        "map": building.name,
        "paper_area_m2": building.paper_area_m2,
        "area_m2": mean([course.area_m2 for course in courses]),
        "distance_m": mean([course.distance_m for course in courses]),
        "tags": mean([len(course.tags_m) for course in courses]),
        "tags_read_again": mean([course.repeats for course in courses]),
        "explored": all(course.explored for course in courses),
        "method": method.name,
        "heading": method.heading,
        "noise_level": level,
        "paper_figure": _FIGURES.get(building.name, "") if method.imu else "5",
        "paper_error_m": None,  # printed as curves only
    }


def _errors(runs: Sequence[tuple[Judged, Judged, Judged]]) -> Row:
    """Return means and deviations over the runs of (odometry, reckoning, corrected)."""
    row: Row = {"runs": len(runs)}
    for name in NAMES:
        for suffix, kind in (("", "aligned"), ("_from_start", "from_start")):
            means = {}
            for position, stage_name in enumerate(("odometry", "reckoning", "corrected")):
                errors = np.array([getattr(getattr(run[position], kind), f"{name}_m") for run in runs])
                means[stage_name] = float(errors.mean())
                row[f"{stage_name}_{name}{suffix}_m"] = means[stage_name]
                row[f"{stage_name}_{name}{suffix}_sd_m"] = float(errors.std())
            row[f"{name}{suffix}_times_smaller"] = means["odometry"] / means["corrected"]
            row[f"{name}{suffix}_times_smaller_than_reckoning"] = means["reckoning"] / means["corrected"]
    ratios = [run[0].aligned.trajectory_m / run[2].aligned.trajectory_m for run in runs]
    row["runs_5_times_smaller_share"] = float(np.mean(np.array(ratios) >= 5.0))
    rescaled = np.array([run[2].rescaled_m for run in runs])
    row["corrected_trajectory_rescaled_m"] = float(rescaled.mean())
    row["corrected_trajectory_rescaled_sd_m"] = float(rescaled.std())
    return row


def _plot(rows: list[Row], path: Path) -> None:
    draw(rows, path)


_COLUMNS = (
    Column("map", "map"),
    Column("method", "method"),
    Column("heading", "heading"),
    Column("noise", "noise_level"),
    Column("wheels alone, path m", "odometry_trajectory_m", "odometry_trajectory_sd_m"),
    Column("reckoned, path m", "reckoning_trajectory_m", "reckoning_trajectory_sd_m"),
    Column("corrected, path m", "corrected_trajectory_m", "corrected_trajectory_sd_m"),
    Column("x smaller", "trajectory_times_smaller", digits=1),
    Column("corrected, tags m", "corrected_tags_m", "corrected_tags_sd_m"),
    Column("x smaller", "tags_times_smaller", digits=1),
    Column("corrected, map m", "corrected_map_m", "corrected_map_sd_m"),
    Column("x smaller", "map_times_smaller", digits=1),
    Column("path but for scale, m", "corrected_trajectory_rescaled_m", "corrected_trajectory_rescaled_sd_m"),
    Column("paper", "paper_figure"),
)
_NOTES = (
    "Root mean squares after rigid alignment, mean ± deviation over the runs; the JSON has them from the"
    " fixed start too. 'x smaller' compares with the wheels alone.",
    "Reckoned: the wheels' distance along the heading named. But for scale: what remains when the scale may"
    " be chosen. Wheels that roll long by a constant share make a map too large by it, and no tag tells.",
    "The paper prints curves and no numbers (figures named in the last column), so none stand beside ours.",
)

EXPERIMENT = Experiment(
    name="kleiner-slam",
    summary="The tag graph's correction of odometry, linear and not, at five noise levels on three maps.",
    paper="Kleiner 2006, section VI, figures 3 (a), (b) and 5",
    default_runs=100,
    run=measure,
    plot=_plot,
    columns=_COLUMNS,
    notes=_NOTES,
)


def measure_plans(options: Options) -> list[Row]:
    """Do the same on plans of real buildings. Raises ExperimentError where they are missing."""
    return measure(options, plans(options.data))


ON_PLANS = replace(
    EXPERIMENT,
    name="kleiner-slam-plans",
    summary="The same on plans of real buildings (--data DIR with maps/office-280, -590 and -1275.yaml).",
    run=measure_plans,
)
