"""Options that several subcommands share, and the checks of what was given for them."""

from __future__ import annotations

import math
import os
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from server.cli.console import CommandError

DatabaseOption = Annotated[
    str | None, typer.Option(metavar="FILE|URL", help="Database, where it is not a file in --data.")
]
ServerOption = Annotated[
    str | None, typer.Option(metavar="URL", help="Ask this mission control, which may go on meanwhile.")
]
JsonOption = Annotated[bool, typer.Option("--json", help="Print one JSON object on stdout and nothing else.")]
OutOption = Annotated[
    Path | None, typer.Option(metavar="DIR", help="Write trajectories, tags.csv, map.png and map.yaml there.")
]
TAGS_PANEL = "Tags and radios"


class Tags(StrEnum):
    """The hardware of the tags."""

    NEAR = "near"
    UHF = "uhf"
    NODE = "node"


class Memory(StrEnum):
    """What robots leave in the tags beside coverage."""

    NONE = "none"
    TAGS = "tags"


TagsOption = Annotated[
    Tags,
    typer.Option(
        help="Read from above, by radio in sight to 4 m, or active to 35 m.", rich_help_panel=TAGS_PANEL
    ),
]
EnvironmentOption = Annotated[
    str,
    typer.Option(
        metavar="NAME", help="open, office1, office2, grocery or retail.", rich_help_panel=TAGS_PANEL
    ),
]
TagsInPlaceOption = Annotated[
    int, typer.Option(metavar="N", help="Tags in place at the start.", rich_help_panel=TAGS_PANEL)
]
SlamOption = Annotated[
    str | None,
    typer.Option(
        metavar="[ROBOT=]KIND,...",
        help="Kind of SLAM: of all robots, or of each, as in r1=odometry,tag-graph.",
        rich_help_panel=TAGS_PANEL,
    ),
]
MemoryOption = Annotated[
    Memory, typer.Option(help="Whether robots leave maps of tags in the tags.", rich_help_panel=TAGS_PANEL)
]


TagBitsOption = Annotated[
    int | None,
    typer.Option(
        metavar="N", help="Capacity of a tag; that of its kind by default.", rich_help_panel=TAGS_PANEL
    ),
]
ExploreOption = Annotated[
    str,
    typer.Option(
        metavar="[ROBOT=]NAME,...",
        help="How robots choose where to go: nearest, information-gain, waymark, ...; one without a robot is"
        " for all others, as in r1=nearest,waymark.",
    ),
]
CoordinateOption = Annotated[
    str,
    typer.Option(
        metavar="[ROBOT=]NAME,...",
        help="How robots that hear each other share out where to go: none, random, simplified, original,"
        " burgard, exclusion, hungarian, voronoi or node-counting (which counts in tags).",
    ),
]
CommunicationOption = Annotated[
    str,
    typer.Option(
        metavar="[ROBOT=]NAME,...",
        help="Whom robots hear: none, tags (through their memories alone), full (all of them always) or"
        " radio (those in reach).",
    ),
]
RadioRangeOption = Annotated[
    float,
    typer.Option(metavar="METRES", help="How far robots that talk by radio hear each other in the open."),
]


def finite(name: str, value: float, above: float | None = None, at_least: float | None = None) -> float:
    """Return the value of an option if it is a number in range.

    Raises:
        CommandError: it is not; the sentence names the option.
    """
    if not math.isfinite(value):
        raise CommandError(f"{name} has to be a finite number, not {value}")
    if above is not None and value <= above:
        raise CommandError(f"{name} has to be greater than {above:g}, not {value:g}")
    if at_least is not None and value < at_least:
        raise CommandError(f"{name} has to be {at_least:g} or more, not {value:g}")
    return value


def check_writable(folder: Path | None) -> None:
    """Create the folder for the results, before the work that they take.

    Raises:
        CommandError: nothing can be written there.
    """
    if folder is None:
        return
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise CommandError(f"--out {folder}: cannot create the folder ({error.strerror})") from error
    if not os.access(folder, os.W_OK):
        raise CommandError(f"--out {folder}: the folder cannot be written to")
