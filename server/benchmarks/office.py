"""A team of four for twenty minutes: how much of an office it sees, how straight, how fast."""

from __future__ import annotations

from time import perf_counter
from typing import Any
from unittest.mock import patch

import numpy as np

from robots.config import GraphConfig
from robots.estimation.graph.solve import GraphSolution
from robots.estimation.tag_graph import graph as tag_graph
from robots.graph_report import GraphReport
from robots.sim.runner import run
from robots.sim.scenario import ScenarioConfig
from robots.sim.solution import solve


def measure(map_spec: str, minutes: float, seed: int) -> dict[str, Any]:
    """Return coverage, trajectory errors, speed against real time, and the times of steps with a scan.

    ``graph_solve_share_percent`` is what the robots' own graphs, solved whole each time, take of all steps.
    """
    solves_s: list[float] = []
    solve_report = tag_graph.solve_report

    def timed(report: GraphReport, config: GraphConfig) -> GraphSolution:
        began = perf_counter()
        solution = solve_report(report, config)
        solves_s.append(perf_counter() - began)
        return solution

    with patch.object(tag_graph, "solve_report", timed):
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
        "graph_solves": len(solves_s),
        "graph_solve_ms_p50": 1e3 * float(np.median(solves_s)) if solves_s else None,
        "graph_solve_share_percent": 100.0
        * sum(solves_s)
        / sum(float(robot.steps_s.sum()) for robot in result.robots),
        "scan_step_p50_last_to_first_quarter": float(np.median(last) / np.median(first)),
        "scan_step_mean_last_to_first_quarter": float(last.mean() / first.mean()),
    }
