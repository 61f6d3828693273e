"""Laws of the one writer: in order, failing alone, surviving whoever asked."""

from __future__ import annotations

import asyncio
from pathlib import Path

import pytest
from sqlalchemy import Connection, text
from sqlalchemy.exc import IntegrityError

from db.engine import Database
from db.errors import DatabaseError
from db.records import MissionRecord
from db.store import Store
from db.tables import missions


def _mission(mission_id: str) -> MissionRecord:
    return MissionRecord(mission_id, mission_id.upper(), "running", 1.0)


def _insert(mission_id: str):
    def work(connection: Connection) -> str:
        connection.execute(
            missions.insert().values(
                mission_id=mission_id, name="x", state="running", created_unix_s=1.0, stopped_all=False
            )
        )
        return mission_id

    return work


def _ids(connection: Connection) -> set[str]:
    return set(connection.scalars(missions.select().with_only_columns(missions.c.mission_id)))


def test_writes_that_wait_together_fail_alone(tmp_path: Path) -> None:
    async def scenario() -> None:
        database = await Database.open(tmp_path / "w.db")
        await database.write(_insert("there"))
        names = ["a", "there", "b", "a", "c"]
        outcomes = await asyncio.gather(
            *(database.write(_insert(name)) for name in names), return_exceptions=True
        )
        assert [type(outcome) for outcome in outcomes] == [str, DatabaseError, str, DatabaseError, str]
        assert await database.read(_ids) == {"there", "a", "b", "c"}
        await database.close()

    asyncio.run(scenario())


def test_a_write_that_fails_leaves_nothing(tmp_path: Path) -> None:
    def work(connection: Connection) -> None:
        _insert("half")(connection)
        raise ValueError("second half")

    async def scenario() -> None:
        database = await Database.open(tmp_path / "w.db")
        with pytest.raises(ValueError, match="second half"):
            await database.write(work)
        assert await database.read(_ids) == set()
        await database.close()

    asyncio.run(scenario())


def test_a_cancelled_caller_does_not_lose_its_write(tmp_path: Path) -> None:
    async def scenario() -> None:
        database = await Database.open(tmp_path / "w.db")
        callers = [asyncio.create_task(database.write(_insert(str(i)))) for i in range(20)]
        await asyncio.sleep(0)
        for caller in callers:
            caller.cancel()
        await asyncio.gather(*callers, return_exceptions=True)
        await database.close()
        again = await Database.open(tmp_path / "w.db")
        assert await again.read(_ids) == {str(i) for i in range(20)}
        await again.close()

    asyncio.run(scenario())


def test_readers_see_only_whole_writes_and_cannot_write(tmp_path: Path) -> None:
    async def scenario() -> None:
        database = await Database.open(tmp_path / "w.db")

        def two(connection: Connection) -> None:
            _insert("one")(connection)
            _insert("two")(connection)

        writes = asyncio.create_task(database.write(two))
        seen = {len(await database.read(_ids)) for _ in range(20)}
        await writes
        assert seen <= {0, 2}
        with pytest.raises(DatabaseError, match="cannot be written"):
            await database.read(_insert("three"))
        await database.close()
        with pytest.raises(DatabaseError, match="is closed"):
            await database.write(_insert("late"))

    asyncio.run(scenario())


def test_durable_writes_reach_the_disk_with_full_sync(tmp_path: Path) -> None:
    def level(connection: Connection) -> int:
        return int(connection.execute(text("PRAGMA synchronous")).scalar_one())

    async def scenario() -> None:
        database = await Database.open(tmp_path / "w.db")
        assert await database.write(level, durable=True) == 2
        assert await database.write(level) == 1
        await database.close()

    asyncio.run(scenario())


def test_what_was_written_is_there_after_a_restart(tmp_path: Path) -> None:
    async def scenario() -> None:
        store = await Store.open(tmp_path / "w.db")
        await asyncio.gather(*(store.missions.create_mission(_mission(f"m{i}")) for i in range(30)))
        with pytest.raises(DatabaseError) as refused:
            await store.missions.create_mission(_mission("m3"))
        assert isinstance(refused.value.__cause__, IntegrityError | None)
        await store.close()
        store = await Store.open(tmp_path / "w.db")
        assert {mission.mission_id for mission in await store.missions.all_missions()} == {
            f"m{i}" for i in range(30)
        }
        await store.close()

    asyncio.run(scenario())
