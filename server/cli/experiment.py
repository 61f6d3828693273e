"""`waymark experiment`: a table or figure of the papers, measured here and set beside theirs."""

from __future__ import annotations

import json as jsonlib
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from server.cli.console import CommandError, plain, progress

if TYPE_CHECKING:
    from robots.experiments.experiment import Experiment, Row, Value

_MOST_RUNS, _MOST_JOBS = 100_000, 256
_FILE_WIDTH = 200  # of a table that is not printed on a terminal


def experiment(
    name: Annotated[
        str | None, typer.Argument(metavar="[NAME]", help="Which; without a name they are listed.")
    ] = None,
    runs: Annotated[
        int | None, typer.Option(metavar="N", help="Repetitions; each experiment has a default.")
    ] = None,
    seed: Annotated[int, typer.Option(metavar="S", help="The same seed gives the same rows.")] = 0,
    jobs: Annotated[int, typer.Option(metavar="J", help="Processes at once; the rows stay the same.")] = 1,
    json: Annotated[
        Path | None, typer.Option(metavar="FILE", help='Write {"rows": [...]} there; - is stdout.')
    ] = None,
    plot: Annotated[Path | None, typer.Option(metavar="FILE", help="Draw it: .png, .pdf or .svg.")] = None,
    data: Annotated[Path, typer.Option(metavar="DIR", help="Folder with recordings.")] = Path(
        "../shared/data"
    ),
    maps: Annotated[
        list[str] | None,
        typer.Option("--map", metavar="FILE.yaml|office:AREA", help="In place of its own; may be repeated."),
    ] = None,
) -> None:
    """Measure what a paper prints, mean and deviation over runs, and print ours beside it."""
    from robots.experiments.experiment import ExperimentError, Options
    from robots.experiments.plotting import check_plot
    from robots.experiments.registry import EXPERIMENTS

    if name is None:
        _list(list(EXPERIMENTS.values()))
        return
    if name not in EXPERIMENTS:
        raise CommandError(f"there is no experiment {name}; known are {', '.join(EXPERIMENTS)}")
    chosen = EXPERIMENTS[name]
    runs = chosen.default_runs if runs is None else runs
    _check("--runs", runs, 1, _MOST_RUNS)
    _check("--seed", seed, 0, 2**63 - 1)
    _check("--jobs", jobs, 1, _MOST_JOBS)
    if maps and not chosen.takes_maps:
        raise CommandError(f"{name} is made on maps of its own; leave --map out")
    to_stdout = json is not None and str(json) == "-"
    try:
        if plot is not None:
            check_plot(plot)
        if json is not None and not to_stdout:
            _check_file("--json", json)
        with progress() as display:
            task = display.add_task(f"measuring {name}", total=None)

            def show(done: int, total: int) -> None:
                display.update(task, completed=done, total=total)

            rows = chosen.run(Options(runs, seed, jobs, data, tuple(maps or ()), show))
        if json is not None:
            _write_json(json, rows, to_stdout)
        if plot is not None:
            chosen.plot(rows, plot)
    except ExperimentError as error:
        raise CommandError(str(error)) from error
    if not to_stdout:
        _print(chosen, rows)


def _check(option: str, value: int, low: int, high: int) -> None:
    if not low <= value <= high:
        raise CommandError(f"{option} {value} is out of range; give {low} to {high}")


def _check_file(option: str, path: Path) -> None:
    """Refuse a file that could not be written, before the work whose result it is to take."""
    if path.is_dir():
        raise CommandError(f"{option} {path} is a folder; name a file")
    if not path.absolute().parent.is_dir():
        raise CommandError(f"{option} {path}: there is no folder {path.parent}")


def _write_json(path: Path, rows: list[Row], to_stdout: bool) -> None:
    text = jsonlib.dumps(plain({"rows": rows}), allow_nan=False)
    if to_stdout:
        print(text, flush=True)
        return
    try:
        path.write_text(text + "\n")
    except OSError as error:
        raise CommandError(f"--json {path}: cannot be written ({error.strerror})") from error


def _list(experiments: list[Experiment]) -> None:
    from rich.console import Console
    from rich.table import Table

    table = Table(show_header=False, box=None, padding=(0, 2, 0, 0))
    table.add_column(style="bold", no_wrap=True)
    for each in experiments:
        table.add_row(each.name, f"{each.summary} ({each.paper}; {each.default_runs} runs)")
    Console().print(table)


def _print(chosen: Experiment, rows: list[Row]) -> None:
    from rich.console import Console
    from rich.table import Table

    table = Table(title=f"{chosen.name}: {chosen.paper}", title_justify="left")
    for column in chosen.columns:
        is_text = any(isinstance(row.get(column.value), str) for row in rows)
        table.add_column(column.title, justify="left" if is_text else "right")
    for row in rows:
        once = row.get("runs") == 1  # then there is no deviation
        table.add_row(
            *(
                _text(row.get(column.value), None if once else row.get(column.deviation or ""), column.digits)
                for column in chosen.columns
            )
        )
    console = Console()
    if not console.is_terminal:
        console = Console(width=_FILE_WIDTH)
    console.print(table)
    for note in chosen.notes:
        console.print(note)


def _text(value: Value, deviation: Value, digits: int) -> str:
    if value is None:
        return "-"
    if isinstance(value, str | bool | int):
        return str(value)
    text = f"{value:.{digits}f}"
    return f"{text} ± {deviation:.{digits}f}" if isinstance(deviation, float) else text
