"""Where the mission lies on the Earth, as people have said."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from db.mission_records import GeoreferenceRecord
from db.store import Store
from server.board import Board
from server.errors import ApiError
from server.geo.georeference import Georeference
from server.mission.events import Events


class Georeferences:
    """The georeference of a mission: at most one, on the board as ``georeference``."""

    def __init__(self, store: Store, mission_id: str, board: Board, events: Events) -> None:
        self._store = store.places
        self._mission_id = mission_id
        self._board = board
        self._events = events
        self._now: GeoreferenceRecord | None = None

    async def restore(self) -> None:
        """Bring it back from the database."""
        self._show(await self._store.georeference_of(self._mission_id))

    @property
    def frame(self) -> Georeference | None:
        """The world frame on the Earth; None while nobody has said where it lies."""
        now = self._now
        return (
            None
            if now is None
            else Georeference(now.lat_deg, now.lon_deg, now.yaw_rad, now.height_m, now.sd_m)
        )

    def value(self) -> dict[str, Any] | None:
        """Return ``georeference`` of the board."""
        return (
            None
            if self._now is None
            else {**asdict(self._now), "points": [list(p) for p in self._now.points]}
        )

    def get(self) -> Georeference:
        """Return the world frame on the Earth.

        Raises:
            ApiError: nobody has said where it lies.
        """
        frame = self.frame
        if frame is None:
            text = "Nobody has said where this mission lies on the Earth; PUT its georeference first."
            raise ApiError(404, "no_georeference", text)
        return frame

    async def set(self, record: GeoreferenceRecord | None, by: str) -> None:
        """Keep a georeference in the place of the one before; None: there is none any more."""
        await self._store.record_georeference(self._mission_id, record)
        self._show(record)
        if record is None:
            await self._events.tell(
                "georeference", f"The mission has no place on the Earth any more, says {by}."
            )
        else:
            told = f"lies at {record.lat_deg:.5f}, {record.lon_deg:.5f}"
            await self._events.tell("georeference", f"The mission {told}, says {by}.")

    async def take_over(self, other: Georeferences, by: str) -> None:
        """Lie where another mission lies, if that is known and this one's place is not."""
        if self._now is None and other._now is not None:
            await self.set(other._now, by)

    def _show(self, record: GeoreferenceRecord | None) -> None:
        self._now = record
        self._board.publish({"georeference": self.value()})
