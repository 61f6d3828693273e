"""The map that was there before the mission, under the one that its robots make."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from dataclasses import replace

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
        await self._store.record_base_map(self._mission_id, None)
        self.image = None
        self._board.publish({"base_map": None})
        self._on_grid(self._mission_id, None)
        await self._events.tell("base_map", f"{by} took the base map away.")

    async def _show(self, grid: TeamGrid, record: BaseMapRecord) -> None:
        self.image = await asyncio.to_thread(draw, grid)
        told = map_value(self._mission_id, self.image, "base-map.png")
        self._board.publish({"base_map": {**told, "source": record.source, "by": record.by}})
        self._on_grid(self._mission_id, grid)
