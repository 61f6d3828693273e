"""Kleiner 2006 section VI: how long the correction of a map takes, small, normal and large.

Processor time of this process, one thread, kernels compiled: building the problem from the tag graph and
solving it, from odometry to the corrected map. Only the courses before are spread over processes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from time import process_time
from typing import Literal

import numpy as np

from robots.config import AgentConfig
from robots.estimation.graph.solve import solve
from robots.estimation.tag_graph.graph import TagGraph, graph_problem
from robots.experiments import plotting
from robots.experiments.buildings import GENERATED, Building, explore_all, stage
from robots.experiments.course import Course
from robots.experiments.experiment import Column, Experiment, Options, Row, finite
from robots.experiments.reckoning import firm_floor, read_sensors, reckon

PAPER_S = {"small": 0.42, "normal": 2.19, "large": 13.87}  # Pentium 4, 2.4 GHz
_LEVEL = 3
_METHODS: tuple[Literal["linear", "gauss-newton"], ...] = ("linear", "gauss-newton")


def measure(
    options: Options,
    buildings: Sequence[Building] = GENERATED,
    minutes: float | None = None,
    searches: int = 2,
) -> list[Row]:
    """Return a row per building and method; each run corrects the odometry of other draws.

    Raises:
        ExperimentError: a building cannot be had.
    """
    total = len(buildings) * (1 + options.runs)
    courses = explore_all(
        buildings, 1, options.seed, options.jobs, stage(options.progress, 0, total), searches, minutes
    )
    rows: list[Row] = []
    for index, building in enumerate(buildings):
        (course,) = courses[building.name]
        seconds: dict[str, list[float]] = {method: [] for method in _METHODS}
        report = stage(options.progress, len(buildings) + index * options.runs, total)
        for run in range(options.runs):
            graph = _graph(course, options.seed, run)
            for method in _METHODS:
                _correct(graph, method)  # warm: kernels compiled, memory at hand
                began = process_time()
                _correct(graph, method)
                seconds[method].append(process_time() - began)
            report(run + 1, 0)
        rows += [_row(building, course, graph, method, seconds[method]) for method in _METHODS]
    return rows


def _correct(graph: TagGraph, method: Literal["linear", "gauss-newton"]) -> None:
    solve(graph_problem(graph.report()), method)


def _graph(course: Course, seed: int, run: int) -> TagGraph:
    config = AgentConfig()
    config = replace(config, odometry=firm_floor(_LEVEL, config.body))
    wheels, imu = (np.random.default_rng([seed, run, stream]) for stream in (1, 2))
    return reckon(course, read_sensors(course, _LEVEL, config, wheels, imu), config).graph(online=False)


def _row(building: Building, course: Course, graph: TagGraph, method: str, seconds: list[float]) -> Row:
    report = graph.report()
    mean_s = float(np.mean(seconds))
    paper_s = PAPER_S.get(building.name)
    return {
        "map": building.name,
        "paper_area_m2": building.paper_area_m2,
        "area_m2": course.area_m2,
        "method": method,
        "vertices": len(report.poses) + len(report.tags),
        "tags": len(report.tags),
        "edges": len(report.edge_pairs) + len(report.sighting_pairs),
        "runs": len(seconds),
        "time_s": mean_s,
        "time_sd_s": float(np.std(seconds)),
        "time_ms": 1e3 * mean_s,
        "time_sd_ms": 1e3 * float(np.std(seconds)),
        "paper_time_s": paper_s,
        "times_faster": None if paper_s is None else paper_s / mean_s,
    }


def draw(rows: list[Row], path: Path) -> None:
    """Draw computing time over the area of the map, ours and the paper's."""
    marks = {"linear": (plotting.BLUE, "o"), "gauss-newton": (plotting.GREEN, "s")}
    title = "Computing time of the correction (Kleiner 2006, section VI)"
    with plotting.figure(path, rows=1, columns=1, width_in=6.0, height_in=4.2, title=title) as axes:
        panel = axes[0][0]
        printed = [row for row in rows if row["method"] == "linear" and row["paper_time_s"] is not None]
        panel.plot(
            [finite(row, "paper_area_m2") for row in printed],
            [finite(row, "paper_time_s") for row in printed],
            color=plotting.BLACK, marker="D", linestyle="--", label="paper: Pentium 4, 2.4 GHz",
        )  # fmt: skip
        for method, (colour, marker) in marks.items():
            ours = [row for row in rows if row["method"] == method]
            panel.errorbar(
                [finite(row, "area_m2") for row in ours],
                [finite(row, "time_s") for row in ours],
                [finite(row, "time_sd_s") for row in ours],
                color=colour, marker=marker, capsize=3.0, label=f"tag graph, {method}",
            )  # fmt: skip
        for row in rows:
            if row["method"] == "linear":
                panel.annotate(
                    f"{finite(row, 'vertices'):.0f} vertices, {finite(row, 'edges'):.0f} edges",
                    (finite(row, "area_m2"), finite(row, "time_s")),
                    xytext=(0, -16), textcoords="offset points", ha="center", fontsize=8, color=plotting.GREY,
                )  # fmt: skip
        panel.set_yscale("log")
        panel.margins(x=0.25, y=0.15)
        panel.set_xlabel("free floor of the map, m²")
        panel.set_ylabel("computing time, s")
        panel.legend(loc="center left")


EXPERIMENT = Experiment(
    name="kleiner-time",
    summary="Computing time of the correction on the three maps.",
    paper="Kleiner 2006, section VI, text",
    default_runs=100,
    run=measure,
    plot=draw,
    columns=(
        Column("map", "map"),
        Column("method", "method"),
        Column("area m2", "area_m2", digits=0),
        Column("vertices", "vertices"),
        Column("tags", "tags"),
        Column("edges", "edges"),
        Column("ours ms", "time_ms", "time_sd_ms", digits=2),
        Column("paper s", "paper_time_s"),
        Column("x faster", "times_faster", digits=0),
    ),
    notes=(
        "Ours: processor time of one thread, warm, problem built and solved; mean ± deviation over the runs.",
        "Paper: Pentium 4, 2.4 GHz; about 50 tags on the small map, the other graphs' sizes are not printed.",
    ),
)
