"""`waymark replay g2o`: a pose graph gone through one pose at a time."""

from __future__ import annotations

from pathlib import Path
from time import perf_counter
from typing import Any, Literal

from server.cli.console import CommandError, progress, say


def replay_pose_graph(path: Path, slam: str | None, out: Path | None) -> dict[str, Any]:
    """Replay a pose graph and return the summary.

    Raises:
        CommandError: it cannot be read, solved or written.
    """
    import numpy as np

    from robots.datasets import g2o
    from robots.datasets.pose_graph_replay import replay_graph
    from robots.estimation.graph.solve import GraphError
    from robots.outputs import write_trajectories

    form: Literal["tag-graph", "odometry"] = "odometry" if slam == "odometry" else "tag-graph"
    began = perf_counter()
    try:
        graph = g2o.read(path)
        with progress() as display:
            task = display.add_task(f"replaying {path.name}", total=len(graph.ids))
            result = replay_graph(graph, form, lambda: display.advance(task))
        if out is not None:
            write_trajectories(out, "r1", result.online, result.final)
            g2o.write(out / "solved.g2o", graph, result.poses)
    except (GraphError, OSError) as error:
        raise CommandError(str(error)) from error
    for note in (*graph.notes, *result.notes):
        say(f"Note: {note}.")
    wall_s = perf_counter() - began
    step_ms = 1e3 * result.step_s
    return {
        "dataset": "g2o",
        "slam": form,
        "robots": 1,
        "vertices": len(graph.ids),
        "edges": len(graph.pairs),
        "loops": result.loops,
        "solves": result.solves,
        "distance_m": result.distance_m,
        "chi2_initial": graph.chi2(result.reckoned),
        "chi2": graph.chi2(result.poses),
        "step_hz": len(step_ms) / wall_s,
        "wall_s": wall_s,
        "step_ms_p50": float(np.percentile(step_ms, 50)),
        "step_ms_p99": float(np.percentile(step_ms, 99)),
        "out": str(out) if out is not None else None,
    }
