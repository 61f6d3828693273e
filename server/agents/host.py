"""One robot's agent in a process of its own, brought back whole whenever that process dies.

``handle`` answers in any case: if the process is killed in between, a new one is restored from the snapshot,
the log since then is replayed, and the question is asked again. The agent is a function of its log, so the
answers are the same.
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import structlog

from db.errors import DatabaseError
from server.agents.forkserver import AGENT
from server.agents.frames import Kind
from server.agents.process import ForkServer, Worker, WorkerDiedError
from server.agents.worker import TAKEN

_CHUNK = 16  # observations per frame: few enough that a poisonous one is found soon
_STARTING_S, _ASKING_S = 90.0, 30.0
_POISON_DEATHS = 3
_TROUBLE_FAILURES = 5  # in a row: more than a poisonous observation causes
_LONGEST_PAUSE_S = 5.0

log = structlog.get_logger()


@dataclass(frozen=True, slots=True)
class Answer:
    """What the agent made of one observation: an encoded update, or the reason why there is none."""

    seq: int
    update: bytes | None
    reason: str = ""


class AgentLog(Protocol):
    """Where a host finds what its agent has been told."""

    async def snapshot(self) -> tuple[int, bytes] | None:
        """Return the seq of the last observation in the latest snapshot, and the snapshot."""

    def observations(self, after: int, until: int) -> AsyncIterator[tuple[int, bytes]]:
        """Yield (seq, encoded observation) of the log in order."""

    async def record_fault(self, seq: int, reason: str) -> bytes:
        """Mark an observation that the agent cannot survive; return an empty one to take its place."""


class AgentHost:
    """Keeps one agent alive. ``done_seq`` is the last observation it has answered for."""

    def __init__(
        self,
        forks: ForkServer,
        robot_id: str,
        config: bytes,
        agent_log: AgentLog,
        *,
        done_seq: int = -1,
        on_restart: Callable[[str], None],
        on_trouble: Callable[[str], None],
    ) -> None:
        self.done_seq = done_seq
        self.restarts = 0
        self.failures = 0  # starts and questions that failed since the last that worked
        self.on_replayed: Callable[[Answer], None] | None = None
        self._forks = forks
        self._robot_id = robot_id
        self._config = config
        self._log = agent_log
        self._on_restart = on_restart
        self._on_trouble = on_trouble
        self._unclaimed: list[Answer] = []  # of a call that failed half way
        self._lock = asyncio.Lock()
        self._worker: Worker | None = None
        self._watch: asyncio.Task[None] | None = None
        self._trust_snapshot = True
        self._reason = ""

    @property
    def pid(self) -> int | None:
        """The process that holds the agent now."""
        return None if self._worker is None or self._worker.lost.is_set() else self._worker.pid

    async def handle(self, batch: Sequence[tuple[int, bytes]]) -> list[Answer]:
        """Return what the agent makes of observations that follow the ones it has answered for.

        One answer each, after the answers that an earlier call owes because it failed half way.
        """
        async with self._lock:
            todo = [record for record in batch if record[0] > self.done_seq]
            if todo and todo[0][0] > self.done_seq + 1:  # logged, but given up before it was asked
                missing = [record async for record in self._log.observations(self.done_seq, todo[0][0] - 1)]
                todo[:0] = missing
            await self._work_off(todo)
            answers, self._unclaimed = self._unclaimed, []
            return answers

    async def unanswered(self, until: int) -> list[tuple[int, bytes]]:
        """Return what is in the log up to a seq and has not been answered for."""
        return [record async for record in self._log.observations(self.done_seq, until)]

    async def snapshot(self) -> tuple[int, bytes]:
        """Return the last observation's seq and the agent's whole state after it.

        Raises:
            WorkerDiedError: the process died; it is brought back by whatever comes next.
        """
        async with self._lock:
            worker = await self._alive()
            return self.done_seq, (await worker.ask(Kind.SNAPSHOT, timeout_s=_ASKING_S))[0]

    async def report(self) -> bytes | None:
        """Return the latest update with everything in it, None before the first observation.

        Raises:
            WorkerDiedError: the process died; it is brought back by whatever comes next.
        """
        async with self._lock:
            worker = await self._alive()
            answer = await worker.ask(Kind.REPORT, timeout_s=_ASKING_S)
            return answer[0] if answer else None

    async def close(self) -> None:
        """End the process."""
        if self._watch is not None:
            self._watch.cancel()
            await asyncio.gather(self._watch, return_exceptions=True)
        if self._worker is not None:
            self._worker.kill()

    async def _work_off(self, todo: list[tuple[int, bytes]]) -> None:
        """Collect an answer to each; what kills the process again and again is replaced by an empty one."""
        deaths = 0
        while todo:
            chunk = todo[: _CHUNK if deaths == 0 else 1]
            worker = await self._alive()
            try:
                found = await self._ask(worker, chunk)
            except WorkerDiedError as error:
                deaths += 1
                self._died(error)
                if deaths >= _POISON_DEATHS and len(chunk) == 1:
                    todo[0] = (chunk[0][0], await self._log.record_fault(chunk[0][0], self._reason))
                    deaths = 0
                continue
            deaths, self.failures = 0, 0
            self._unclaimed += found
            self.done_seq = chunk[-1][0]
            del todo[: len(chunk)]

    async def _alive(self) -> Worker:
        """Return the process, started and brought up to date as often as it takes."""
        while self._worker is None or self._worker.lost.is_set():
            if self._worker is not None:
                self._died(WorkerDiedError(f"process {self._worker.pid} ended"))
            if self.failures > 1:
                await asyncio.sleep(min(0.05 * 2.0 ** (self.failures - 1), _LONGEST_PAUSE_S))
            try:
                worker = await self._revive()
            except WorkerDiedError as error:
                self._died(error)
                continue
            self._worker = worker
            if self._watch is not None and self._watch is not asyncio.current_task():
                self._watch.cancel()
            self._watch = asyncio.create_task(self._watch_over(worker))
            if self._reason:
                self.restarts += 1
                self._on_restart(self._reason)
                self._reason = ""
        return self._worker

    async def _revive(self) -> Worker:
        worker = await self._forks.spawn(AGENT)
        try:
            seq = await self._restore(worker)
            chunk: list[tuple[int, bytes]] = []
            async for record in self._log.observations(seq, self.done_seq):
                chunk.append(record)
                if len(chunk) == _CHUNK:
                    await self._replay(worker, chunk)
                    chunk = []
            if chunk:
                await self._replay(worker, chunk)
        except BaseException:
            worker.kill()
            raise
        self.on_replayed = None  # what follows a restart of the process was told before
        return worker

    async def _restore(self, worker: Worker) -> int:
        snapshot = await self._log.snapshot() if self._trust_snapshot else None
        if snapshot is not None and snapshot[0] <= self.done_seq:
            try:
                await worker.ask(Kind.RESTORE, [snapshot[1]], timeout_s=_STARTING_S)
            except WorkerDiedError:
                self._trust_snapshot = False  # the log alone is enough, it only takes longer
                raise
            return snapshot[0]
        await worker.ask(Kind.BEGIN, [self._robot_id.encode(), self._config], timeout_s=_STARTING_S)
        return -1

    async def _replay(self, worker: Worker, chunk: Sequence[tuple[int, bytes]]) -> None:
        for answer in await self._ask(worker, chunk):
            if self.on_replayed is not None:
                self.on_replayed(answer)

    async def _ask(self, worker: Worker, chunk: Sequence[tuple[int, bytes]]) -> list[Answer]:
        parts = await worker.ask(Kind.HANDLE, [body for _, body in chunk], timeout_s=_ASKING_S)
        return [_answer(seq, part) for (seq, _), part in zip(chunk, parts, strict=True)]

    def _died(self, error: WorkerDiedError) -> None:
        self.failures += 1
        self._reason = str(error).strip().splitlines()[-1]
        self._worker = None
        if self.failures == _TROUBLE_FAILURES:
            self._on_trouble(self._reason)
        log.warning("agent process lost", robot_id=self._robot_id, reason=str(error), failures=self.failures)

    async def _watch_over(self, worker: Worker) -> None:
        """Bring the agent back at once when its process dies while nobody asks it anything."""
        await worker.lost.wait()
        async with self._lock:
            if self._worker is worker:
                try:
                    await self._alive()
                except DatabaseError as error:  # the next question tries again
                    log.warning("agent not brought back", robot_id=self._robot_id, reason=str(error))


def _answer(seq: int, part: bytes) -> Answer:
    if part[:1] == TAKEN:
        return Answer(seq, part[1:])
    return Answer(seq, None, part[1:].decode())
