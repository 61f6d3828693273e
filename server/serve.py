"""Running the application until it is told to end."""

from __future__ import annotations

import asyncio

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
    """
    configure_logging(settings.log_level)
    asyncio.run(_try_database(settings))  # an error here is one sentence; inside the server, a traceback
    config = uvicorn.Config(
        create_app(settings),
        host=settings.host,
        port=settings.port,
        log_level=settings.log_level.lower(),
        access_log=False,
        ws_per_message_deflate=False,
        ws_max_size=65_536,
        timeout_graceful_shutdown=_GRACE_S,
    )
    uvicorn.Server(config).run()  # exits with 3 where it cannot start, having said why


async def _try_database(settings: Settings) -> None:
    store = await Store.open(settings.database_target)
    await store.close()
