"""How far a robot drives to see almost everything, beside a tour by somebody who knows the plan."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import nan
from pathlib import Path

import numpy as np

from robots.config import AgentConfig, PlanningConfig
from robots.experiments import plotting
from robots.experiments.experiment import Column, Experiment, ExperimentError, Options, Row, finite
from robots.experiments.exploring import LIMIT_PER_M2_S, maps_of, ratio_of_means
from robots.experiments.oracle import Oracle
from robots.experiments.parallel import in_parallel
from robots.sim.arena.config import ArenaConfig
from robots.sim.arena.ground import ground_of
from robots.sim.arena.run import Arena
from robots.sim.scenario import ScenarioConfig, ScenarioError
from robots.sim.world import WorldError

MAPS = (("normal", "office:589"),)
METHODS = ("nearest", "information-gain", "waymark")
SHARE = 0.98  # of what can be seen


@dataclass(frozen=True, slots=True)
class _Work:
    map_spec: str
    seed: int
    methods: tuple[str, ...]


def measure(options: Options, methods: Sequence[str] = METHODS) -> list[Row]:
    """Return a row per map and method, the oracle last.

    Raises:
        ExperimentError: a building cannot be had.
    """
    maps = maps_of(options, MAPS)
    work = [
        _Work(spec, int(np.random.SeedSequence([options.seed, run]).generate_state(1)[0]), tuple(methods))
        for _, spec in maps
        for run in range(options.runs)
    ]
    try:
        found = np.array(in_parallel(_drive, work, options.jobs, options.progress))
    except (WorldError, ScenarioError) as error:
        raise ExperimentError(str(error)) from error
    rows: list[Row] = []
    for index, (name, _) in enumerate(maps):
        here = found[index * options.runs : (index + 1) * options.runs]
        for k, method in enumerate((*methods, "oracle")):
            there = np.isfinite(here[:, k])
            ratio = ratio_of_means(here[there, -1], here[there, k]) if there.any() else (nan, nan, nan)
            rows.append(
                {
                    "map": name,
                    "method": method,
                    "runs": len(here),
                    "reached": int(there.sum()),
                    "way_per_m2": float(here[there, k].mean()) if there.any() else None,
                    "way_per_m2_sd": float(here[there, k].std(ddof=1)) if there.sum() > 1 else None,
                    **dict(zip(("of_oracle", "of_oracle_low", "of_oracle_high"), ratio, strict=True)),
                }
            )
    return rows


def _drive(work: _Work) -> tuple[float, ...]:
    """Return the metres driven for each square metre seen, of every method and then of the oracle.

    NaN where the share was not reached.
    """
    scenario = ScenarioConfig(
        map=work.map_spec, robots=1, seed=work.seed, poses="truth", victims=0, base_tag=False
    )
    ground = ground_of(scenario)
    ways = []
    for method in work.methods:
        told = AgentConfig(planning=PlanningConfig(explore=method, communication="none"))
        config = ArenaConfig(
            replace(scenario, agent_config=told),
            "at once",
            until=SHARE,
            limit_s=LIMIT_PER_M2_S * ground.observable_m2,
        )
        result = Arena(config, ground).play()
        reached = result.coverage >= SHARE - 1e-9
        ways.append(float(result.driven_m[-1] / result.covered_m2[-1]) if reached else nan)
    body, laser = scenario.agent_config.body, scenario.laser
    tour = Oracle(ground, body.radius_m, laser.range_max_m).tour(ground.starts[0], SHARE)
    return (*ways, tour.length_m / (tour.share * ground.observable_m2))


def _plot(rows: list[Row], path: Path) -> None:
    title = f"One robot: way to see {SHARE:.0%}, {int(finite(rows[0], 'runs'))} runs"
    maps = list(dict.fromkeys(str(row["map"]) for row in rows))
    with plotting.figure(path, 1, len(maps), 2.0 + 4.0 * len(maps), 4.0, title, sharey=True) as axes:
        for column, name in enumerate(maps):
            here = [row for row in rows if row["map"] == name]
            panel = axes[0][column]
            panel.bar(range(len(here)), [finite(row, "way_per_m2") for row in here], 0.6, color=plotting.BLUE)
            panel.set_xticks(range(len(here)), [str(row["method"]) for row in here], rotation=30)
            panel.set_title(name)
        axes[0][0].set_ylabel("way, m per m² seen")


EXPERIMENT = Experiment(
    name="one-robot",
    summary="One robot beside an offline oracle: the way to see 98 % of what can be seen.",
    paper="no paper: what exploring in the dark costs",
    default_runs=20,
    run=measure,
    plot=_plot,
    takes_maps=True,
    columns=(
        Column("map", "map"),
        Column("method", "method"),
        Column("runs", "runs", digits=0),
        Column("got there", "reached", digits=0),
        Column("way, m/m²", "way_per_m2", "way_per_m2_sd", digits=3),
        Column("of the oracle", "of_oracle"),
        Column("from", "of_oracle_low"),
        Column("to", "of_oracle_high"),
    ),
    notes=(
        "of the oracle: its way for a square metre by the robot's, with its 95 % interval by bootstrap; 1 is"
        " as good as knowing the plan. The oracle's tour can be driven, a better one may exist.",
    ),
)
