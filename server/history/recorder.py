"""Recording what a mission shows: every change of its board, as often as the eye needs it."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any

import structlog

from db.errors import DatabaseError
from db.history import ChunkSpan, LineRecord
from db.store import Store
from server.board import Board
from server.history.changes import between, first_line, sealed
from server.map_image import MapImage

TICK_S = 0.5
CHUNK_S = 30.0  # a chunk is what a browser fetches at once
STRETCH_BYTES = 128 * 2**20  # each so many bytes, moving and growing things are recorded half as often
_PERIODS_S: Mapping[str, float] = {
    "robot": TICK_S,
    "mission": TICK_S,
    "map": 5.0,  # these are large, and come anew with every solution of the team's map
    "trail": 10.0,
    "tag": 5.0,
    "links": 5.0,
    "frontiers": 5.0,
}
_LEFT_OUT = frozenset({"best_map"})  # it is of no moment, and is made again when it is wanted

log = structlog.get_logger()


class Recorder:
    """Writes the past of one mission. ``image`` gives the map's picture of the board's version.

    What people do is written before they are answered (``flush``). What moves by itself is written twice a
    second, what grows with the map every five or ten; each ``STRETCH_BYTES`` make that half as often, so the
    past of a long mission grows ever more slowly.
    """

    def __init__(
        self,
        store: Store,
        mission_id: str,
        board: Board,
        image: Callable[[], MapImage | None],
        clock: Callable[[], float] = time.time,
    ) -> None:
        self._store = store.history
        self._mission_id = mission_id
        self._board = board
        self._image = image
        self._clock = clock
        self._writing = asyncio.Lock()
        self._ended = asyncio.Event()
        self._task: asyncio.Task[None] | None = None
        self._subscription = board.subscribe()
        self._waiting: dict[str, None] = {}  # keys that changed and are not due yet, in order
        self._recorded_s: dict[str, float] = {}  # by kind
        self._state: dict[str, dict[str, Any]] = {}  # as the lines so far have it
        self._lines: list[str] = []  # of the chunk that is being written
        self._number = 0
        self._begun_s = self._last_s = 0.0
        self._bytes = 0
        self._pictured = 0

    async def restore(self) -> None:
        """Go on after what is there; lines that a server left when it ended are sealed."""
        spans = await self._store.spans_of(self._mission_id)
        for span in spans:
            lines = await self._store.lines_of(self._mission_id, span.number)
            if lines:
                body = await asyncio.to_thread(sealed, [line.body for line in lines])
                await self._store.seal(self._mission_id, span, body)
        if spans:
            self._number = spans[-1].number + 1
            self._last_s = spans[-1].ends_unix_s
        self._bytes = await self._store.bytes_of(self._mission_id)

    def begin(self) -> None:
        """Record from now on, in the background."""
        self._task = asyncio.create_task(self._run(), name=f"history of {self._mission_id}")

    async def close(self) -> None:
        """Record what is left, whether due or not, and seal it."""
        self._ended.set()
        if self._task is not None:
            await self._task
            await self.catch_up()
            async with self._writing:
                with suppress(DatabaseError):  # the lines are there, and are sealed at the next start
                    await self._seal()
        self._subscription.close()

    async def catch_up(self) -> None:
        """Record all that changed, due or not, for who wants to read the past up to now."""
        if self._task is not None:  # of a mission that is over nothing changes
            self._recorded_s.clear()
            await self.flush()

    async def flush(self) -> None:
        """Record what is due now. A database that cannot take it gets it again at the next tick."""
        async with self._writing:
            try:
                await self._record()
            except DatabaseError as error:
                log.error("the past could not be recorded", mission_id=self._mission_id, reason=str(error))

    async def _run(self) -> None:
        while not self._ended.is_set():
            with suppress(TimeoutError):
                await asyncio.wait_for(self._ended.wait(), TICK_S)
            await self.flush()

    async def _record(self) -> None:
        changed_keys = self._subscription.take_keys()
        self._waiting.update((key, None) for key in changed_keys if _kind(key) not in _LEFT_OUT)
        now = max(self._clock(), self._last_s + 0.001)  # a clock that is set back must not fold the past
        if self._lines and now - self._begun_s >= CHUNK_S and self._waiting:
            await self._seal()
        keys = list(self._waiting) if not self._lines else self._due(now)
        state = self._board.snapshot()
        if not self._lines:
            state = {key: value for key, value in state.items() if _kind(key) not in _LEFT_OUT}
            text = first_line(now, state)
            changed = state
        else:
            change = between(self._state, state, keys)
            if not change:
                self._forget(keys, now)
                return
            text = change.text(now)
            changed = {**change.set, **change.patch, **change.splice}
        picture = self._picture() if "map" in changed else None
        record = LineRecord(self._number, len(self._lines), now, text)
        await self._store.add_line(
            self._mission_id, record, None if picture is None else (picture.version, picture.png)
        )
        if picture is not None:
            self._pictured = picture.version
            self._bytes += len(picture.png)
        if self._lines:
            change.apply(self._state)
        else:
            self._state, self._begun_s = state, now
        self._lines.append(text)
        self._last_s = now
        self._forget(keys, now)

    def _due(self, now: float) -> list[str]:
        """Return the keys that are recorded now: those of a kind at once, so that they fit each other."""
        stretch = 2.0 ** (self._bytes // STRETCH_BYTES)
        due = []
        for key in self._waiting:
            kind = _kind(key)
            wait_s = _PERIODS_S.get(kind, 0.0) * stretch - (now - self._recorded_s.get(kind, 0.0))
            if wait_s <= 0.1 * TICK_S:  # ticks do not come to the millisecond
                due.append(key)
        return due

    def _forget(self, keys: list[str], now: float) -> None:
        for key in keys:
            self._waiting.pop(key, None)
            self._recorded_s[_kind(key)] = now

    def _picture(self) -> MapImage | None:
        image = self._image()
        return None if image is None or image.version == self._pictured else image

    async def _seal(self) -> None:
        if not self._lines:
            return
        body = await asyncio.to_thread(sealed, self._lines)
        await self._store.seal(self._mission_id, ChunkSpan(self._number, self._begun_s, self._last_s), body)
        self._bytes += len(body)
        self._number += 1
        self._lines = []


def _kind(key: str) -> str:
    return key.partition("/")[0]
