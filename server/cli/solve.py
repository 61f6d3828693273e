"""`waymark solve`: the most likely poses of a pose graph."""

from __future__ import annotations

from pathlib import Path
from statistics import median
from time import perf_counter
from typing import Annotated, Literal

import typer

from server.cli.console import CommandError, print_json, print_table, say
from server.cli.options import JsonOption

_RUNS, _MOST_RUNS, _TIMED_S = 5, 200, 0.1  # timed after the first, which compiles and warms
_TOLERANCE = 1e-6  # of chi2
_LEFT_OUT_SD = 6.0  # beyond it the kernel leaves less than a sixth of an edge's weight


def solve(
    graph: Annotated[
        Path, typer.Argument(metavar="GRAPH.g2o", help="Pose graph with SE2 vertices and edges.")
    ],
    method: Annotated[
        str,
        typer.Option(
            metavar="gauss-newton|linear", help="linear: headings first, then places, no iteration."
        ),
    ] = "gauss-newton",
    out: Annotated[
        Path | None, typer.Option(metavar="OUT.g2o", help="Write the graph with its solved vertices there.")
    ] = None,
    robust: Annotated[
        bool,
        typer.Option("--robust", help="Edges between poses that do not follow each other may be wrong."),
    ] = False,
    json: JsonOption = False,
) -> None:
    """Solve a pose graph and print chi2 before and after, and the time that takes (warm, without reading)."""
    from robots.datasets import g2o
    from robots.estimation.graph.solve import GraphError
    from robots.estimation.graph.solve import solve as solve_graph

    if method not in ("gauss-newton", "linear"):
        raise CommandError(f"--method has to be gauss-newton or linear, not {method!r}")
    form: Literal["gauss-newton", "linear"] = "linear" if method == "linear" else "gauss-newton"
    start: Literal["relaxed", "doubted"] = "relaxed" if method == "linear" else "doubted"
    try:
        pose_graph = g2o.read(graph)
        problem, pieces = pose_graph.problem(robust)
        times: list[float] = []
        while len(times) <= _RUNS or (sum(times[1:]) < _TIMED_S and len(times) < _MOST_RUNS):
            began = perf_counter()
            solution = solve_graph(problem, form, max_iterations=100, start=start, tolerance=_TOLERANCE)
            times.append(perf_counter() - began)
        if out is not None:
            g2o.write(out, pose_graph, solution.poses)
    except GraphError as error:
        raise CommandError(str(error)) from error
    for note in (*pose_graph.notes, *pieces, *solution.notes):
        say(f"Note: {note}.")
    left_out = solution.edge_residuals > _LEFT_OUT_SD
    result = {
        "vertices": len(pose_graph.ids),
        "edges": len(pose_graph.pairs),
        "iterations": solution.iterations,
        "chi2_initial": pose_graph.chi2(pose_graph.poses),
        "chi2": pose_graph.chi2(solution.poses),
        "solve_ms": 1e3 * median(times[1:]),
    }
    if robust:
        result["edges_left_out"] = int(left_out.sum())
    if json:
        print_json(result)
    else:
        print_table(graph.name, result)
