"""A mission's past as it was shown: lines as they come, sealed into chunks, and the maps' pictures."""

from __future__ import annotations

from dataclasses import dataclass

from sqlalchemy import Connection, and_, delete, func, select

from db.engine import Database, insert_missing
from db.history_tables import history_chunks, history_lines, history_maps


@dataclass(frozen=True, slots=True)
class LineRecord:
    """One line of a chunk that is not sealed yet; line 0 is the whole state, the others are changes."""

    chunk: int
    line: int
    unix_s: float
    body: str


@dataclass(frozen=True, slots=True)
class ChunkSpan:
    """What a chunk covers: from its first line to its last."""

    number: int
    begins_unix_s: float
    ends_unix_s: float


class HistoryStore:
    """The past of missions: appended, and never changed but for lines becoming a chunk."""

    def __init__(self, database: Database) -> None:
        self._database = database

    async def add_line(
        self, mission_id: str, record: LineRecord, picture: tuple[int, bytes] | None = None
    ) -> None:
        """Append a line, and the picture of the map (version, PNG) that it is the first to name."""
        row = {
            "mission_id": mission_id,
            "chunk": record.chunk,
            "line": record.line,
            "unix_s": record.unix_s,
            "body": record.body,
        }

        def work(connection: Connection) -> None:
            if picture is not None:
                version, png = picture
                insert_missing(
                    connection, history_maps, [{"mission_id": mission_id, "version": version, "png": png}]
                )
            insert_missing(connection, history_lines, [row])

        await self._database.write(work)

    async def seal(self, mission_id: str, span: ChunkSpan, body: bytes) -> None:
        """Put a chunk in the place of its lines."""
        row = {
            "mission_id": mission_id,
            "number": span.number,
            "begins_unix_s": span.begins_unix_s,
            "ends_unix_s": span.ends_unix_s,
            "body": body,
        }

        def work(connection: Connection) -> None:
            insert_missing(connection, history_chunks, [row])
            chosen = and_(history_lines.c.mission_id == mission_id, history_lines.c.chunk == span.number)
            connection.execute(delete(history_lines).where(chosen))

        await self._database.write(work)

    async def spans_of(self, mission_id: str) -> list[ChunkSpan]:
        """Return what every chunk covers, oldest first; those not sealed yet are among them."""
        lines, chunks = history_lines.c, history_chunks.c
        sealed = select(chunks.number, chunks.begins_unix_s, chunks.ends_unix_s).where(
            chunks.mission_id == mission_id
        )
        opened = (
            select(lines.chunk, func.min(lines.unix_s), func.max(lines.unix_s))
            .where(lines.mission_id == mission_id)
            .group_by(lines.chunk)
        )

        def query(connection: Connection) -> list[ChunkSpan]:
            found = {row[0]: ChunkSpan(*row) for row in connection.execute(opened)}
            found |= {row[0]: ChunkSpan(*row) for row in connection.execute(sealed)}
            return [found[number] for number in sorted(found)]

        return await self._database.read(query)

    async def chunk_body(self, mission_id: str, number: int) -> bytes | None:
        """Return a sealed chunk, None where it is not sealed or not there."""
        chosen = and_(history_chunks.c.mission_id == mission_id, history_chunks.c.number == number)
        query = select(history_chunks.c.body).where(chosen)
        found: bytes | None = await self._database.read(lambda c: c.execute(query).scalar())
        return found

    async def lines_of(self, mission_id: str, chunk: int) -> list[LineRecord]:
        """Return the lines of a chunk that is not sealed yet, in order."""
        lines = history_lines.c
        query = (
            select(lines.chunk, lines.line, lines.unix_s, lines.body)
            .where(lines.mission_id == mission_id, lines.chunk == chunk)
            .order_by(lines.line)
        )
        return await self._database.read(lambda c: [LineRecord(*row) for row in c.execute(query)])

    async def picture(self, mission_id: str, version: int) -> bytes | None:
        """Return the picture of a version of the map, None where it was not kept."""
        chosen = and_(history_maps.c.mission_id == mission_id, history_maps.c.version == version)
        query = select(history_maps.c.png).where(chosen)
        found: bytes | None = await self._database.read(lambda c: c.execute(query).scalar())
        return found

    async def pictures_of(self, mission_id: str) -> dict[int, bytes]:
        """Return every picture of a mission's map by version."""
        maps = history_maps.c
        query = select(maps.version, maps.png).where(maps.mission_id == mission_id).order_by(maps.version)
        return await self._database.read(lambda c: {row.version: row.png for row in c.execute(query)})

    async def bytes_of(self, mission_id: str) -> int:
        """Return how much the past of a mission takes, in bytes."""
        sums = (
            select(func.sum(func.length(history_chunks.c.body))).where(
                history_chunks.c.mission_id == mission_id
            ),
            select(func.sum(func.length(history_lines.c.body))).where(
                history_lines.c.mission_id == mission_id
            ),
            select(func.sum(func.length(history_maps.c.png))).where(history_maps.c.mission_id == mission_id),
        )
        return await self._database.read(lambda c: sum(int(c.execute(query).scalar() or 0) for query in sums))
