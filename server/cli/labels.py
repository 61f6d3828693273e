"""`waymark labels`: sheets to print, one label for each tag."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

from server.cli.console import CommandError, say


def labels(
    first: Annotated[str, typer.Argument(metavar="FIRST", help="The first tag's id, such as A-001.")],
    site: Annotated[
        str, typer.Option("--host", metavar="URL", help="Where phones reach the server: https://NAME:PORT.")
    ],
    last: Annotated[str | None, typer.Argument(metavar="[LAST]", help="The last one's, A-040.")] = None,
    out: Annotated[Path, typer.Option(metavar="FILE.pdf", help="Write the sheets there.")] = Path(
        "labels.pdf"
    ),
    sheet: Annotated[Literal["a4", "letter"], typer.Option(help="Size of the paper.")] = "a4",
    per_sheet: Annotated[Literal["2", "4", "8"], typer.Option(help="Labels on a sheet.")] = "8",
) -> None:
    """Write a PDF of labels with a QR code, the number to type, and what to do in English and German.

    The lines are for a pen: a label is of use when no phone works. Print it in its own size (100 %).
    """
    from server.labels import FIT, LabelError, Sheet, numbered, write_pdf

    try:
        tag_ids = numbered(first, last)
        pages = write_pdf(out, tag_ids, site, Sheet(sheet, FIT[per_sheet]))
    except LabelError as error:
        raise CommandError(str(error)) from error
    except OSError as error:
        raise CommandError(f"{out}: {error.strerror}") from error
    say(f"{len(tag_ids)} label{'s' * (len(tag_ids) > 1)} on {pages} sheet{'s' * (pages > 1)}: {out}")
