"""Ziparo 2007 sections 5 and 6: twelve robots whose maps end two metres from them, in 20 minutes.

The paper's strategy on a grid of 4 m with the tags of all robots, with those a robot dropped itself, and
without tags; beside it Waymark's own with such a grid. Tags are read four metres far in line of sight. The
paper prints what teams explored at RoboCup 2006 in buildings of its own, and no run without tags.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from robots.config import AgentConfig, DeploymentConfig, PlanningConfig
from robots.experiments import plotting
from robots.experiments.experiment import Column, Experiment, ExperimentError, Options, Row, finite
from robots.experiments.exploring import maps_of
from robots.experiments.parallel import in_parallel
from robots.exploration.strategies.ziparo import Ziparo
from robots.sim.arena.config import ArenaConfig
from robots.sim.arena.ground import ground_of
from robots.sim.arena.run import Arena
from robots.sim.scenario import ScenarioConfig, ScenarioError
from robots.sim.world import WorldError

Sharing = Literal["none", "private", "tags"]
MAPS = (("office", "office:1240"), ("open", "open:1300"))
METHODS: tuple[tuple[str, str, Sharing], ...] = (
    ("no tags", "ziparo", "none"),
    ("private tags", "ziparo", "private"),
    ("shared tags", "ziparo", "tags"),
    ("waymark", "waymark", "tags"),
)
MARKS_MIN = (2, 5, 10, 20)
ROBOCUP_M2 = {  # table 1: robots and area of the winners and of the best of the others, by run
    "PREL1": (12, 902, "STEEL", 353),
    "PREL2": (12, 550, "SPQR", 191),
    "PREL3": (10, 310, "IUB", 164),
    "SEMI1": (8, 579, "UvA", 262),
    "SEMI2": (8, 1276, "UvA", 286),
    "FINAL1": (8, 1203, "IUB", 210),
    "FINAL2": (8, 350, "IUB", 136),
}
_ROBOTS, _MINUTES = 12, 20.0
_CELL_M = 0.08  # ways are planned on pairs of the 40 mm cells
_READER_M, _READ_EVERY_S = 4.0, 5.0


@dataclass(frozen=True, slots=True)
class Run:
    """A team with a method in a building."""

    map: str
    explore: str
    sharing: Sharing  # what robots read: nothing, tags they dropped themselves, all
    seed: int
    robots: int = _ROBOTS
    minutes: float = _MINUTES


@dataclass(frozen=True, slots=True)
class Outcome:
    """What came of it: shares of what can be seen after ``MARKS_MIN``, times in s, None where never."""

    area_m2: float
    shares: tuple[float, ...]
    t90_s: float | None
    t95_s: float | None
    distance_m: float
    tags: int
    times_stuck: int


def play(run: Run) -> Outcome:
    """Play one run.

    Raises:
        ExperimentError: the building cannot be had.
    """
    side_m = Ziparo.local_map_m
    tags = run.sharing != "none"
    planning = PlanningConfig(
        explore=run.explore,
        local_map_m=side_m,
        cell_m=_CELL_M,
        communication="tags" if tags else "none",
    )
    deployment = DeploymentConfig(magazine=1000 if tags else 0, even_m=Ziparo.tag_every_m)
    try:
        scenario = ScenarioConfig(
            map=run.map,
            robots=run.robots,
            seed=run.seed,
            poses="truth",
            victims=0,
            base_tag=tags,
            agent_config=AgentConfig(planning=planning, deployment=deployment),
        )
        ground = ground_of(scenario)
    except (WorldError, ScenarioError) as error:
        raise ExperimentError(str(error)) from error
    config = ArenaConfig(
        scenario,
        "at once",
        own_tags_only=run.sharing == "private",
        limit_s=60.0 * run.minutes,
        reader_m=_READER_M,
        read_every_s=_READ_EVERY_S,
    )
    result = Arena(config, ground).play()
    shares = [np.interp(60.0 * mark, result.stamps_s, result.covered_m2) for mark in MARKS_MIN]
    return Outcome(
        area_m2=result.observable_m2,
        shares=tuple(float(share) / result.observable_m2 for share in shares),
        t90_s=result.reached_s(0.90),
        t95_s=result.reached_s(0.95),
        distance_m=float(result.driven_m[-1]),
        tags=result.tags,
        times_stuck=result.times_stuck,
    )


def measure(options: Options, robots: int = _ROBOTS, minutes: float = _MINUTES) -> list[Row]:
    """Return a row per map and method, then the paper's runs.

    Raises:
        ExperimentError: a building cannot be had.
    """
    maps = maps_of(options, MAPS)
    seeds = [int(np.random.SeedSequence([options.seed, k]).generate_state(1)[0]) for k in range(options.runs)]
    runs = [
        Run(spec, explore, sharing, seed, robots, minutes)
        for _, spec in maps
        for _, explore, sharing in METHODS
        for seed in seeds
    ]
    outcomes = iter(in_parallel(play, runs, options.jobs, options.progress))
    rows = [
        _row(name, method, robots, [next(outcomes) for _ in seeds])
        for name, _ in maps
        for method, _, _ in METHODS
    ]
    return rows + [
        {
            "map": name,
            "method": "paper, RoboCup 2006",
            "robots": team,
            "explored_m2": float(area),
            "others": others,
            "others_m2": float(theirs),
        }
        for name, (team, area, others, theirs) in ROBOCUP_M2.items()
    ]


def _row(map_name: str, method: str, robots: int, outcomes: Sequence[Outcome]) -> Row:
    shares = np.array([outcome.shares for outcome in outcomes])
    row: Row = {
        "map": map_name,
        "method": method,
        "robots": robots,
        "runs": len(outcomes),
        "area_m2": float(np.mean([outcome.area_m2 for outcome in outcomes])),
        "explored_m2": float(np.mean([o.area_m2 * o.shares[-1] for o in outcomes])),
        "worst_20min": float(shares[:, -1].min()),
        "distance_m": float(np.mean([outcome.distance_m for outcome in outcomes])),
        "tags": float(np.mean([outcome.tags for outcome in outcomes])),
        "times_stuck": sum(outcome.times_stuck for outcome in outcomes),
    }
    for k, mark in enumerate(MARKS_MIN):
        row[f"coverage_{mark}min"] = float(shares[:, k].mean())
        row[f"coverage_{mark}min_sd"] = float(shares[:, k].std(ddof=1)) if len(outcomes) > 1 else 0.0
    for name in ("t90_s", "t95_s"):
        reached = [t for outcome in outcomes if (t := getattr(outcome, name)) is not None]
        row[name] = float(np.mean(reached)) if reached else None
        row[f"{name}_reached_share"] = len(reached) / len(outcomes)
    return row


def _draw(rows: list[Row], path: Path) -> None:
    """Draw coverage over time, a panel for each map."""
    shades = (plotting.GREY, plotting.SKY, plotting.BLUE, plotting.GREEN)
    colours = dict(zip([method for method, _, _ in METHODS], shades, strict=True))
    ours = [row for row in rows if row["method"] in colours]
    maps = list(dict.fromkeys(str(row["map"]) for row in ours))
    title = "Twelve robots with a map of 4 m (Ziparo 2007, sections 5 and 6)"
    with plotting.figure(path, 1, len(maps), 4.6 * len(maps), 3.8, title) as axes:
        for panel, name in zip(axes[0], maps, strict=True):
            for row in (row for row in ours if row["map"] == name):
                method = str(row["method"])
                panel.errorbar(
                    [0.0, *map(float, MARKS_MIN)],
                    [0.0, *(finite(row, f"coverage_{mark}min") for mark in MARKS_MIN)],
                    [0.0, *(finite(row, f"coverage_{mark}min_sd") for mark in MARKS_MIN)],
                    color=colours[method], marker="o", capsize=3.0, label=method,
                )  # fmt: skip
            panel.set_title(name)
            panel.set_xlabel("minutes")
            panel.set_ylabel("share seen")
            panel.set_ylim(0.0, 1.05)
        axes[0][-1].legend(loc="lower right")


EXPERIMENT = Experiment(
    name="ziparo-exploration",
    summary="Twelve robots with maps of 4 m: shared, private and no tags, and Waymark's own.",
    paper="Ziparo 2007, section 6, table 1",
    default_runs=20,
    run=measure,
    plot=_draw,
    takes_maps=True,
    columns=(
        Column("map", "map"),
        Column("method", "method"),
        Column("robots", "robots"),
        *(Column(f"{mark} min", f"coverage_{mark}min", f"coverage_{mark}min_sd") for mark in MARKS_MIN),
        Column("worst", "worst_20min"),
        Column("T90, s", "t90_s", digits=0),
        Column("got there", "t90_s_reached_share"),
        Column("m²", "explored_m2", digits=0),
        Column("tags", "tags", digits=0),
        Column("best of the others", "others"),
        Column("m²", "others_m2", digits=0),
    ),
    notes=(
        "Share of what a laser of 4 m can see from where robots get, after so many minutes; mean ± deviation"
        " over the runs. Worst: of all runs, after 20 minutes. T90: of the runs that got there.",
        "All plan on a grid of 4 m with 40 mm cells that goes along; a tag wherever none is within a metre;"
        " readers reach 4 m in line of sight. Robots start together and do not stand in each other's way.",
        "The paper's own runs: other buildings and sensors; last columns: the best of the other teams.",
    ),
)
