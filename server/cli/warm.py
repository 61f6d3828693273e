"""`waymark warm`: compile the numerical kernels now, so that nobody waits for them later."""

from __future__ import annotations

from time import perf_counter

from server.cli.console import say


def warm() -> None:
    """Compile the numerical kernels and keep them on disk; takes a while once, then under a second or two."""
    from robots.sim.runner import run
    from robots.sim.scenario import ScenarioConfig
    from robots.sim.solution import solve
    from robots.warmup import warm_up

    began = perf_counter()
    warm_up()
    solve(run(ScenarioConfig(map="office:60", robots=2, minutes=0.2, victims=1)))
    slam = (("r1", "ekf"), ("r2", "rslam"))
    run(ScenarioConfig(map="office:60", robots=2, minutes=0.1, tags="node", tags_in_place=6, slam=slam))
    say(f"Kernels are ready ({perf_counter() - began:.1f} s).")
