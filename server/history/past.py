"""Reading a mission's past: chunks for browsers, the state at any moment, and all that changed in order."""

from __future__ import annotations

import asyncio
import gzip
import json
from collections.abc import AsyncIterator, Iterator
from typing import Any

from db.history import ChunkSpan
from db.store import Store
from server.history.changes import Change, Value, sealed


class Past:
    """The past of one mission, from the database alone: it needs no mission that runs."""

    def __init__(self, store: Store, mission_id: str) -> None:
        self._store = store.history
        self._mission_id = mission_id

    async def spans(self) -> list[ChunkSpan]:
        """Return what every chunk covers, oldest first; the state stays as it was between them."""
        return await self._store.spans_of(self._mission_id)

    async def chunk(self, number: int) -> tuple[bytes, bool] | None:
        """Return a chunk, gzip of JSON, and whether it is whole; None where there is none of that number."""
        body = await self._store.chunk_body(self._mission_id, number)
        if body is not None:
            return body, True
        lines = await self._store.lines_of(self._mission_id, number)
        if lines:
            return await asyncio.to_thread(sealed, [line.body for line in lines]), False
        body = await self._store.chunk_body(self._mission_id, number)  # sealed meanwhile
        return None if body is None else (body, True)

    async def state_at(self, unix_s: float) -> tuple[float, dict[str, Value]] | None:
        """Return the state at a moment and when it became so; None before the first."""
        earlier = [span for span in await self.spans() if span.begins_unix_s <= unix_s]
        found = await self.chunk(earlier[-1].number) if earlier else None
        if found is None:
            return None
        return await asyncio.to_thread(_state_in, found[0], unix_s)

    async def chunks(self) -> AsyncIterator[bytes]:
        """Yield every chunk, oldest first, for ``steps``."""
        for span in await self.spans():
            found = await self.chunk(span.number)
            if found is not None:
                yield found[0]

    async def picture(self, version: int) -> bytes | None:
        """Return the PNG of a version of the map, None where it was not kept."""
        return await self._store.picture(self._mission_id, version)


def steps(body: bytes) -> Iterator[tuple[float, dict[str, Value]]]:
    """Yield the state at the beginning of a chunk and after each change, with its time.

    The dictionary is the same one each time; the values in it are replaced, never changed.
    """
    chunk: dict[str, Any] = json.loads(gzip.decompress(body))
    state: dict[str, Value] = chunk["state"]
    yield chunk["begins_unix_s"], state
    for line in chunk["changes"]:
        Change.of(line).apply(state)
        yield line["unix_s"], state


def _state_in(body: bytes, unix_s: float) -> tuple[float, dict[str, Value]]:
    since, found = 0.0, {}
    for moment, state in steps(body):
        if moment > unix_s:
            break
        since, found = moment, dict(state)
    return since, found
