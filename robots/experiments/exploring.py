"""Runs of the arena for experiments: the same buildings and starts for every way to explore them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from robots.config import AgentConfig, DeploymentConfig, PlanningConfig
from robots.experiments.experiment import ExperimentError, Options, Row
from robots.experiments.parallel import in_parallel
from robots.se2 import Array
from robots.sim.arena.config import ArenaConfig, Order
from robots.sim.arena.ground import ground_of
from robots.sim.arena.run import Arena
from robots.sim.scenario import ScenarioConfig, ScenarioError
from robots.sim.sensors import LaserConfig
from robots.sim.starts import StartKind
from robots.sim.world import WorldError

BUDGET_PER_M2 = 0.1  # metres of way for every robot
LIMIT_PER_M2_S = 2.5  # at once
ROBOTS = 5
_RESAMPLED = 4000


@dataclass(frozen=True, slots=True)
class Case:
    """One way to explore: the method's name, and what the arena is told.

    ``laser_sd_m``: noise of the laser. With none at all, robots that know the same go the same way: the
    hardest case for those that do not communicate.
    """

    method: str
    planning: PlanningConfig
    in_order: Order = "sequence"
    start: StartKind = "same"
    reader_m: float = 0.3
    tag_bits: int = 2048
    tag_error_m: float = 0.0
    robots: int = ROBOTS
    laser_sd_m: float = 0.0
    magazine: int = 100
    tag_every_m: float = 0.0  # 0: by the density of tags and of obstacles (Kleiner 2006)
    one_map: bool = False

    def config(self, map_spec: str, seed: int) -> ArenaConfig:
        """Return the run in a building; budgets are for it to be measured."""
        scenario = ScenarioConfig(
            map=map_spec,
            robots=self.robots,
            seed=seed,
            poses="truth",
            start=self.start,
            victims=0,
            tag_bits=self.tag_bits,
            laser=LaserConfig(sd_m=self.laser_sd_m),
            base_tag=self.magazine > 0,
            agent_config=AgentConfig(
                planning=self.planning,
                deployment=DeploymentConfig(magazine=self.magazine, even_m=self.tag_every_m),
            ),
        )
        return ArenaConfig(
            scenario,
            self.in_order,
            self.one_map,
            budget_m=0.0,
            until=0.99,
            reader_m=self.reader_m,
            tag_error_m=self.tag_error_m,
        )


@dataclass(frozen=True, slots=True)
class Outcome:
    """What came of one run; times in s, None where a share was never seen."""

    area_m2: float
    score: float
    t50_s: float | None
    t90_s: float | None
    t99_s: float | None
    coverage: float
    distance_m: float
    steps: int
    times_stuck: int
    false_ends: int
    tags: int
    claimed_share: float | None


@dataclass(frozen=True, slots=True)
class _Work:
    map_spec: str
    seed: int
    cases: tuple[Case, ...]


Outcomes = dict[str, list[tuple[Outcome, ...]]]  # of each map, of each run, of each case


def explore_all(
    options: Options, maps: Sequence[tuple[str, str]], cases: Sequence[Case], before: int = 0, total: int = 0
) -> Outcomes:
    """Return the outcomes on maps (name, specification), ``options.runs`` of each.

    Raises:
        ExperimentError: a building cannot be had.
    """
    work = [
        _Work(spec, _seed(options.seed, run), tuple(cases)) for _, spec in maps for run in range(options.runs)
    ]
    report = partial(_report, options.progress, before, total or len(work))
    try:
        found = in_parallel(_explore, work, options.jobs, report)
    except (WorldError, ScenarioError) as error:
        raise ExperimentError(str(error)) from error
    return {
        name: found[index * options.runs : (index + 1) * options.runs] for index, (name, _) in enumerate(maps)
    }


def maps_of(options: Options, own: Sequence[tuple[str, str]]) -> list[tuple[str, str]]:
    """Return the maps asked for by name and specification, or an experiment's own."""
    return [(spec, spec) for spec in options.maps] or list(own)


def _report(progress: Callable[[int, int], None], before: int, total: int, done: int, _of: int) -> None:
    progress(before + done, total)


def _seed(seed: int, run: int) -> int:
    return int(np.random.SeedSequence([seed, run]).generate_state(1)[0])


def _explore(work: _Work) -> tuple[Outcome, ...]:
    return tuple(_play(case.config(work.map_spec, work.seed)) for case in work.cases)


