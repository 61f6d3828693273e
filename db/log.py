"""The observation log and the agents' snapshots: together they bring an agent back at any instant."""

from __future__ import annotations

from collections.abc import AsyncIterator, Sequence
from functools import partial

from sqlalchemy import ColumnElement, Connection, and_, select, update

from db.engine import Database, insert_missing, upsert
from db.records import ObservationRecord, SnapshotRecord
from db.tables import agent_snapshots, observations

_PAGE = 256  # observations read at a time: a replay never holds a whole mission in memory


class LogStore:
    """Observations by (mission, robot, seq), appended and never changed; the latest snapshot per robot."""

    def __init__(self, database: Database) -> None:
        self._database = database

    async def append_observations(
        self, mission_id: str, robot_id: str, records: Sequence[ObservationRecord]
    ) -> None:
        """Add observations to the log; those already there change nothing."""
        rows = [
            {
                "mission_id": mission_id,
                "robot_id": robot_id,
                "seq": record.seq,
                "stamp_s": record.stamp_s,
                "body": record.body,
            }
            for record in records
        ]
        await self._database.write(lambda c: insert_missing(c, observations, rows))

    async def observations_after(
        self, mission_id: str, robot_id: str, seq: int, until: int | None = None
    ) -> AsyncIterator[ObservationRecord]:
        """Yield the observations after ``seq`` up to ``until`` in order, save those marked with a fault."""
        query = partial(_page, mission_id=mission_id, robot_id=robot_id, until=until)
        while True:
            page = await self._database.read(partial(query, seq=seq))
            for record in page:
                yield record
            if len(page) < _PAGE:
                return
            seq = page[-1].seq

    async def last_observation(self, mission_id: str, robot_id: str) -> tuple[int, float] | None:
        """Return seq and stamp of the latest observation, None when there is none."""

        def query(connection: Connection) -> tuple[int, float] | None:
            row = connection.execute(
                select(observations.c.seq, observations.c.stamp_s)
                .where(_of(mission_id, robot_id))
                .order_by(observations.c.seq.desc())
                .limit(1)
            ).first()
            return (row.seq, row.stamp_s) if row else None

        return await self._database.read(query)

    async def record_fault(self, mission_id: str, robot_id: str, seq: int, fault: str) -> None:
        """Mark an observation that the agent cannot take, so that replays leave it out."""
        chosen = and_(_of(mission_id, robot_id), observations.c.seq == seq)
        await self._database.write(
            lambda c: c.execute(update(observations).where(chosen).values(fault=fault))
        )

    async def record_snapshot(self, mission_id: str, robot_id: str, snapshot: SnapshotRecord) -> None:
        """Replace the snapshot of an agent."""
        row = {
            "mission_id": mission_id,
            "robot_id": robot_id,
            "seq": snapshot.seq,
            "body": snapshot.body,
            "commands": [list(item) for item in snapshot.commands],
        }
        await self._database.write(lambda c: upsert(c, agent_snapshots, [row]))

    async def latest_snapshot(self, mission_id: str, robot_id: str) -> SnapshotRecord | None:
        """Return the snapshot of an agent, None when there is none."""

        def query(connection: Connection) -> SnapshotRecord | None:
            row = connection.execute(
                select(agent_snapshots).where(
                    agent_snapshots.c.mission_id == mission_id, agent_snapshots.c.robot_id == robot_id
                )
            ).first()
            if row is None:
                return None
            return SnapshotRecord(row.seq, row.body, tuple((seq, text) for seq, text in row.commands))

        return await self._database.read(query)


def _of(mission_id: str, robot_id: str) -> ColumnElement[bool]:
    return and_(observations.c.mission_id == mission_id, observations.c.robot_id == robot_id)


def _page(
    connection: Connection, mission_id: str, robot_id: str, seq: int, until: int | None
) -> list[ObservationRecord]:
    query = select(observations.c.seq, observations.c.stamp_s, observations.c.body).where(
        _of(mission_id, robot_id), observations.c.seq > seq, observations.c.fault.is_(None)
    )
    if until is not None:
        query = query.where(observations.c.seq <= until)
    rows = connection.execute(query.order_by(observations.c.seq).limit(_PAGE))
    return [ObservationRecord(row.seq, row.stamp_s, row.body) for row in rows]
