"""Opening a database, and the only place that knows it is SQLite (or PostgreSQL)."""

from __future__ import annotations

import asyncio
import fcntl
import sqlite3
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import IO, Any, TypeVar

from sqlalchemy import URL, Connection, Engine, Table, create_engine, event, make_url
from sqlalchemy.dialects import postgresql, sqlite
from sqlalchemy.exc import DBAPIError

from db.errors import DatabaseError, explain
from db.migrations import migrate
from db.writer import Writer

T = TypeVar("T")

_BUSY_TIMEOUT_MS = 5_000
_READERS = 4
_CHECK_WHOLE_FILE_BELOW = 32 * 2**20  # reading all of a larger file would delay the start too long


class Database:
    """A database with one writer and several readers; the schema is brought up to date when it is opened."""

    def __init__(self, url: URL, where: str, lock: IO[bytes] | None) -> None:
        self.where = where
        self._lock = lock
        is_sqlite = url.get_backend_name() == "sqlite"
        self._writing = _engine(url, pool_size=1, writes=True)
        self._reading = _engine(url, pool_size=_READERS, writes=False)
        self._readers = ThreadPoolExecutor(_READERS, thread_name_prefix="database reader")
        self._writer = Writer(self._writing, where, _set_sqlite_sync if is_sqlite else _set_postgresql_sync)

    @classmethod
    async def open(cls, target: str | Path) -> Database:
        """Open or create the database in a file, or at a URL, and migrate it to the newest schema.

        Raises:
            DatabaseError: the file is damaged, not ours, newer than this program, in use by another
                server or not writable. It is left as it is.
        """
        url = _url(target)
        path = Path(url.database) if url.get_backend_name() == "sqlite" and url.database else None
        where = str(path) if path else url.render_as_string(hide_password=True)
        lock = await asyncio.to_thread(_check_file, path) if path else None
        database = cls(url, where, lock)
        try:
            await asyncio.to_thread(_migrate, database._writing, where)
        except DBAPIError as error:
            await database._release()
            raise explain(error, where) from error
        except BaseException:
            await database._release()
            raise
        database._writer.start()
        return database

    async def write(self, work: Callable[[Connection], T], *, durable: bool = False) -> T:
        """Run a write function in a transaction of the one writer; see ``Writer.write``."""
        return await self._writer.write(work, durable=durable)

    async def read(self, work: Callable[[Connection], T]) -> T:
        """Run a function that only reads, on a connection of its own.

        Raises:
            DatabaseError: the database cannot be read.
        """
        return await asyncio.get_running_loop().run_in_executor(self._readers, self._read, work)

    async def close(self) -> None:
        """Finish every accepted write and let go of the file."""
        await self._writer.close()
        await self._release()

    def _read(self, work: Callable[[Connection], T]) -> T:
        try:
            with self._reading.connect() as connection:
                return work(connection)
        except DBAPIError as error:
            raise explain(error, self.where) from error

    async def _release(self) -> None:
        await asyncio.to_thread(self._readers.shutdown)
        self._reading.dispose()
        self._writing.dispose()
        if self._lock is not None:
            self._lock.close()


def upsert(
    connection: Connection, table: Table, rows: Iterable[dict[str, Any]], *, keep: Iterable[str] = ()
) -> None:
    """Insert rows, or update those whose primary key is there; columns in ``keep`` then stay as they were."""
    rows = list(rows)
    if not rows:
        return
    insert = _insert(connection, table)
    key = [column.name for column in table.primary_key]
    frozen = {*key, *keep}
    changes = {name: insert.excluded[name] for name in rows[0] if name not in frozen}
    connection.execute(insert.on_conflict_do_update(index_elements=key, set_=changes), rows)


def insert_missing(connection: Connection, table: Table, rows: Iterable[dict[str, Any]]) -> None:
    """Insert rows; those whose primary key is already there change nothing."""
    rows = list(rows)
    if rows:
        connection.execute(_insert(connection, table).on_conflict_do_nothing(), rows)


def _insert(connection: Connection, table: Table) -> Any:
    dialect = {"sqlite": sqlite, "postgresql": postgresql}[connection.dialect.name]
    return dialect.insert(table)


def _url(target: str | Path) -> URL:
    if isinstance(target, str) and "://" in target:
        return make_url(target)
    return URL.create("sqlite", database=str(target))


def _engine(url: URL, *, pool_size: int, writes: bool) -> Engine:
    engine = create_engine(url, pool_size=pool_size, max_overflow=0)
    if url.get_backend_name() == "sqlite":
        # The driver's own transaction handling begins late and never IMMEDIATE: it is switched off
        # (isolation_level None) and the BEGIN is ours. A write then waits for the lock at its start, never
        # fails half way.
        @event.listens_for(engine, "connect")
        def _connect(connection: Any, _record: Any) -> None:
            connection.isolation_level = None
            cursor = connection.cursor()
            cursor.execute(f"PRAGMA busy_timeout = {_BUSY_TIMEOUT_MS}")
            cursor.execute("PRAGMA journal_mode = WAL")
            cursor.execute("PRAGMA synchronous = NORMAL")
            cursor.execute("PRAGMA foreign_keys = ON")
            if not writes:
                cursor.execute("PRAGMA query_only = ON")
            cursor.close()

        @event.listens_for(engine, "begin")
        def _begin(connection: Connection) -> None:
            connection.exec_driver_sql("BEGIN IMMEDIATE" if writes else "BEGIN")

    return engine


def _migrate(engine: Engine, where: str) -> None:
    with engine.begin() as connection:
        migrate(connection, where)


def _set_sqlite_sync(connection: Connection, durable: bool) -> None:
    # On the driver's connection: the pragma is ignored inside a transaction, and SQLAlchemy would begin one.
    cursor = connection.connection.cursor()
    cursor.execute(f"PRAGMA synchronous = {'FULL' if durable else 'NORMAL'}")
    cursor.close()


def _set_postgresql_sync(connection: Connection, durable: bool) -> None:
    connection.exec_driver_sql(f"SET synchronous_commit = {'on' if durable else 'off'}")
    connection.commit()


def _check_file(path: Path) -> IO[bytes]:
    """Refuse a file that is not ours or not whole before anything is written to it; return the held lock."""
    where = str(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        lock = open(path.with_name(path.name + ".lock"), "ab")  # noqa: SIM115 - held until the database is closed
    except OSError as error:
        raise explain(error, where) from error
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        if path.exists():
            _check_content(path)
    except BlockingIOError as error:
        lock.close()
        raise DatabaseError(
            f"{where} is in use by another Waymark server; stop that one or choose another WAYMARK_DATABASE."
        ) from error
    except (OSError, sqlite3.Error) as error:
        lock.close()
        raise explain(error, where) from error
    except BaseException:
        lock.close()
        raise
    return lock


def _check_content(path: Path) -> None:
    connection = sqlite3.connect(path, timeout=_BUSY_TIMEOUT_MS / 1000.0)
    try:
        tables = {row[0] for row in connection.execute("SELECT name FROM sqlite_schema WHERE type = 'table'")}
        if tables and "alembic_version" not in tables:
            raise DatabaseError(
                f"{path} is a database of another program; choose another file with WAYMARK_DATABASE."
            )
        if path.stat().st_size < _CHECK_WHOLE_FILE_BELOW:
            found = connection.execute("PRAGMA quick_check(1)").fetchone()[0]
            if found != "ok":
                raise sqlite3.DatabaseError(f"malformed: {found}")
    finally:
        connection.close()
