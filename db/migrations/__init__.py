"""Bringing a database to the newest schema when it is opened, without Alembic's command line."""

from __future__ import annotations

from pathlib import Path

from alembic import command
from alembic.config import Config
from alembic.runtime.migration import MigrationContext
from alembic.script import ScriptDirectory
from sqlalchemy import Connection

from db.errors import DatabaseError


def migrate(connection: Connection, where: str) -> None:
    """Apply every migration that is missing, within the caller's transaction.

    Raises:
        DatabaseError: the schema is newer than this program; ``where`` names the database in the message.
    """
    config = alembic_config()
    scripts = ScriptDirectory.from_config(config)
    known = {revision.revision for revision in scripts.walk_revisions()}
    found = set(MigrationContext.configure(connection).get_current_heads())
    if found - known:
        raise DatabaseError(
            f"{where} was written by a newer Waymark (schema {', '.join(sorted(found - known))}); "
            "update Waymark, or choose another file with WAYMARK_DATABASE."
        )
    if found != set(scripts.get_heads()):
        config.attributes["connection"] = connection
        command.upgrade(config, "head")


def alembic_config() -> Config:
    """Return the configuration that points Alembic at this package."""
    config = Config()
    config.set_main_option("script_location", str(Path(__file__).parent))
    config.set_main_option("path_separator", "os")
    return config
