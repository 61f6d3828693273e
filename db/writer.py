"""One writer, one queue: every change of the database goes through here, in order.

SQLite lets one connection write at a time; several that try wait for each other and lose more than half of
their speed. So a write is a function taking the connection, and those that wait together share a transaction.
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import Any, TypeVar

from sqlalchemy import Connection
from sqlalchemy.exc import DBAPIError
from sqlalchemy.ext.asyncio import AsyncConnection, AsyncEngine

from db.errors import DatabaseError, explain

T = TypeVar("T")

_GROUP = 64  # writes that share a transaction at most: keeps each one short


@dataclass(slots=True)
class _Write:
    work: Callable[[Connection], Any]
    durable: bool
    answer: asyncio.Future[Any]


class Writer:
    """Runs queued write functions on one connection.

    Writes that wait at the same moment share a transaction, each in a savepoint of its own, so that one that
    fails fails alone. A caller that is cancelled while it waits loses its answer, never the write.
    """

    def __init__(
        self,
        engine: AsyncEngine,
        where: str,
        set_durable: Callable[[AsyncConnection, bool], Awaitable[None]],
    ) -> None:
        self._engine = engine
        self._where = where
        self._set_durable = set_durable
        self._queue: asyncio.Queue[_Write | None] = asyncio.Queue()
        self._task: asyncio.Task[None] | None = None
        self._durable = False
        self._closed = False

    def start(self) -> None:
        """Begin to take writes from the queue."""
        self._task = asyncio.create_task(self._run(), name="database writer")

    async def write(self, work: Callable[[Connection], T], *, durable: bool = False) -> T:
        """Run ``work`` in a transaction and return its result once it is committed.

        ``durable``: on the disk before this returns, even if the power fails the next moment.

        Raises:
            DatabaseError: the database could not take it; nothing of this write remains.
        """
        if self._closed:
            raise DatabaseError(f"{self._where} is closed; nothing more can be written.")
        answer: asyncio.Future[T] = asyncio.get_running_loop().create_future()
        answer.add_done_callback(_retrieve)
        self._queue.put_nowait(_Write(work, durable, answer))
        return await asyncio.shield(answer)

    async def close(self) -> None:
        """Finish all accepted writes, then stop."""
        self._closed = True
        if self._task is not None:
            self._queue.put_nowait(None)
            await self._task
            self._task = None

    async def _run(self) -> None:
        while True:
            write = await self._queue.get()
            if write is None:
                return
            group, last = [write], False
            while len(group) < _GROUP and not self._queue.empty():
                following = self._queue.get_nowait()
                if following is None:
                    last = True
                    break
                group.append(following)
            await self._commit(group)
            if last:
                return

    async def _commit(self, group: list[_Write]) -> None:
        try:
            async with self._engine.connect() as connection:
                durable = any(write.durable for write in group)
                if durable != self._durable:
                    await self._set_durable(connection, durable)
                    self._durable = durable
                async with connection.begin():
                    outcomes = await connection.run_sync(_run_group, group)
        except Exception as error:  # whatever fails belongs to those who wait for it, not to this loop
            for write in group:
                _fail(write, error, self._where)
            return
        for write, (result, failure) in zip(group, outcomes, strict=True):
            if failure is not None:
                _fail(write, failure, self._where)
            elif not write.answer.done():
                write.answer.set_result(result)


def _run_group(connection: Connection, group: list[_Write]) -> list[tuple[Any, Exception | None]]:
    if len(group) == 1:
        return [(group[0].work(connection), None)]
    outcomes: list[tuple[Any, Exception | None]] = []
    for write in group:
        try:
            with connection.begin_nested():
                outcomes.append((write.work(connection), None))
        except Exception as error:
            outcomes.append((None, error))
    return outcomes


def _fail(write: _Write, error: Exception, where: str) -> None:
    if not write.answer.done():
        write.answer.set_exception(explain(error, where) if isinstance(error, DBAPIError) else error)


def _retrieve(answer: asyncio.Future[Any]) -> None:
    if not answer.cancelled():
        answer.exception()