def _play(config: ArenaConfig) -> Outcome:
    ground = ground_of(config.scenario)
    area_m2 = ground.observable_m2
    budget_m = BUDGET_PER_M2 * area_m2
    result = Arena(replace(config, budget_m=budget_m, limit_s=LIMIT_PER_M2_S * area_m2), ground).play()
    return Outcome(
        area_m2=area_m2,
        score=result.score,
        t50_s=result.reached_s(0.5),
        t90_s=result.reached_s(0.9),
        t99_s=result.reached_s(0.99),
        coverage=result.coverage,
        distance_m=float(result.driven_m[-1]),
        steps=result.steps,
        times_stuck=result.times_stuck,
        false_ends=result.false_ends,
        tags=result.tags,
        claimed_share=result.claimed_share,
    )


def row_of(map_name: str, case: Case, outcomes: Sequence[Outcome]) -> Row:
    """Return what the runs of one case came to."""
    scores = np.array([outcome.score for outcome in outcomes])
    claimed = [outcome.claimed_share for outcome in outcomes if outcome.claimed_share is not None]
    row: Row = {
        "map": map_name,
        "area_m2": float(np.mean([outcome.area_m2 for outcome in outcomes])),
        "start": case.start,
        "in_order": case.in_order,
        "reader_m": case.reader_m if case.magazine else None,
        "tag_bits": case.tag_bits if case.magazine else None,
        "cell_m": case.planning.tag_cell_m if case.magazine else None,
        "tag_error_m": case.tag_error_m if case.magazine else None,
        "method": case.method,
        "explore": case.planning.explore,
        "robots": case.robots,
        "runs": len(outcomes),
        "score_mean": float(scores.mean()),
        "score_sd": _deviation(scores),
        "coverage": float(np.mean([outcome.coverage for outcome in outcomes])),
        "distance_m": float(np.mean([outcome.distance_m for outcome in outcomes])),
        "tags": float(np.mean([outcome.tags for outcome in outcomes])),
        "claimed_share": float(np.mean(claimed)) if claimed else None,
        "times_stuck": sum(outcome.times_stuck for outcome in outcomes),
        "false_ends": sum(outcome.false_ends for outcome in outcomes),
        "steps": sum(outcome.steps for outcome in outcomes),
    }
    for share in (50, 90, 99):
        times = [getattr(outcome, f"t{share}_s") for outcome in outcomes]
        reached = np.array([t for t in times if t is not None])
        at_once = case.in_order == "at once"  # one after the other, time says nothing
        row[f"t{share}_s"] = float(reached.mean()) if at_once and len(reached) else None
        row[f"t{share}_sd_s"] = _deviation(reached) if at_once and len(reached) else None
        row[f"t{share}_reached_share"] = len(reached) / len(times) if at_once else None
    return row


def gap_closed(none: Array, method: Array, full: Array) -> tuple[float, float, float]:
    """Return the share of the gap from ``none`` to ``full`` that a method closes, scores (n,) paired by run.

    With the 95 % interval by bootstrap over the runs. NaN where there is no gap.
    """

    def share(rows: Array) -> Array:
        none_mean, mean, full_mean = rows
        with np.errstate(divide="ignore", invalid="ignore"):
            found: Array = (mean - none_mean) / (full_mean - none_mean)
        return found

    return _bootstrapped(np.array([none, method, full]), share)


def ratio_of_means(above: Array, below: Array) -> tuple[float, float, float]:
    """Return the ratio of two means, values (n,) paired by run, with its 95 % interval by bootstrap."""

    def ratio(rows: Array) -> Array:
        found: Array = rows[0] / rows[1]
        return found

    return _bootstrapped(np.array([above, below]), ratio)


def _bootstrapped(values: Array, of: Callable[[Array], Array]) -> tuple[float, float, float]:
    """Return a function of the means of values (k, n) and its 95 % interval; it takes (k, m) means."""
    runs = values.shape[1]
    picks = np.random.default_rng(0).integers(0, runs, (_RESAMPLED, runs))
    low, high = np.percentile(of(values[:, picks].mean(axis=2)), (2.5, 97.5))
    return float(of(values.mean(axis=1)[:, None])[0]), float(low), float(high)


def _deviation(values: Array) -> float:
    return float(values.std(ddof=1)) if len(values) > 1 else 0.0
