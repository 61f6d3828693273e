"""A team of four for twenty minutes: how much of an office it sees, how straight, how fast."""

from __future__ import annotations

from typing import Any

import numpy as np

from robots.sim.runner import run
from robots.sim.scenario import ScenarioConfig
from robots.sim.solution import solve


def measure(map_spec: str, minutes: float, seed: int) -> dict[str, Any]:
    """Return coverage, trajectory errors, speed against real time, and the times of steps with a scan."""
    result = run(ScenarioConfig(map=map_spec, robots=4, minutes=minutes, seed=seed, noise_level=3))
    steps_ms = [robot.steps_s[robot.with_scan] * 1e3 for robot in result.robots]
    every = np.concatenate(steps_ms)
    first = np.concatenate([steps[: len(steps) // 4] for steps in steps_ms])
    last = np.concatenate([steps[-(len(steps) // 4) :] for steps in steps_ms])
    errors = [error for error in solve(result).ate_m().values() if error is not None]
    return {
        "coverage": result.score.coverage,
        "worst_ate_m": max(errors, default=None),
        "times_real_time": result.clock_s / result.wall_s,
        "scan_step_ms_p50": float(np.median(every)),
        "scan_step_ms_p99": float(np.percentile(every, 99)),
        "scan_step_p50_last_to_first_quarter": float(np.median(last) / np.median(first)),
        "scan_step_mean_last_to_first_quarter": float(last.mean() / first.mean()),
    }
