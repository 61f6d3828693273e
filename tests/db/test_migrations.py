"""The migrations lead to exactly the tables that the code uses."""

from __future__ import annotations

import asyncio
from pathlib import Path

from alembic.autogenerate import compare_metadata
from alembic.runtime.migration import MigrationContext
from sqlalchemy import Connection

from db import history_tables, mission_tables, people_tables, tables  # noqa: F401 - they fill the metadata
from db.engine import Database
from db.migrations import migrate
from db.schema import metadata


def test_migrations_make_the_tables(tmp_path: Path) -> None:
    def difference(connection: Connection) -> list[object]:
        return list(compare_metadata(MigrationContext.configure(connection), metadata))

    async def scenario() -> list[object]:
        database = await Database.open(tmp_path / "m.db")
        found = await database.read(difference)
        await database.write(lambda connection: migrate(connection, "m.db"))  # again: nothing to do
        await database.close()
        return found

    assert asyncio.run(scenario()) == []
