"""`waymark fit-radio`: what a recording says of a radio and its building."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

import typer

from server.cli.console import CommandError, print_json, print_table
from server.cli.options import JsonOption

_FORMATS = ("ble_danis", "log")


def fit_radio(
    dataset: Annotated[
        str,
        typer.Argument(
            metavar="DATASET",
            help="Format of the recording: ble_danis, a folder; log, a mission that waymark export wrote.",
        ),
    ],
    path: Annotated[Path, typer.Argument(metavar="PATH", help="The recording.")],
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.yaml", help="Write the radio there, as waymark simulate --radio takes it."
        ),
    ] = None,
    json: JsonOption = False,
) -> None:
    """Fit the path loss model to signals whose distances are known: p(d0) at 1 m, n, and sigma.

    Outliers are left out. sigma is of a reading; it is made of shadowing (of the place) and fading.
    """
    from robots.datasets import ble_danis, log_signals
    from robots.datasets.radio_file import write_radio
    from robots.datasets.recording import RecordingError
    from robots.estimation.radio.fit import FitError
    from robots.estimation.radio.fit import fit_radio as fit

    loaders = dict(zip(_FORMATS, (ble_danis.load_signals, log_signals.load_signals), strict=True))
    if dataset not in loaders:
        raise CommandError(f"there is no dataset {dataset!r} with signals; known are {', '.join(_FORMATS)}")
    try:
        found = fit(loaders[dataset](path))
        if out is not None:
            write_radio(out, found.settings)
    except RecordingError as error:
        raise CommandError(str(error)) from error
    except FitError as error:
        raise CommandError(f"{path}: {error}") from error
    result: dict[str, Any] = {**asdict(found), "out": None if out is None else str(out)}
    if json:
        print_json(result)
    else:
        print_table(f"Radio of {path.name}", result)
