"""What a team with full communication needs: ways to share out the unknown, side by side.

Five robots start at one place all at once, and every second tell each other where they are, where they go
and what ground they saw. Without coordination they drive to the nearest edge of the unknown; with it, each
takes its share of the edges by what they are worth to all.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from robots.config import PlanningConfig
from robots.experiments import plotting
from robots.experiments.experiment import Column, Experiment, Options, Row, finite
from robots.experiments.exploring import Case, Outcome, explore_all, maps_of, ratio_of_means, row_of

MAPS = (("normal", "office:589"),)
_TIMES = (50, 90, 99)


def _full(explore: str, coordinate: str) -> PlanningConfig:
    return PlanningConfig(explore=explore, coordinate=coordinate, communication="full")


METHODS: tuple[tuple[str, PlanningConfig], ...] = (
    ("none", PlanningConfig(explore="nearest", communication="none")),
    ("nearest", _full("nearest", "none")),
    ("exclusion", _full("nearest", "exclusion")),
    ("burgard", _full("nearest", "burgard")),
    ("hungarian", _full("nearest", "hungarian")),
    ("voronoi", _full("nearest", "voronoi")),
    ("gain + hungarian", _full("information-gain", "hungarian")),
)


def measure(
    options: Options, methods: Sequence[tuple[str, PlanningConfig]] = METHODS, robots: int = 5
) -> list[Row]:
    """Return a row per map and method.

    Raises:
        ExperimentError: a building cannot be had.
    """
    cases = [Case(name, planning, "at once", magazine=0, robots=robots) for name, planning in methods]
    maps = maps_of(options, MAPS)
    outcomes = explore_all(options, maps, cases)
    rows = []
    for name, _ in maps:
        runs = [[run[k] for run in outcomes[name]] for k in range(len(cases))]
        rows += [
            row_of(name, case, found) | _against(found, runs[1])
            for case, found in zip(cases, runs, strict=True)
        ]
    return rows


def _against(found: Sequence[Outcome], nearest: Sequence[Outcome]) -> Row:
    """Return how many times longer 90 % took than by going to the nearest edge, where both got there."""
    pairs = [(a.t90_s, b.t90_s) for a, b in zip(found, nearest, strict=True) if a.t90_s and b.t90_s]
    ratio = ratio_of_means(*np.array(pairs).T) if pairs else (None, None, None)
    return dict(zip(("t90_ratio", "t90_ratio_low", "t90_ratio_high"), ratio, strict=True))


def _plot(rows: list[Row], path: Path) -> None:
    maps = list(dict.fromkeys(str(row["map"]) for row in rows))
    title = f"Full communication: time to see so much, {int(finite(rows[0], 'runs'))} runs"
    with plotting.figure(path, 1, len(maps), 2.0 + 5.0 * len(maps), 4.2, title, sharey=True) as axes:
        for column, name in enumerate(maps):
            panel = axes[0][column]
            here = [row for row in rows if row["map"] == name]
            colours = (plotting.SKY, plotting.BLUE, plotting.BLACK)
            for offset, (share, colour) in enumerate(zip(_TIMES, colours, strict=True)):
                panel.bar(
                    [at + 0.27 * (offset - 1) for at in range(len(here))],
                    [finite(row, f"t{share}_s") for row in here],
                    0.25,
                    yerr=[finite(row, f"t{share}_sd_s") for row in here],
                    color=colour,
                    label=f"{share} %",
                )
            panel.set_xticks(range(len(here)), [str(row["method"]) for row in here], rotation=30)
            panel.set_title(name)
        axes[0][0].set_ylabel("time, s")
        axes[0][0].legend()


EXPERIMENT = Experiment(
    name="baselines",
    summary="Ways to share out the unknown with full communication, five robots at once.",
    paper="Yamauchi 1997, Burgard 2005",
    default_runs=20,
    run=measure,
    plot=_plot,
    takes_maps=True,
    columns=(
        Column("map", "map"),
        Column("method", "method"),
        Column("T50, s", "t50_s", "t50_sd_s", digits=0),
        Column("T90, s", "t90_s", "t90_sd_s", digits=0),
        Column("x nearest", "t90_ratio"),
        Column("from", "t90_ratio_low"),
        Column("to", "t90_ratio_high"),
        Column("T99, s", "t99_s", "t99_sd_s", digits=0),
        Column("got there", "t99_reached_share"),
        Column("way in all, m", "distance_m", digits=0),
        Column("score, m²/m", "score_mean", "score_sd"),
        Column("stuck", "times_stuck"),
        Column("false ends", "false_ends"),
    ),
    notes=(
        "T90: when 90 % of what can be seen was seen, mean ± deviation of the runs that got there. x nearest:"
        " times longer than to the nearest edge, same buildings and starts, 95 % interval by bootstrap.",
        "All start at one place at the same moment and hear everybody's pose, goal and ground once a second.",
    ),
)
