"""The observation log and the agents' snapshots: together they bring an agent back at any instant."""

from __future__ import annotations

from collections.abc import AsyncIterator, Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import ColumnElement, Connection, Select, and_, func, select, update

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
                "received_unix_s": record.received_unix_s,
                "body": record.body,
            }
            for record in records
        ]
        await self._database.write(lambda c: insert_missing(c, observations, rows))

    async def observations_after(
        self, mission_id: str, robot_id: str, seq: int, until: int | None = None
    ) -> AsyncIterator[ObservationRecord]:
        """Yield the observations after ``seq`` up to ``until`` in order."""
        query = partial(_page, mission_id=mission_id, robot_id=robot_id, until=until)
        while True:
            page = await self._database.read(partial(query, seq=seq))
            for record in page:
                yield record
            if len(page) < _PAGE:
                return
            seq = page[-1].seq

    async def count_observations(self, mission_id: str, robot_id: str, until: int) -> int:
        """Return how many observations there are up to ``until``."""
        chosen = and_(_of(mission_id, robot_id), observations.c.seq <= until)
        query = select(func.count()).select_from(observations).where(chosen)
        return int(await self._database.read(lambda c: c.execute(query).scalar_one()))

    async def last_observation(self, mission_id: str, robot_id: str) -> ObservationRecord | None:
        """Return the latest observation, None when there is none."""
        query = select(observations).where(_of(mission_id, robot_id)).order_by(observations.c.seq.desc())
        found = await self._database.read(lambda c: _records(c, query.limit(1)))
        return found[0] if found else None

    async def arrivals(self, mission_id: str, robot_id: str) -> NDArray[np.float64]:
        """Return seq, stamp in seconds and Unix time of receipt of all observations, in order: (n, 3)."""
        columns = (observations.c.seq, observations.c.stamp_s, observations.c.received_unix_s)
        query = select(*columns).where(_of(mission_id, robot_id)).order_by(observations.c.seq)
        rows = await self._database.read(lambda c: [tuple(row) for row in c.execute(query)])
        return np.array(rows, np.float64).reshape(-1, 3)

    async def record_fault(self, mission_id: str, robot_id: str, seq: int, fault: str) -> None:
        """Mark an observation that the agent cannot take."""
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
            "updates": [list(item) for item in snapshot.updates],
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
            return SnapshotRecord(row.seq, row.body, tuple((seq, text) for seq, text in row.updates))

        return await self._database.read(query)


def _of(mission_id: str, robot_id: str) -> ColumnElement[bool]:
    return and_(observations.c.mission_id == mission_id, observations.c.robot_id == robot_id)


def _page(
    connection: Connection, mission_id: str, robot_id: str, seq: int, until: int | None
) -> list[ObservationRecord]:
    query = select(observations).where(_of(mission_id, robot_id), observations.c.seq > seq)
    if until is not None:
        query = query.where(observations.c.seq <= until)
    return _records(connection, query.order_by(observations.c.seq).limit(_PAGE))


def _records(connection: Connection, query: Select[Any]) -> list[ObservationRecord]:
    rows = connection.execute(query)
    return [ObservationRecord(r.seq, r.stamp_s, r.received_unix_s, r.body, r.fault) for r in rows]
