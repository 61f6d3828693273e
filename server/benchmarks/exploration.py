"""How fast the arena explores: robot-steps of 0.2 m per second of one core, by map and method."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from robots.config import PlanningConfig
from robots.experiments.exploring import BUDGET_PER_M2, Case
from robots.experiments.kleiner_exploration import MAPS, NEAREST
from robots.sim.arena.ground import ground_of
from robots.sim.arena.run import Arena

_CASES = {
    "none": Case("none", NEAREST, magazine=0),
    "full": Case("full", NEAREST, magazine=0, one_map=True),
    "tags_30_cm": Case("tags", PlanningConfig(explore="waymark")),
    "tags_4_m": Case("tags", PlanningConfig(explore="waymark"), reader_m=4.0),
}
_RUNS, _CORES = 100, 2


def measure(maps: Sequence[tuple[str, str]] = MAPS, seed: int = 1) -> dict[str, Any]:
    """Return robot-steps per second of processor time, five robots in sequence.

    And how many minutes 100 runs of none, full and tags (30 cm) on these maps take two cores, worlds made and
    all.
    """
    found: dict[str, Any] = {}
    seconds = 0.0
    _play(next(iter(_CASES.values())), "office:60", seed)  # compiles
    for name, spec in maps:
        began = time.process_time()
        ground_of(_CASES["none"].config(spec, seed).scenario)
        seconds += time.process_time() - began
        for method, case in _CASES.items():
            steps, spent_s = _play(case, spec, seed)
            found[f"{name}_{method}_steps_per_s"] = steps / spent_s
            seconds += spent_s if method != "tags_4_m" else 0.0
    return {**found, "minutes_of_100_runs": _RUNS * seconds / _CORES / 60.0}


def _play(case: Case, spec: str, seed: int) -> tuple[int, float]:
    """Return the steps of a run and the processor time that they took."""
    config = case.config(spec, seed)
    ground = ground_of(config.scenario)
    arena = Arena(replace(config, budget_m=BUDGET_PER_M2 * ground.observable_m2), ground)
    began = time.process_time()
    result = arena.play()
    return result.steps, time.process_time() - began
