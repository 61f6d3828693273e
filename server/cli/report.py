"""`waymark report`: a mission's report as one HTML file, from a database or a running mission control."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from server.cli.console import CommandError, say
from server.cli.export import check_source, download, read_database
from server.cli.options import DatabaseOption, ServerOption
from server.cli.serve import DataOption, make_settings

if TYPE_CHECKING:
    from db.records import MissionRecord
    from db.store import Store


def report(
    mission: Annotated[str, typer.Argument(metavar="MISSION", help="The mission's id.")],
    out: Annotated[Path, typer.Option(metavar="FILE.html", help="Where to write it.")],
    data: DataOption = None,
    database: DatabaseOption = None,
    server: ServerOption = None,
) -> None:
    """Write a mission's report: plan, film, victims, robots, alerts, notes, tags and timeline in one file."""
    check_source(server, data, database)
    part = out.with_name(out.name + ".part")
    try:
        with part.open("wb") as file:
            if server is not None:
                download(server, mission, "report.html", file.write)
            else:
                settings = make_settings(data_dir=data, database=database, port=0)
                read_database(settings, mission, _write_to(file))
        os.replace(part, out)
    except OSError as error:
        raise CommandError(f"--out {out}: cannot be written ({error.strerror or error})") from error
    finally:
        with suppress(OSError):
            part.unlink()
    say(f"The report of {mission} is in {out} ({out.stat().st_size / 1e6:.1f} MB).")


def _write_to(file: Any) -> Any:
    async def work(store: Store, record: MissionRecord) -> None:
        from server.report.make import make_report

        file.write((await make_report(store, record)).encode())

    return work
