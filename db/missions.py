"""Missions and the robots registered in them."""

from __future__ import annotations

from dataclasses import asdict, fields

from sqlalchemy import Connection, Row, and_, delete, insert, select, update

from db.engine import Database, insert_missing, upsert
from db.mission_records import EndingRecord, ProgressRecord
from db.mission_tables import endings, progress
from db.records import MissionRecord, RobotRecord, StartPoseRecord
from db.tables import missions, robots


class MissionStore:
    """Missions, their robots and who is stopped."""

    def __init__(self, database: Database) -> None:
        self._database = database

    async def create_mission(self, mission: MissionRecord) -> None:
        """Add a mission whose id is not taken yet."""
        await self._database.write(
            lambda c: c.execute(insert(missions).values(asdict(mission))), durable=True
        )

    async def all_missions(self) -> list[MissionRecord]:
        """Return every mission, oldest first."""

        def query(connection: Connection) -> list[MissionRecord]:
            rows = connection.execute(select(missions).order_by(missions.c.created_unix_s))
            return [MissionRecord(**row._mapping) for row in rows]

        return await self._database.read(query)

    async def record_state(self, mission: MissionRecord) -> None:
        """Keep a mission's state, and who has put it there when."""
        names = ("state", "state_by", "state_unix_s", "started_unix_s", "ran_s")
        values = {name: getattr(mission, name) for name in names}
        chosen = missions.c.mission_id == mission.mission_id
        await self._database.write(
            lambda c: c.execute(update(missions).where(chosen).values(values)), durable=True
        )

    async def record_ending(self, mission_id: str, ending: EndingRecord | None) -> None:
        """Keep what is left of a mission that was closed; None when it goes on."""

        def work(connection: Connection) -> None:
            if ending is None:
                connection.execute(delete(endings).where(endings.c.mission_id == mission_id))
            else:
                upsert(connection, endings, [{"mission_id": mission_id, **asdict(ending)}])

        await self._database.write(work, durable=True)

    async def ending_of(self, mission_id: str) -> EndingRecord | None:
        """Return what is left of a mission; None where it has not ended."""

        def query(connection: Connection) -> EndingRecord | None:
            row = connection.execute(select(endings).where(endings.c.mission_id == mission_id)).first()
            return None if row is None else EndingRecord(row.ended_unix_s, row.board, row.grid)

        return await self._database.read(query)

    async def record_progress(self, mission_id: str, sample: ProgressRecord) -> None:
        """Keep how far a mission is."""
        row = {"mission_id": mission_id, **asdict(sample)}
        await self._database.write(lambda c: insert_missing(c, progress, [row]))

    async def progress_of(self, mission_id: str) -> list[ProgressRecord]:
        """Return how a mission got on, in order of time."""
        names = [progress.c[item.name] for item in fields(ProgressRecord)]
        query = select(*names).where(progress.c.mission_id == mission_id).order_by(progress.c.unix_s)
        return await self._database.read(
            lambda c: [ProgressRecord(**row._mapping) for row in c.execute(query)]
        )

    async def register_robot(self, robot: RobotRecord) -> None:
        """Add a robot whose id is not taken yet in its mission."""
        row = {
            name: getattr(robot, name)
            for name in robots.c.keys()  # noqa: SIM118 - a column collection is no mapping
            if not name.startswith("start_")
        }
        if robot.start_pose is not None:
            row |= {f"start_{name}": value for name, value in asdict(robot.start_pose).items()}
        await self._database.write(lambda c: c.execute(insert(robots).values(row)), durable=True)

    async def robots_of(self, mission_id: str) -> list[RobotRecord]:
        """Return the robots of a mission in the order in which they registered."""

        def query(connection: Connection) -> list[RobotRecord]:
            rows = connection.execute(
                select(robots).where(robots.c.mission_id == mission_id).order_by(robots.c.registered_unix_s)
            )
            return [_robot(row) for row in rows]

        return await self._database.read(query)

    async def record_stop(self, mission_id: str, robot_ids: list[str], *, stopped: bool, all_: bool) -> None:
        """Keep who is stopped; on the disk before it returns. ``all_`` is the mission's own flag."""

        def work(connection: Connection) -> None:
            connection.execute(
                update(missions).where(missions.c.mission_id == mission_id).values(stopped_all=all_)
            )
            chosen = and_(robots.c.mission_id == mission_id, robots.c.robot_id.in_(robot_ids))
            connection.execute(update(robots).where(chosen).values(stopped=stopped))

        await self._database.write(work, durable=True)


def _robot(row: Row[tuple[object, ...]]) -> RobotRecord:
    values = dict(row._mapping)
    start = {name: values.pop(f"start_{name}") for name in ("x_m", "y_m", "yaw_rad", "sd_m", "sd_rad")}
    return RobotRecord(**values, start_pose=None if start["x_m"] is None else StartPoseRecord(**start))
