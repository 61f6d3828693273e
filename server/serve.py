"""Running the application until it is told to end."""

from __future__ import annotations

import asyncio
from contextlib import ExitStack

import uvicorn

from db.store import Store
from server.app import create_app
from server.logs import configure_logging
from server.settings import Settings

_GRACE_S = 1


def run(settings: Settings) -> None:
    """Serve until SIGINT or SIGTERM; open requests have a second to end.

    Raises:
        DatabaseError: the database cannot be used.
        AuthorityError: https is asked for, and there is no authority.
        OSError: the port for phones that install the authority is taken.
    """
    configure_logging(settings.log_level)
    asyncio.run(_try_database(settings))  # an error here is one sentence; inside the server, a traceback
    with ExitStack() as stack:
        config = uvicorn.Config(
            create_app(settings),
            host=settings.host,
            port=settings.port,
            log_level=settings.log_level.lower(),
            access_log=False,
            ws_per_message_deflate=False,
            ws_max_size=65_536,
            ws_ping_interval=10.0,  # who answers none for 20 s reads nothing: it is dropped
            ws_ping_timeout=20.0,
            timeout_graceful_shutdown=_GRACE_S,
        )
        if settings.tls:
            _encrypt(config, settings, stack)
        uvicorn.Server(config).run()  # exits with 3 where it cannot start, having said why


def _encrypt(config: uvicorn.Config, settings: Settings, stack: ExitStack) -> None:
    from server.tls.authority import Authority
    from server.tls.install import certificate_at

    authority = Authority(settings.tls_folder)
    authority.renew()
    config.ssl_certfile, config.ssl_keyfile = authority.server_certificate, authority.server_key
    certificate = authority.certificate.read_bytes()
    stack.enter_context(certificate_at(settings.host, settings.install_port, certificate, settings.port))


async def _try_database(settings: Settings) -> None:
    store = await Store.open(settings.database_target)
    await store.close()
