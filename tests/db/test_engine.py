"""A database that cannot be used is named in one sentence, and left exactly as it was."""

from __future__ import annotations

import asyncio
import sqlite3
from pathlib import Path

import pytest

from db.engine import Database
from db.errors import DatabaseError, explain
from db.store import Store


def _refused(path: Path) -> str:
    async def scenario() -> None:
        await (await Database.open(path)).close()

    with pytest.raises(DatabaseError) as error:
        asyncio.run(scenario())
    message = str(error.value)
    assert str(path) in message
    assert message.endswith(".")
    assert "\n" not in message
    return message


def test_a_file_that_is_no_database(tmp_path: Path) -> None:
    path = tmp_path / "notes.db"
    path.write_bytes(b"these are the notes of the night shift\n" * 100)
    before = path.read_bytes()
    assert "not a Waymark database" in _refused(path)
    assert path.read_bytes() == before


def test_a_damaged_database(tmp_path: Path) -> None:
    path = tmp_path / "mission.db"

    async def fill() -> None:
        await (await Database.open(path)).close()

    asyncio.run(fill())
    data = bytearray(path.read_bytes())
    data[4096:20480] = b"\xa5" * (20480 - 4096)
    path.write_bytes(data)
    assert "damaged" in _refused(path)
    assert path.read_bytes() == bytes(data)


def test_a_database_of_another_program(tmp_path: Path) -> None:
    path = tmp_path / "other.db"
    with sqlite3.connect(path) as connection:
        connection.execute("CREATE TABLE recipes (name TEXT)")
    connection.close()
    before = path.read_bytes()
    assert "another program" in _refused(path)
    assert path.read_bytes() == before


def test_a_database_of_a_newer_version(tmp_path: Path) -> None:
    path = tmp_path / "newer.db"

    async def fill() -> None:
        await (await Store.open(path)).close()

    asyncio.run(fill())
    with sqlite3.connect(path) as connection:
        connection.execute("UPDATE alembic_version SET version_num = '9999'")
    connection.close()
    assert "newer Waymark (schema 9999)" in _refused(path)


def test_a_database_in_use_by_another_server(tmp_path: Path) -> None:
    path = tmp_path / "shared.db"

    async def scenario() -> None:
        first = await Database.open(path)
        with pytest.raises(DatabaseError, match="in use by another Waymark server"):
            await Database.open(path)
        await first.close()
        await (await Database.open(path)).close()

    asyncio.run(scenario())


def test_a_folder_in_place_of_the_file(tmp_path: Path) -> None:
    path = tmp_path / "folder.db"
    path.mkdir()
    assert "cannot be opened" in _refused(path)


def test_a_file_in_place_of_the_folder(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("x")
    assert "failed" in _refused(tmp_path / "file" / "x.db")


@pytest.mark.parametrize(
    ("said", "way_out"),
    [
        ("database is locked", "close that program"),
        ("attempt to write a readonly database", "writable"),
        ("database or disk is full", "free space"),
        ("database disk image is malformed", "backup"),
    ],
)
def test_every_cause_names_the_way_out(said: str, way_out: str) -> None:
    message = str(explain(sqlite3.OperationalError(said), "mission.db"))
    assert message.startswith("mission.db ")
    assert way_out in message
