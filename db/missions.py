"""Missions and the robots registered in them."""

from __future__ import annotations

from dataclasses import asdict

from sqlalchemy import Connection, Row, and_, insert, select, update

from db.engine import Database
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
