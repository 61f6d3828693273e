"""What an experiment is: rows measured over seeded runs, a table beside the paper's, a plot."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

Value = float | int | str | bool | None
Row = dict[str, Value]  # flat, units in the names


class ExperimentError(ValueError):
    """An experiment cannot be made as asked; the message is one sentence that says what is missing."""


def _ignore(done: int, total: int) -> None:
    """Report progress to nobody."""


@dataclass(frozen=True, slots=True)
class Options:
    """How an experiment is to be made.

    ``runs`` repetitions, each drawing from (``seed``, its number) alone; ``jobs`` processes at once, which
    change nothing in the rows; ``data`` the folder with recordings; ``maps`` are map_server YAML files or
    office:AREA, in place of the experiment's own; ``progress`` is told steps done and to do.
    """

    runs: int
    seed: int = 0
    jobs: int = 1
    data: Path | None = None
    maps: tuple[str, ...] = ()
    progress: Callable[[int, int], None] = _ignore


@dataclass(frozen=True, slots=True)
class Column:
    """A column of the printed table: the row's ``value``, and its ``deviation`` over the runs where given."""

    title: str
    value: str
    deviation: str | None = None
    digits: int = 2


@dataclass(frozen=True, slots=True)
class Experiment:
    """One table or figure of a paper.

    ``paper`` says where it is printed; ``notes`` stand under the table and say what the columns compare.
    ``run`` raises ExperimentError where something is missing; ``plot`` draws its rows to a file whose suffix
    names the format. ``takes_maps``: it can be made on other maps.
    """

    name: str
    summary: str
    paper: str
    default_runs: int
    run: Callable[[Options], list[Row]]
    plot: Callable[[list[Row], Path], None]
    columns: tuple[Column, ...]
    notes: tuple[str, ...] = ()
    takes_maps: bool = False


def finite(row: Row, name: str) -> float:
    """Return a number of a row; NaN where there is none.

    Raises:
        TypeError: the row holds something else under that name.
    """
    value = row.get(name)
    if value is None:
        return float("nan")
    if isinstance(value, str):
        raise TypeError(f"{name} is {value!r}, not a number")
    return float(value)
