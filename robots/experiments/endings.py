"""Do robots end well? Runs to the end of robots in each other's way: who stood still, who was done too early.

Offices and halls; bricks that no laser sees; glass, behind which maps show what was never seen, since a beam
that meets it comes back far; tags that are off by 0.3 m; robots that hear each other. A robot is stuck when
it means to drive and makes no way for a minute; its end is false when it says it is done with a square metre
in one piece left that it could have seen.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from robots.config import AgentConfig, DeploymentConfig, PlanningConfig
from robots.experiments import plotting
from robots.experiments.experiment import Column, Experiment, ExperimentError, Options, Row, finite
from robots.experiments.exploring import maps_of
from robots.experiments.parallel import in_parallel
from robots.sim.arena.config import ArenaConfig
from robots.sim.arena.ground import ground_of
from robots.sim.arena.run import Arena
from robots.sim.hostile import HostileConfig
from robots.sim.scenario import ScenarioConfig, ScenarioError
from robots.sim.world import WorldError

MAPS = (("office", "office:100"), ("hall", "open:100"), ("offices", "office:200"))
NOTHING, BRICKS, GLASS = HostileConfig(), HostileConfig(bricks=8), HostileConfig(glass=3)
_LIMIT_S = 1800.0


@dataclass(frozen=True, slots=True)
class Hardship:
    """What makes it hard to end well. ``communication`` as in ``PlanningConfig``."""

    name: str
    robots: int = 2
    communication: str = "tags"
    tag_error_m: float = 0.0
    rubble: HostileConfig = NOTHING

    def config(self, map_spec: str, seed: int) -> ArenaConfig:
        """Return a run in a building, to the end of all robots."""
        talk = self.communication in ("full", "radio")
        planning = PlanningConfig(
            communication="full" if talk else "tags", coordinate="hungarian" if talk else "none"
        )
        scenario = ScenarioConfig(
            map=map_spec,
            robots=self.robots,
            seed=seed,
            poses="truth",
            victims=0,
            hostile=self.rubble,
            agent_config=AgentConfig(planning=planning, deployment=DeploymentConfig(even_m=1.0)),
        )
        return ArenaConfig(
            scenario,
            "at once",
            limit_s=_LIMIT_S,
            until=2.0,
            tag_error_m=self.tag_error_m,
            collide=True,
        )


HARDSHIPS = (
    Hardship("two robots"),
    Hardship("two, tags off by 0.3 m", tag_error_m=0.3),
    Hardship("two, bricks", rubble=BRICKS),
    Hardship("two, glass", rubble=GLASS),
    Hardship("four robots", robots=4),
    Hardship("four that talk", robots=4, communication="full"),
)


@dataclass(frozen=True, slots=True)
class Ending:
    """What came of one run."""

    times_stuck: int
    false_ends: int
    coverage: float
    end_s: float
    all_done: bool


def play(map_spec: str, hardship: Hardship, seed: int) -> Ending:
    """Play one run.

    Raises:
        WorldError, ScenarioError: the building cannot be had.
    """
    config = hardship.config(map_spec, seed)
    arena = Arena(config, ground_of(config.scenario))
    result = arena.play()
    done = all(robot.decision.activity == "done" for robot in arena.robots)
    return Ending(result.times_stuck, result.false_ends, result.coverage, float(result.stamps_s[-1]), done)


def _play(work: tuple[str, Hardship, int]) -> Ending:
    return play(*work)


def measure(options: Options, hardships: Sequence[Hardship] = HARDSHIPS) -> list[Row]:
    """Return a row per map and hardship; the seeds of runs that went wrong are in ``wrong``.

    Raises:
        ExperimentError: a building cannot be had.
    """
    pairs = [(name, spec, hard) for name, spec in maps_of(options, MAPS) for hard in hardships]
    seeds = [int(np.random.SeedSequence([options.seed, k]).generate_state(1)[0]) for k in range(options.runs)]
    work = [(spec, hard, seed) for _, spec, hard in pairs for seed in seeds]
    try:
        endings = iter(in_parallel(_play, work, options.jobs, options.progress))
    except (WorldError, ScenarioError) as error:
        raise ExperimentError(str(error)) from error
    return [_row(name, hard, seeds, [next(endings) for _ in seeds]) for name, _, hard in pairs]


def _row(name: str, hard: Hardship, seeds: Sequence[int], endings: Sequence[Ending]) -> Row:
    wrong = [
        seed
        for seed, end in zip(seeds, endings, strict=True)
        if end.times_stuck or end.false_ends or not end.all_done
    ]
    return {
        "map": name,
        "hardship": hard.name,
        "robots": hard.robots,
        "runs": len(endings),
        "stuck_runs": sum(end.times_stuck > 0 for end in endings),
        "false_end_runs": sum(end.false_ends > 0 for end in endings),
        "unfinished_runs": sum(not end.all_done for end in endings),
        "coverage": float(np.mean([end.coverage for end in endings])),
        "coverage_least": min(end.coverage for end in endings),
        "end_s": float(np.mean([end.end_s for end in endings])),
        "wrong": " ".join(map(str, wrong)),
    }


def _plot(rows: list[Row], path: Path) -> None:
    title = f"Runs that ended badly, of {int(finite(rows[0], 'runs'))} each"
    with plotting.figure(path, 1, 1, 7.0, 4.2, title) as axes:
        panel = axes[0][0]
        kinds = (
            ("stuck_runs", plotting.VERMILION, "stuck"),
            ("false_end_runs", plotting.ORANGE, "false end"),
        )
        for offset, (name, colour, label) in enumerate(kinds):
            panel.bar(
                [at + 0.4 * offset for at in range(len(rows))],
                [finite(row, name) for row in rows],
                0.38,
                color=colour,
                label=label,
            )
        labels = [f"{row['map']}: {row['hardship']}" for row in rows]
        panel.set_xticks(range(len(rows)), labels, rotation=60, ha="right")
        panel.legend()


EXPERIMENT = Experiment(
    name="endings",
    summary="Robots in each other's way in offices and halls: who is stuck, who is done too early.",
    paper="none: issue threads of explorers in use",
    default_runs=70,
    run=measure,
    plot=_plot,
    takes_maps=True,
    columns=(
        Column("map", "map"),
        Column("hardship", "hardship"),
        Column("runs", "runs", digits=0),
        Column("stuck", "stuck_runs", digits=0),
        Column("false ends", "false_end_runs", digits=0),
        Column("not ended", "unfinished_runs", digits=0),
        Column("seen", "coverage", digits=4),
        Column("least", "coverage_least", digits=4),
        Column("ended after, s", "end_s", digits=0),
        Column("seeds that went wrong", "wrong"),
    ),
    notes=(
        "Counted are runs with a robot that made no way for a minute while it meant to, that was done with"
        " 1 m² in one piece left that it could have seen, or that was not done after half an hour.",
        "All at once from one place, in each other's way and view, tags of 2,048 bits read within 30 cm.",
    ),
)
