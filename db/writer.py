"""One writer, one queue: every change of the database goes through here, in order.

SQLite lets one connection write at a time; several that try wait for each other and lose more than half of
their speed. So a write is a function taking the connection, and those that wait together share a transaction,
which is one trip to the writer's thread: handing over each statement would cost more than running it.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any, TypeVar

from sqlalchemy import Connection, Engine
from sqlalchemy.exc import DBAPIError

from db.errors import DatabaseError, explain

T = TypeVar("T")
_Outcome = tuple[Any, Exception | None]

_GROUP = 64  # writes that share a transaction at most: keeps each one short


@dataclass(slots=True)
class _Write:
    work: Callable[[Connection], Any]
    durable: bool
    answer: asyncio.Future[Any]


class Writer:
    """Runs queued write functions on one connection.

    Writes that wait at the same moment share a transaction. Where one of them fails, all are taken back and
    each is run again in a transaction of its own, so that it fails alone. A caller that is cancelled while it
    waits loses its answer, never the write.
    """

    def __init__(self, engine: Engine, where: str, set_durable: Callable[[Connection, bool], None]) -> None:
        self._engine = engine
        self._where = where
        self._set_durable = set_durable
        self._queue: asyncio.Queue[_Write | None] = asyncio.Queue()
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="database writer")
        self._task: asyncio.Task[None] | None = None
        self._durable = False
        self._closed = False

    def start(self) -> None:
        """Begin to take writes from the queue."""
        self._task = asyncio.create_task(self._run(), name="database writer")

    async def write(self, work: Callable[[Connection], T], *, durable: bool = False) -> T:
        """Run ``work`` in a transaction and return its result once it is committed.

        ``work`` changes nothing but the database: it may be run twice. ``durable``: on the disk before this
        returns, even if the power fails the next moment.

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
        self._thread.shutdown()

    async def _run(self) -> None:
        loop = asyncio.get_running_loop()
        last = False
        while not last:
            write = await self._queue.get()
            group: list[_Write] = []
            while write is not None:
                group.append(write)
                if len(group) == _GROUP or self._queue.empty():
                    break
                write = self._queue.get_nowait()
            last = write is None
            if group:
                outcomes = await loop.run_in_executor(self._thread, self._commit, group)
                for done, outcome in zip(group, outcomes, strict=True):
                    self._tell(done.answer, *outcome)

    def _commit(self, group: list[_Write]) -> list[_Outcome]:
        """Run writes in the writer's thread; whatever fails belongs to those who wait for it."""
        try:
            return [(result, None) for result in self._transaction(group)]
        except Exception as error:
            if len(group) == 1:
                return [(None, error)]
        return [self._commit([write])[0] for write in group]

    def _transaction(self, group: list[_Write]) -> list[Any]:
        with self._engine.connect() as connection:
            durable = any(write.durable for write in group)
            if durable != self._durable:
                self._set_durable(connection, durable)
                self._durable = durable
            with connection.begin():
                return [write.work(connection) for write in group]

    def _tell(self, answer: asyncio.Future[Any], result: Any, error: Exception | None) -> None:
        if answer.done():
            return
        if error is None:
            answer.set_result(result)
        else:
            answer.set_exception(explain(error, self._where) if isinstance(error, DBAPIError) else error)


def _retrieve(answer: asyncio.Future[Any]) -> None:
    if not answer.cancelled():
        answer.exception()
