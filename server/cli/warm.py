"""`waymark warm`: compile the numerical kernels now, so that nobody waits for them later."""

from __future__ import annotations

from dataclasses import replace
from time import perf_counter

from server.cli.console import say


def warm() -> None:
    """Compile the numerical kernels and keep them on disk; takes a while once, then under a second or two."""
    from robots.config import PlanningConfig
    from robots.experiments.exploring import Case
    from robots.sim.arena.run import play
    from robots.sim.runner import run
    from robots.sim.scenario import ScenarioConfig
    from robots.sim.solution import solve
    from robots.warmup import warm_up

    began = perf_counter()
    warm_up()
    solve(run(ScenarioConfig(map="office:60", robots=2, minutes=0.2, victims=1)))
    slam = (("r1", "ekf"), ("r2", "rslam"))
    run(ScenarioConfig(map="office:60", robots=2, minutes=0.1, tags="node", tags_in_place=6, slam=slam))
    for planning in (PlanningConfig(), PlanningConfig(communication="full", coordinate="hungarian")):
        arena = Case("warm", planning, "at once", reader_m=2.0, robots=2).config("office:40", 0)
        play(replace(arena, limit_s=8.0))
    say(f"Kernels are ready ({perf_counter() - began:.1f} s).")
