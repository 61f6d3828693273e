"""What goes into the store comes out again, and nothing said earlier is lost."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from db.records import (
    AlertRecord,
    AnnotationRecord,
    EventRecord,
    MissionRecord,
    NodeRecord,
    ObservationRecord,
    PointRecord,
    RobotRecord,
    SnapshotRecord,
    StartPoseRecord,
    TagRecord,
)
from db.store import Store
from db.victim_records import SaidRecord, StartRecord, VictimRecord
from robots.graph_report import GraphReport

M = "mine"


@pytest.fixture
def story(tmp_path: Path) -> Callable[[Callable[[Store], Awaitable[None]]], None]:
    """Run functions on a store with one mission and one robot, closed and opened again in between."""

    def run(*parts: Callable[[Store], Awaitable[None]]) -> None:
        async def scenario() -> None:
            for number, part in enumerate(parts):
                store = await Store.open(tmp_path / "s.db")
                if number == 0:
                    await store.missions.create_mission(MissionRecord(M, "Mine", "running", 1.0))
                    await store.missions.register_robot(_robot("r1"))
                await part(store)
                await store.close()

        asyncio.run(scenario())

    return run


def _robot(robot_id: str, start: StartPoseRecord | None = None) -> RobotRecord:
    return RobotRecord(M, robot_id, "server", 2.0, "hold", start, b"{}", False, 3.0)


def _lines(*seqs: int) -> list[ObservationRecord]:
    return [ObservationRecord(seq, seq * 0.05, 100.0, b"body %d" % seq) for seq in seqs]


def test_missions_robots_and_who_is_stopped(story) -> None:
    start = StartPoseRecord(1.0, 2.0, 0.5, 0.1, 0.02)

    async def first(store: Store) -> None:
        await store.missions.register_robot(_robot("r2", start))
        await store.missions.record_stop(M, ["r2"], stopped=True, all_=True)

    async def second(store: Store) -> None:
        assert (await store.missions.all_missions())[0].stopped_all
        robots = {robot.robot_id: robot for robot in await store.missions.robots_of(M)}
        assert robots["r2"].start_pose == start
        assert robots["r1"].start_pose is None
        assert (robots["r1"].stopped, robots["r2"].stopped) == (False, True)

    story(first, second)


def test_appending_again_changes_nothing(story) -> None:
    async def first(store: Store) -> None:
        await store.log.append_observations(M, "r1", _lines(0, 1, 2))
        await store.log.append_observations(M, "r1", [ObservationRecord(2, 9.0, 100.0, b"other"), *_lines(3)])
        await store.log.append_observations(M, "r1", [])

    async def second(store: Store) -> None:
        found = [record async for record in store.log.observations_after(M, "r1", -1)]
        assert found == _lines(0, 1, 2, 3)
        assert await store.log.last_observation(M, "r1") == _lines(3)[0]
        assert await store.log.last_observation(M, "nobody") is None

    story(first, second)


def test_the_log_streams_in_order_over_many_pages_with_its_faults(story) -> None:
    async def part(store: Store) -> None:
        await store.log.append_observations(M, "r1", _lines(*range(700)))
        await store.log.record_fault(M, "r1", 300, "the agent died on it")
        found = [record async for record in store.log.observations_after(M, "r1", 9, until=650)]
        assert [record.seq for record in found] == list(range(10, 651))
        assert {record.seq: record.fault for record in found if record.fault} == {300: "the agent died on it"}

    story(part)


def test_the_latest_snapshot_replaces_the_earlier(story) -> None:
    async def part(store: Store) -> None:
        assert await store.log.latest_snapshot(M, "r1") is None
        for seq in (10, 20):
            await store.log.record_snapshot(M, "r1", SnapshotRecord(seq, b"s%d" % seq, ((seq, "{}"),)))
        assert await store.log.latest_snapshot(M, "r1") == SnapshotRecord(20, b"s20", ((20, "{}"),))

    story(part)


def test_a_graph_is_replaced_whole_and_comes_back_exactly(story) -> None:
    rng = np.random.default_rng(1)

    def graph(n: int, m: int) -> GraphReport:
        return GraphReport(
            poses=rng.normal(size=(n, 3)),
            stamps_s=np.arange(n, dtype=float),
            yaws_rad=np.where(np.arange(n) % 2 == 0, np.nan, 0.5),
            tag_ids=tuple(f"T{i}" for i in range(m)),
            tags=rng.normal(size=(m, 2)),
            edge_pairs=np.array([(i, i + 1) for i in range(n - 1)], dtype=np.int64).reshape(-1, 2),
            edge_poses=rng.normal(size=(n - 1, 3)),
            edge_covariances=rng.normal(size=(n - 1, 3, 3)),
            sighting_pairs=np.array([(i, i) for i in range(m)], dtype=np.int64).reshape(-1, 2),
            sighting_offsets=rng.normal(size=(m, 2)),
            sighting_covariances=rng.normal(size=(m, 2, 2)),
            loop_pairs=np.array([(0, i) for i in range(m)], dtype=np.int64).reshape(-1, 2),
            loop_poses=rng.normal(size=(m, 3)),
            loop_covariances=rng.normal(size=(m, 3, 3)),
            meeting_robots=tuple(f"r{i}" for i in range(m)),
            meeting_poses=np.arange(m, dtype=np.int64),
            meeting_stamps_s=rng.normal(size=m),
            meeting_offsets=rng.normal(size=(m, 2)),
            meeting_covariances=rng.normal(size=(m, 2, 2)),
        )

    async def part(store: Store) -> None:
        assert await store.graphs.graph_of(M, "r1") is None
        for wanted in (graph(5, 3), graph(3, 2), graph(1, 0)):
            await store.graphs.record_graph(M, "r1", wanted)
            found = await store.graphs.graph_of(M, "r1")
            assert found is not None
            for name in GraphReport.__slots__:
                if name in ("tag_ids", "meeting_robots"):
                    assert getattr(found, name) == getattr(wanted, name)
                else:
                    np.testing.assert_array_equal(getattr(found, name), getattr(wanted, name))

    story(part)


def test_tags_and_every_version_of_their_memory(story) -> None:
    def union(a: bytes, b: bytes) -> bytes:
        return bytes(sorted({*a, *b}))

    async def first(store: Store) -> None:
        place = PointRecord(1.0, 2.0, 0.1, 0.0, 0.1)
        await store.tags.record_tags(M, [TagRecord("A", place, 1, ("r1",)), TagRecord("B", place, 1, ())])
        await store.tags.record_tags(
            M, [TagRecord("A", PointRecord(3.0, 2.0, 0.1, 0.0, 0.1), 2, ("r1", "r2"))]
        )
        assert await store.tags.memory_of(M, "A") == (0, b"")
        memories = [b"a", b"b", b"ab", b"c"]
        merged = [
            await store.tags.merge_memory(M, "A", memory, union, by="phone", unix_s=1.0)
            for memory in memories
        ]
        assert merged == [b"a", b"ab", b"ab", b"abc"]

    async def second(store: Store) -> None:
        found = await store.tags.tags_of(M)
        assert [(tag.tag_id, tag.place.x_m, tag.robots) for tag in found] == [
            ("A", 3.0, ("r1", "r2")),
            ("B", 1.0, ()),
        ]
        assert await store.tags.memory_of(M, "A") == (3, b"abc")

    story(first, second)


def test_the_latest_reading_of_a_node_and_its_alerts(story) -> None:
    early = NodeRecord("N1", 20.0, None, 0.0, None, 1.0, "r1")
    late = replace(early, temperature_c=80.0, pressure_hpa=1013.0, heard_unix_s=2.0)
    alert = AlertRecord("hot:N1", "hot", "It is hot at node N1: 80 °C.", "alarm", 2.0, "r1", "N1")
    noted = replace(alert, acknowledged_by="Ada", acknowledged_unix_s=3.0)

    async def first(store: Store) -> None:
        await store.nodes.record_readings(M, [early, replace(early, tag_id="N2")])
        await store.nodes.record_readings(M, [late])
        await store.alerts.record_alert(M, alert)
        assert await store.alerts.alerts_of(M) == [alert]
        await store.alerts.record_alert(M, noted)

    async def second(store: Store) -> None:
        assert await store.nodes.readings_of(M) == [late, replace(early, tag_id="N2")]
        assert await store.alerts.alerts_of(M) == [noted]

    story(first, second)


SAID = {
    "status": "reached",
    "note": "conscious",
    "live": 1,
    "start": StartRecord(walks=False, breaths_per_min=20),
    "place_m": (1.5, 2.5),
    "merged_into": "2",
    "by": "Ada",
}


def test_what_people_said_of_a_victim_outlives_new_measurements(story) -> None:
    def victim(x_m: float, **said: Any) -> VictimRecord:
        place = PointRecord(x_m, 0.0, 0.1, 0.0, 0.1)
        return VictimRecord("1", place, 0.9, 3, ("r1",), 1.0, 2.0, SaidRecord(**said))

    async def first(store: Store) -> None:
        await store.findings.record_victims(M, [victim(1.0)])
        await store.findings.record_said(M, victim(0.0, **SAID))
        await store.findings.record_victims(M, [victim(5.0)])

    async def second(store: Store) -> None:
        assert await store.findings.victims_of(M) == [victim(5.0, **SAID)]

    story(first, second)


def test_only_victims_nobody_spoke_of_are_forgotten(story) -> None:
    def victim(victim_id: str, by: str) -> VictimRecord:
        return VictimRecord(victim_id, PointRecord(0, 0, 1, 0, 1), 0.9, 3, (), 1.0, 2.0, SaidRecord(by=by))

    async def part(store: Store) -> None:
        await store.findings.record_victims(M, [victim("1", ""), victim("2", "Ada"), victim("3", "")])
        await store.findings.forget_victims(M, ["1", "2"])
        assert [found.victim_id for found in await store.findings.victims_of(M)] == ["2", "3"]

    story(part)


def test_annotations_and_events(story) -> None:
    note = AnnotationRecord(
        "11111111-1111-4111-8111-111111111111",
        "hazard",
        "gas",
        1.0,
        2.0,
        None,
        "Ada",
        1.0,
        1.0,
        ((0.0, 1.0),) * 3,
    )

    async def first(store: Store) -> None:
        await store.findings.record_annotation(M, note)
        await store.findings.record_annotation(M, note)
        events = [
            await store.findings.record_event(M, EventRecord(0, float(i), "note", f"event {i}", None, "info"))
            for i in range(10)
        ]
        assert [event.event_id for event in events] == sorted({event.event_id for event in events})

    async def second(store: Store) -> None:
        assert await store.findings.annotations_of(M) == [note]
        await store.findings.record_annotation(M, note, deleted=True)
        assert await store.findings.annotations_of(M) == []
        latest = await store.findings.latest_events(M, 4)
        assert [event.text for event in latest] == ["event 6", "event 7", "event 8", "event 9"]
        after = await store.findings.events_after(M, latest[1].event_id, 10)
        assert after == latest[2:]
        assert await store.findings.events_after("other", 0, 10) == []

    story(first, second)
