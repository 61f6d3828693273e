"""`waymark bench`: what BENCHMARKS.md reports, measured here and now."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from server.cli.console import CommandError, print_json, print_table

_KNOWN = ("office", "latency")


def bench(
    names: Annotated[list[str] | None, typer.Argument(metavar="[office|latency]...")] = None,
    map_spec: Annotated[
        str, typer.Option("--map", metavar="FILE.yaml|office:AREA", help="Building for `office`.")
    ] = "office:590",
    minutes: Annotated[float, typer.Option(metavar="M", help="Length of the mission of `office`.")] = 20.0,
    seconds: Annotated[float, typer.Option(metavar="S", help="Length of `latency`.")] = 60.0,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Measure speed and accuracy on this machine. Without a name: `office` and `latency`."""
    results: dict[str, dict[str, Any]] = {}
    for name in names or ["office", "latency"]:
        if name not in _KNOWN:
            raise CommandError(f"there is no benchmark {name}; known are {', '.join(_KNOWN)}")
        results[name] = _measure(name, map_spec, minutes, seconds)
        if not as_json:
            print_table(name, results[name])
    if as_json:
        print_json(results)


def _measure(name: str, map_spec: str, minutes: float, seconds: float) -> dict[str, Any]:
    if name == "office":
        from server.benchmarks import office

        return office.measure(map_spec, minutes, seed=1)
    from server.benchmarks import latency

    return latency.measure(seconds=seconds)
