"""Writing a mission's log to a file that replays anywhere, a piece at a time: see ``log_lines``."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator
from contextlib import suppress
from dataclasses import asdict
from hashlib import sha256
from typing import Any

from db.records import MissionRecord, ObservationRecord, RobotRecord, SnapshotRecord
from db.store import Store
from robots import codec
from robots.agent import RobotAgent
from robots.datasets.log_lines import VERSION, LineWriter
from robots.snapshot import SnapshotError

_BATCH = 64


async def mission_log(store: Store, mission: MissionRecord) -> AsyncIterator[bytes]:
    """Yield the bytes of a mission's log as it stands now; robots may go on meanwhile.

    Raises:
        DatabaseError: the database cannot be read.
    """
    writer = LineWriter()
    batch: list[ObservationRecord] = []

    def written() -> bytes:
        pieces = []
        for record in batch:
            if record.fault is not None:
                pieces.append(writer.value({"fault": record.fault}))
            pieces.append(writer.line(record.body))
        batch.clear()
        return b"".join(pieces)

    robots = await store.missions.robots_of(mission.mission_id)
    yield writer.value(
        {
            "waymark_log": VERSION,
            "mission_id": mission.mission_id,
            "name": mission.name,
            "created_unix_s": mission.created_unix_s,
            "robots": len(robots),
        }
    )
    for robot in robots:
        of = (mission.mission_id, robot.robot_id)
        # what agents came to is read before the observations: these then reach at least as far
        snapshot = await store.log.latest_snapshot(*of)
        graph = await store.graphs.graph_of(*of)
        last = await store.log.last_observation(*of)
        until = -1 if last is None else last.seq
        yield writer.value(
            {
                **_registration(robot),
                "observations": await store.log.count_observations(*of, until),
                **(await asyncio.to_thread(_came_to, snapshot)),
                "graph_sha256": None if graph is None else sha256(codec.encode(graph)).hexdigest(),
            }
        )
        async for record in store.log.observations_after(*of, -1, until):
            batch.append(record)
            if len(batch) == _BATCH:  # compressing takes its time, and robots wait for replies
                yield await asyncio.to_thread(written)
        yield await asyncio.to_thread(written)
    yield writer.end()


def _registration(robot: RobotRecord) -> dict[str, Any]:
    start = robot.start_pose
    return {
        "robot_id": robot.robot_id,
        "agent": robot.agent,
        "start_pose": None if start is None else asdict(start),
        "config": json.loads(robot.config),
    }


def _came_to(snapshot: SnapshotRecord | None) -> dict[str, Any]:
    """Return the digest of all updates up to a snapshot, null where none was kept."""
    digest = b""
    if snapshot is not None:
        with suppress(SnapshotError):  # of another version: there is nothing to compare with
            digest = RobotAgent.restore(snapshot.body).updates_digest
    if snapshot is None or not digest:
        return {"updates_until": None, "updates_sha256": None}
    return {"updates_until": snapshot.seq, "updates_sha256": digest.hex()}
