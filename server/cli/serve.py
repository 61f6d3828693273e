"""`waymark serve`: mission control for robots that come by themselves."""

from __future__ import annotations

import signal
import socket
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from server.cli.console import CommandError

if TYPE_CHECKING:
    from server.settings import Settings

HostOption = Annotated[
    str | None, typer.Option(metavar="ADDRESS", help="Address to listen on; 0.0.0.0 for every network.")
]
PortOption = Annotated[
    int | None, typer.Option(metavar="PORT", help="Port to listen on; 0 takes a free one.")
]
DataOption = Annotated[Path | None, typer.Option("--data", metavar="DIR", help="Folder of the database.")]


def serve(
    host: HostOption = None,
    port: PortOption = None,
    data: DataOption = None,
    database: Annotated[
        str | None, typer.Option(metavar="FILE|URL", help="Database, where it is not a file in --data.")
    ] = None,
    login: Annotated[
        str | None, typer.Option(metavar="on|off", help="Off only on this machine's own address.")
    ] = None,
    commander_link: Annotated[
        bool, typer.Option("--commander-link", help="Print a link for a commander, as when locked out.")
    ] = False,
    tls: Annotated[
        bool, typer.Option("--tls", help="Serve https with the certificate that waymark ca made.")
    ] = False,
    log_level: Annotated[
        str | None, typer.Option(metavar="LEVEL", help="Least level logged: DEBUG, INFO, WARNING, ERROR.")
    ] = None,
) -> None:
    """Serve mission control until Ctrl-C. What is not given comes from WAYMARK_... in the environment."""
    settings = make_settings(
        host=host,
        port=port,
        data_dir=data,
        database=database,
        login=login,
        commander_link=commander_link or None,
        tls=tls or None,
        log_level=log_level,
    )
    print(f"Waymark is opening at {settings.address} (Ctrl-C ends it).", flush=True)
    run_server(settings)


def make_settings(**given: Any) -> Settings:
    """Return the environment's settings, with what is given put over them, and a port that is free.

    Raises:
        CommandError: a setting is out of range, or the port is busy.
    """
    from pydantic import ValidationError

    from server.settings import Settings

    try:
        settings = Settings(**{name: value for name, value in given.items() if value is not None})
    except ValidationError as error:
        first = error.errors()[0]
        name = "_".join(str(part) for part in first["loc"])
        raise CommandError(f"setting {name} (WAYMARK_{name.upper()}): {first['msg']}") from error
    return settings.model_copy(update={"port": free_port(settings.host, settings.port)})


def free_port(host: str, port: int) -> int:
    """Return the port if nobody listens on it; a free one for 0.

    Raises:
        CommandError: it is busy, or the address is not this machine's.
    """
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:
        with socket.socket(family, socket.SOCK_STREAM) as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            probe.bind((host, port))
            return int(probe.getsockname()[1])
    except PermissionError as error:
        raise CommandError(
            f"port {port} is not for ordinary users; choose one above 1023 with --port"
        ) from error
    except socket.gaierror as error:
        raise CommandError(f"--host {host} is no address of this machine") from error
    except OSError as error:
        raise CommandError(
            f"cannot listen on {host} port {port} ({error.strerror}); choose another with --port"
        ) from error


def run_server(settings: Settings) -> None:
    """Run the server until it is told to end.

    Raises:
        CommandError: it cannot start.
    """
    from db.errors import DatabaseError
    from server.serve import run
    from server.tls.authority import AuthorityError

    # uvicorn ends gracefully, then sends itself the signal again, which has to leave through our contexts
    before = signal.signal(signal.SIGTERM, lambda *_: sys.exit(128 + signal.SIGTERM))
    try:
        settings.data_dir.mkdir(parents=True, exist_ok=True)
        run(settings)
    except (DatabaseError, AuthorityError) as error:
        raise CommandError(str(error)) from error
    except OSError as error:
        where = error.filename or settings.data_dir
        raise CommandError(f"{where}: {error.strerror or error}") from error
    finally:
        signal.signal(signal.SIGTERM, before)
