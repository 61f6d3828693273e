"""`waymark evaluate`: how far an estimated trajectory is from the truth."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from server.cli.console import CommandError, print_json, print_table
from server.cli.options import JsonOption, finite


def evaluate(
    estimate: Annotated[Path, typer.Argument(metavar="EST.tum", help="Estimated trajectory.")],
    truth: Annotated[Path, typer.Argument(metavar="TRUTH.tum", help="True trajectory.")],
    max_gap: Annotated[
        float, typer.Option(metavar="S", help="Leave out poses in gaps of the truth of S seconds or more.")
    ] = 0.5,
    interval: Annotated[
        float, typer.Option(metavar="S", help="Time over which the relative error is taken.")
    ] = 1.0,
    json: JsonOption = False,
) -> None:
    """Print the absolute (rigidly aligned) and the relative error of a trajectory in TUM format."""
    from robots.evaluation import EvaluationError, absolute_error, relative_error
    from robots.tum import TumError, read_tum

    finite("--max-gap", max_gap, above=0.0)
    finite("--interval", interval, above=0.0)
    try:
        estimated, true = read_tum(estimate), read_tum(truth)
        absolute = absolute_error(estimated, true, max_gap)
    except (TumError, EvaluationError) as error:
        raise CommandError(str(error)) from error
    result: dict[str, Any] = {
        "ate_m": absolute.rmse_m,
        "ate_max_m": absolute.max_m,
        "poses": absolute.poses,
        "relative_m": None,
        "relative_rad": None,
        "relative_interval_s": interval,
        "relative_pairs": 0,
    }
    try:
        relative = relative_error(estimated, true, interval, max_gap)
    except EvaluationError:
        pass  # too short for the interval: the absolute error stands all the same
    else:
        result |= {
            "relative_m": relative.translation_m,
            "relative_rad": relative.rotation_rad,
            "relative_pairs": relative.pairs,
        }
    if json:
        print_json(result)
    else:
        print_table(f"{estimate.name} against {truth.name}", result)
