"""`waymark export`: a mission's log as one file, from a database or from a running mission control."""

from __future__ import annotations

import asyncio
import os
from collections.abc import Awaitable, Callable
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from server.cli.console import CommandError, print_json, print_table, progress
from server.cli.options import DatabaseOption, JsonOption, ServerOption
from server.cli.serve import DataOption

if TYPE_CHECKING:
    from db.records import MissionRecord
    from db.store import Store
    from server.settings import Settings

_PIECE = 2**16  # bytes


def export(
    what: Annotated[str, typer.Argument(metavar="log", help="What to export: log.")],
    mission: Annotated[str, typer.Argument(metavar="MISSION", help="The mission's id.")],
    out: Annotated[Path, typer.Option(metavar="FILE", help="Where to write it.")],
    data: DataOption = None,
    database: DatabaseOption = None,
    server: ServerOption = None,
    json: JsonOption = False,
) -> None:
    """Write a mission's configuration and all that its robots observed to a file, for waymark replay log."""
    from server.cli.serve import make_settings

    if what != "log":
        raise CommandError(f"waymark export writes a log, not {what!r}")
    check_source(server, data, database)
    part = out.with_name(out.name + ".part")
    try:
        with part.open("wb") as file, progress() as display:
            task = display.add_task(f"exporting {mission}", total=None)

            def write(piece: bytes) -> None:
                file.write(piece)
                display.advance(task, len(piece))

            if server is not None:
                download(server, mission, "log", write)
            else:
                settings = make_settings(data_dir=data, database=database, port=0)
                read_database(settings, mission, _write_log(write))
        os.replace(part, out)
    except OSError as error:
        raise CommandError(f"--out {out}: cannot be written ({error.strerror or error})") from error
    finally:
        with suppress(OSError):
            part.unlink()
    result = _summary(mission, out)
    if json:
        print_json(result)
    else:
        print_table(f"log of {mission}", result)


def check_source(server: str | None, data: Path | None, database: str | None) -> None:
    """Refuse a server beside a database.

    Raises:
        CommandError: both were named.
    """
    if server is not None and (data is not None or database is not None):
        raise CommandError(
            "--server asks a mission control for what --data and --database name; leave them out"
        )


def read_database(
    settings: Settings, mission_id: str, work: Callable[[Store, MissionRecord], Awaitable[None]]
) -> None:
    """Do something with a mission of a database.

    Raises:
        CommandError: there is no such database or mission, or it cannot be read.
    """
    asyncio.run(_read_database(settings, mission_id, work))


async def _read_database(
    settings: Settings, mission_id: str, work: Callable[[Store, MissionRecord], Awaitable[None]]
) -> None:
    from db.errors import DatabaseError
    from db.store import Store

    target = settings.database_target
    if "://" not in target and not Path(target).exists():
        raise CommandError(f"there is no database {target}; name its folder with --data")
    try:
        store = await Store.open(target)
    except DatabaseError as error:
        raise CommandError(str(error)) from error
    try:
        missions = {record.mission_id: record for record in await store.missions.all_missions()}
        if mission_id not in missions:
            names = ", ".join(missions) or "none"
            raise CommandError(f"there is no mission {mission_id!r} in {target}; there are: {names}")
        await work(store, missions[mission_id])
    except DatabaseError as error:
        raise CommandError(str(error)) from error
    finally:
        await store.close()


def _write_log(write: Callable[[bytes], object]) -> Callable[[Store, MissionRecord], Awaitable[None]]:
    async def work(store: Store, record: MissionRecord) -> None:
        from server.mission_log import mission_log

        async for piece in mission_log(store, record):
            write(piece)

    return work


def download(url: str, mission_id: str, what: str, write: Callable[[bytes], object]) -> None:
    """Take something of a mission from a mission control; ``what`` is the last part of its address.

    Raises:
        CommandError: it cannot be reached, or refuses.
    """
    import json as json_module
    from http.client import HTTPException
    from urllib.error import HTTPError, URLError
    from urllib.parse import quote
    from urllib.request import Request, urlopen

    if not url.startswith(("http://", "https://")):
        raise CommandError(f"--server {url} is not the address of a server; it begins with http://")
    address = f"{url.rstrip('/')}/api/v1/missions/{quote(mission_id, safe='')}/{what}"
    try:
        token = os.environ.get("WAYMARK_TOKEN")
        headers = {"Authorization": f"Bearer {token}"} if token else {}
        with urlopen(Request(address, headers=headers), timeout=60.0) as reply:
            while piece := reply.read(_PIECE):
                write(piece)
    except HTTPError as error:
        try:
            message = str(json_module.loads(error.read(_PIECE))["error"]["message"])
        except (ValueError, KeyError, TypeError):
            message = f"{url} answers with {error.code}"
        raise CommandError(message) from error
    except URLError as error:
        raise CommandError(f"{url} cannot be reached ({error.reason})") from error
    except (HTTPException, ConnectionError, TimeoutError, ValueError) as error:
        raise CommandError(f"{url} broke off: {error or type(error).__name__}") from error


def _summary(mission: str, out: Path) -> dict[str, Any]:
    """Read back what was written: a file that cannot be replayed is no export."""
    from robots.datasets.log_lines import read_lines
    from robots.datasets.recording import RecordingError

    try:
        lines = sum(1 for _ in read_lines(out))
    except RecordingError as error:
        raise CommandError(str(error)) from error
    return {"mission_id": mission, "lines": lines, "bytes": out.stat().st_size, "out": str(out)}
