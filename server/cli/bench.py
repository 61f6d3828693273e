"""`waymark bench`: what BENCHMARKS.md reports, measured here and now."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from server.cli.console import CommandError, print_json, print_table

_KNOWN = (
    "office",
    "latency",
    "scan-match",
    "solve",
    "incremental",
    "rslam",
    "ekf",
    "decision",
    "exploration",
    "outbox",
    "phone",
    "history",
    "console",
)


def bench(
    names: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[office|latency|scan-match|solve|incremental|rslam|ekf|decision|exploration|outbox"
            "|phone|history|console]..."
        ),
    ] = None,
    map_spec: Annotated[
        str, typer.Option("--map", metavar="FILE.yaml|office:AREA", help="Building for `office`.")
    ] = "office:590",
    minutes: Annotated[float, typer.Option(metavar="M", help="Length of the mission of `office`.")] = 20.0,
    seconds: Annotated[float, typer.Option(metavar="S", help="Length of `latency` and `console`.")] = 60.0,
    maps: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="map_server maps for `scan-match`; without it, generated ones."),
    ] = None,
    pairs: Annotated[
        int, typer.Option(min=1, max=100_000, metavar="N", help="Pairs in each building of `scan-match`.")
    ] = 200,
    seed: Annotated[int, typer.Option(min=0, metavar="S", help="Seed of `scan-match` and `outbox`.")] = 1,
    sequences: Annotated[
        int, typer.Option(min=1, max=10_000, metavar="N", help="Sequences of faults in `outbox`.")
    ] = 1000,
    graphs: Annotated[
        list[Path] | None,
        typer.Option(
            "--graph",
            metavar="GRAPH.g2o",
            help="Pose graph for `solve`, after one of 50 vertices, and `incremental`; may be repeated.",
        ),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Measure speed and accuracy on this machine. Without a name: `office` and `latency`."""
    results: dict[str, dict[str, Any]] = {}
    for name in names or ["office", "latency"]:
        if name not in _KNOWN:
            raise CommandError(f"there is no benchmark {name}; known are {', '.join(_KNOWN)}")
        if name in ("solve", "incremental"):
            for path in [None, *(graphs or [])] if name == "solve" else graphs or [_no_graph(name)]:
                title = f"{name} {'small' if path is None else path.stem}"
                results[title] = _graph(name, path)
                if not as_json:
                    print_table(title, results[title])
            continue
        if name == "scan-match":
            results[name] = _scan_match(maps, pairs, seed)
        elif name in ("outbox", "phone", "console"):
            results[name] = _in_browser(name, sequences, seed, seconds)
        else:
            results[name] = _measure(name, map_spec, minutes, seconds)
        if not as_json:
            print_table(name, results[name])
    if as_json:
        print_json(results)


def _measure(name: str, map_spec: str, minutes: float, seconds: float) -> dict[str, Any]:
    if name == "office":
        from server.benchmarks import office

        return office.measure(map_spec, minutes, seed=1)
    if name == "rslam":
        from server.benchmarks import range_updates

        return range_updates.measure()
    if name == "ekf":
        from server.benchmarks import ekf

        return ekf.measure()
    if name == "exploration":
        from server.benchmarks import exploration

        return exploration.measure()
    if name == "decision":
        from server.benchmarks import decision

        return decision.measure()
    if name == "history":
        from server.benchmarks import history

        return history.measure(minutes=minutes)
    from server.benchmarks import latency

    return latency.measure(seconds=seconds)


def _in_browser(name: str, sequences: int, seed: int, seconds: float) -> dict[str, Any]:
    from server.benchmarks import console, outbox, phone
    from server.benchmarks.browser import CannotMeasureError

    try:
        if name == "console":
            return console.measure(seconds)
        return outbox.measure(sequences, seed) if name == "outbox" else phone.measure()
    except CannotMeasureError as error:
        raise CommandError(str(error)) from error


def _no_graph(name: str) -> Path:
    raise CommandError(f"`bench {name}` needs a pose graph: --graph GRAPH.g2o")


def _graph(name: str, path: Path | None) -> dict[str, Any]:
    """Measure with a graph; without one, with 50 vertices and 200 edges."""
    from robots.datasets import g2o
    from robots.estimation.graph.problem import GraphError
    from server.benchmarks import graphs

    try:
        if path is None:
            return graphs.solve(graphs.small(), "small")
        graph = g2o.read(path)
        return graphs.solve(graph, path.stem) if name == "solve" else graphs.incremental(graph, path.stem)
    except GraphError as error:
        raise CommandError(str(error)) from error


def _scan_match(maps: Path | None, pairs: int, seed: int) -> dict[str, Any]:
    from robots.sim.world import WorldError
    from server.benchmarks import scan_match

    if maps is not None and not any(maps.glob("*.yaml")):
        raise CommandError(f"{maps}: there is no map_server map (*.yaml) in this folder")
    try:
        return scan_match.measure(maps, pairs, seed)
    except WorldError as error:
        raise CommandError(str(error)) from error
