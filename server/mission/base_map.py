"""The map that was there before the mission, under the one that its robots make."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import structlog

from db.mission_records import BaseMapRecord
from db.store import Store
from robots import codec
from robots.team import TeamGrid
from server.board import Board
from server.errors import ApiError
from server.map_image import MapImage, draw
from server.mission.events import Events
from server.sharing import map_value

log = structlog.get_logger()


class BaseMap:
    """At most one, on the board as ``base_map``. ``image`` is its picture; ``on_grid`` is told of each."""

    def __init__(
        self,
        store: Store,
        mission_id: str,
        board: Board,
        events: Events,
        on_grid: Callable[[str, TeamGrid | None], None],
    ) -> None:
        self.image: MapImage | None = None
        self._record: BaseMapRecord | None = None
        self._store = store.places
        self._mission_id = mission_id
        self._board = board
        self._events = events
        self._on_grid = on_grid

    async def restore(self) -> None:
        """Bring it back from the database."""
        record = await self._store.base_map_of(self._mission_id)
        if record is None:
            return
        try:
            grid = await asyncio.to_thread(codec.decode, record.grid, TeamGrid)
        except codec.CodecError as error:
            log.error("a base map could not be read", mission_id=self._mission_id, reason=str(error))
            return
        await self._show(grid, record)

    def get(self) -> MapImage:
        """Return its picture.

        Raises:
            ApiError: there is none.
        """
        if self.image is None:
            raise ApiError(
                404, "no_base_map", "This mission has no base map; PUT one, or copy another mission's."
            )
        return self.image

    def value(self) -> dict[str, Any] | None:
        """Return which one it is, for the log of changes; None: there is none."""
        now = self._record
        return (
            None
            if now is None
            else {"source": now.source, "by": now.by, "changed_unix_s": now.changed_unix_s}
        )

    async def set(self, grid: TeamGrid, source: str, by: str) -> None:
        """Keep a base map in the place of the one before; ``source`` says where it is from."""
        grid = replace(grid, version=int(time.time() * 1000.0))
        body = await asyncio.to_thread(codec.encode, grid)
        record = BaseMapRecord(source, body, by, time.time())
        await self._store.record_base_map(self._mission_id, record)
        await self._show(grid, record)
        await self._events.tell("base_map", f"{by} laid {source} under the map.")

    async def remove(self, by: str) -> None:
        """Take it away.

        Raises:
            ApiError: there is none.
        """
        self.get()
        await self._clear()
        await self._events.tell("base_map", f"{by} took the base map away.")

    async def put_back(self, before: Mapping[str, Any] | None, by: str) -> None:
        """Have the one that was there before a change, or none, as ``value`` named it.

        Raises:
            ApiError: it is not kept any more.
        """
        if before is None:
            await self._clear(keep_past=False)
        else:
            record = await self._store.past_base_map(self._mission_id, before["changed_unix_s"])
            if record is None:
                text = f"{before['source']} is not kept any more: only the last base maps are. Lay it again."
                raise ApiError(409, "not_kept", text, "audit_id")
            grid = await asyncio.to_thread(codec.decode, record.grid, TeamGrid)
            await self._store.record_base_map(self._mission_id, record, keep_past=False)
            await self._show(grid, record)
        await self._events.tell("base_map", f"{by} took a change of the base map back.")

    async def _clear(self, *, keep_past: bool = True) -> None:
        await self._store.record_base_map(self._mission_id, None, keep_past=keep_past)
        self.image = self._record = None
        self._board.publish({"base_map": None})
        self._on_grid(self._mission_id, None)

    async def _show(self, grid: TeamGrid, record: BaseMapRecord) -> None:
        self.image = await asyncio.to_thread(draw, grid)
        self._record = record
        told = map_value(self._mission_id, self.image, "base-map.png")
        self._board.publish({"base_map": {**told, "source": record.source, "by": record.by}})
        self._on_grid(self._mission_id, grid)
