"""Photos: left by people and robots, shown where they belong."""

from __future__ import annotations

import asyncio
from dataclasses import asdict, replace
from hashlib import sha256
from typing import Any

from db.photos import PhotoRecord
from db.store import Store
from server.board import Board
from server.errors import ApiError, unknown
from server.mission.events import Events
from server.photo_file import PhotoError, drawn_anew

MAX_PHOTOS = 5000  # of one mission: some gigabytes


class Photos:
    """The photos of a mission by id, oldest first; the pictures themselves stay in the database."""

    def __init__(self, store: Store, mission_id: str, board: Board, events: Events) -> None:
        self._store = store.photos
        self._mission_id = mission_id
        self._board = board
        self._events = events
        self._photos: dict[str, PhotoRecord] = {}
        self._away: dict[str, PhotoRecord] = {}
        self._drawing = asyncio.Lock()  # one at a time: a decoded photo is large

    async def restore(self) -> None:
        """Bring the photos back from the database."""
        for photo, deleted in await self._store.photos_of(self._mission_id):
            (self._away if deleted else self._photos)[photo.photo_id] = photo
        self._board.publish({f"photo/{p.photo_id}": self.value(p) for p in self._photos.values()})

    def all(self) -> list[PhotoRecord]:
        """Return every photo that nobody has taken away, oldest first."""
        return list(self._photos.values())

    def get(self, photo_id: str) -> PhotoRecord:
        """Return a photo.

        Raises:
            ApiError: there is none of that id.
        """
        if photo_id not in self._photos:
            raise unknown("photo", photo_id)
        return self._photos[photo_id]

    def value(self, photo: PhotoRecord) -> dict[str, Any]:
        """Return ``photo/ID`` of the board."""
        at = f"/api/v1/missions/{self._mission_id}/photos/{photo.photo_id}"
        told = {name: value for name, value in asdict(photo).items() if name != "sha256"}
        return {**told, "address": at, "thumbnail": f"{at}/thumbnail"}

    async def add(self, told: PhotoRecord, file: bytes) -> tuple[PhotoRecord, bool]:
        """Keep a photo, of which ``told`` lacks digest and size; return it and whether it is new.

        Raises:
            ApiError: the file is no photo; the id is another photo's; or there are too many already.
        """
        told = replace(told, sha256=sha256(file).hexdigest())
        async with self._drawing:
            known = self._photos.get(told.photo_id) or self._away.get(told.photo_id)
            if known is not None:
                if known.sha256 != told.sha256:
                    text = f"Photo {told.photo_id} is another picture; give each photo an id of its own."
                    raise ApiError(409, "photo_differs", text, "photo_id")
                return known, False
            if len(self._photos) + len(self._away) >= MAX_PHOTOS:
                text = f"This mission has {MAX_PHOTOS} photos already and takes no more."
                raise ApiError(409, "too_many_photos", text)
            try:
                pictures, (width, height) = await asyncio.to_thread(drawn_anew, file)
            except PhotoError as error:
                raise ApiError(422, "no_photo", f"{error}.") from error
            photo = replace(told, width=width, height=height)
            await self._store.record_photo(self._mission_id, photo, pictures)
            self._photos[photo.photo_id] = photo
            self._board.publish({f"photo/{photo.photo_id}": self.value(photo)})
        await self._events.tell("photo", f"{photo.by} left a photo{_of(photo)}.")
        return photo, True

    async def picture(self, photo_id: str, *, small: bool) -> bytes:
        """Return a photo as JPEG.

        Raises:
            ApiError: there is none of that id.
        """
        self.get(photo_id)
        found = await self._store.picture_of(self._mission_id, photo_id, small=small)
        if found is None:
            raise unknown("photo", photo_id)
        return found

    async def remove(self, photo_id: str) -> None:
        """Take a photo away; it stays in the database.

        Raises:
            ApiError: there is none of that id.
        """
        photo = self.get(photo_id)
        await self._store.mark_photo(self._mission_id, photo_id, deleted=True)
        self._away[photo_id] = self._photos.pop(photo_id, photo)
        self._board.publish({f"photo/{photo_id}": None})

    async def put_back(self, photo_id: str) -> None:
        """Show a photo again that was taken away.

        Raises:
            ApiError: none of that id was.
        """
        if photo_id not in self._away:
            raise unknown("photo", photo_id)
        await self._store.mark_photo(self._mission_id, photo_id, deleted=False)
        photo = self._photos[photo_id] = self._away.pop(photo_id)
        self._board.publish({f"photo/{photo_id}": self.value(photo)})


def _of(photo: PhotoRecord) -> str:
    if photo.victim_id is not None:
        return f" of victim {photo.victim_id}"
    return f" at tag {photo.tag_id}" if photo.tag_id is not None else ""
