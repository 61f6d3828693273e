"""Photos that people and robots left: what is told of them, and the pictures, read one at a time."""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields

from sqlalchemy import Connection, select, update

from db.engine import Database, insert_missing
from db.mission_tables import photos


@dataclass(frozen=True, slots=True)
class PhotoRecord:
    """A photo of a victim, a note, a tag or a place in the world frame, without its pictures.

    ``sha256``: of the file as it was sent, which is not kept.
    """

    photo_id: str
    sha256: str
    width: int
    height: int
    text: str
    victim_id: str | None
    annotation_id: str | None
    tag_id: str | None
    x_m: float | None
    y_m: float | None
    by: str
    taken_unix_s: float | None
    created_unix_s: float


@dataclass(frozen=True, slots=True)
class Pictures:
    """A photo as JPEG, whole and small."""

    whole: bytes
    small: bytes


class PhotoStore:
    """Photos of a mission; on the disk once written. None is ever overwritten or dropped."""

    def __init__(self, database: Database) -> None:
        self._database = database

    async def record_photo(self, mission_id: str, record: PhotoRecord, pictures: Pictures) -> None:
        """Keep a new photo; one of the same id that is there already stays."""
        row = {"mission_id": mission_id, **asdict(record), **asdict(pictures), "deleted": False}
        await self._database.write(lambda c: insert_missing(c, photos, [row]), durable=True)

    async def mark_photo(self, mission_id: str, photo_id: str, *, deleted: bool) -> None:
        """Keep whether somebody has taken a photo away."""
        chosen = (photos.c.mission_id == mission_id) & (photos.c.photo_id == photo_id)
        await self._database.write(
            lambda c: c.execute(update(photos).where(chosen).values(deleted=deleted)), durable=True
        )

    async def photos_of(self, mission_id: str) -> list[tuple[PhotoRecord, bool]]:
        """Return all photos, oldest first, and whether each was taken away."""
        names = [item.name for item in fields(PhotoRecord)]

        def query(connection: Connection) -> list[tuple[PhotoRecord, bool]]:
            columns = [photos.c[name] for name in (*names, "deleted")]
            chosen = select(*columns).where(photos.c.mission_id == mission_id)
            rows = connection.execute(chosen.order_by(photos.c.created_unix_s, photos.c.photo_id))
            return [(PhotoRecord(*row[:-1]), bool(row[-1])) for row in rows]

        return await self._database.read(query)

    async def picture_of(self, mission_id: str, photo_id: str, *, small: bool) -> bytes | None:
        """Return a picture; None where there is no such photo."""
        column = photos.c.small if small else photos.c.whole
        chosen = (photos.c.mission_id == mission_id) & (photos.c.photo_id == photo_id)

        def query(connection: Connection) -> bytes | None:
            found: bytes | None = connection.execute(select(column).where(chosen)).scalar()
            return found

        return await self._database.read(query)
